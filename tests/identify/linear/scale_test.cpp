// The units of signals are a choice of the user's, so no estimate may depend on them.

#include <gtest/gtest.h>

#include <cmath>

#include "identify/data/excitation.h"
#include "identify/linear/filter.h"
#include "identify/linear/fit_linear.h"
#include "identify/linear/state_space.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// y = B/F u + C/D v of order 2, in the units us and ys.
DataSet record(double us, double ys) {
  const VectorXd u = staircase(500, 3, 12, -1, 1, 4);
  const VectorXd w = filter(Eigen::Vector3d(0, 0.3, 0.2), Eigen::Vector3d(1, -1.2, 0.5), u);
  const VectorXd v = filter(Eigen::Vector2d(1, 0.4), Eigen::Vector2d(1, -0.6), white_noise(500, 0.05, 7));
  return make_data_set(us * u, ys * (w + v), 1);
}

using Fit = PolynomialModel (*)(const DataSet&);
struct Case {
  const char* name;
  Fit fit;
};

const Case cases[] = {
    {"FIR", [](const DataSet& d) { return fit_linear(d, {.nb = {8}}); }},
    {"ARX", [](const DataSet& d) { return fit_linear(d, {.na = 2, .nb = {2}}); }},
    {"ARMAX", [](const DataSet& d) { return fit_linear(d, {.na = 2, .nc = 1, .nb = {2}}); }},
    {"OE", [](const DataSet& d) { return fit_linear(d, {.nb = {2}, .nf = {2}}); }},
    {"BJ", [](const DataSet& d) { return fit_linear(d, {.nc = 1, .nd = 1, .nb = {2}, .nf = {2}}); }},
    {"OE with an offset", [](const DataSet& d) { return fit_linear(d, {.nb = {2}, .nf = {2}}, {.offset = true}); }},
    {"filtered", [](const DataSet& d) { return fit_filtered(d, {.na = 2, .nb = {2}}); }},
    {"instrumental", [](const DataSet& d) { return fit_instrumental(d, {.na = 2, .nb = {2}}); }},
};

TEST(Units, OfSignalsScaleLinearModelsAndNothingElse) {
  for (const Case& c : cases) {
    const PolynomialModel plain = c.fit(record(1, 1));
    for (const double us : {1e-12, 1e-6, 1e3, 1e12}) {
      for (const double ys : {1 / us, us, 1.0}) {
        SCOPED_TRACE(fmt::format("{}: u {:g}, y {:g}", c.name, us, ys));
        const PolynomialModel m = c.fit(record(us, ys));
        // In units of the plain model's.
        PolynomialModel back = m;
        for (VectorXd& b : back.B) b *= us / ys;
        back.offset /= ys;
        const VectorXd difference = back.parameters() - plain.parameters();
        const VectorXd deviations = plain.covariance.diagonal().cwiseSqrt();
        for (Index i = 0; i < difference.size(); ++i) EXPECT_LT(std::fabs(difference[i]), 1e-4 * deviations[i]) << i;
        EXPECT_NEAR(m.variance / (ys * ys) / plain.variance, 1, 1e-8);
        EXPECT_NEAR(m.fit.reached / (ys * ys) / plain.fit.reached, 1, 1e-8);
        EXPECT_EQ(m.fit.warnings.size(), plain.fit.warnings.size());
        PolynomialModel units = m;
        units.set_parameters(VectorXd::Ones(difference.size()));
        for (VectorXd& b : units.B) b *= ys / us;
        if (units.has_offset) units.offset = ys;
        const VectorXd factor = units.parameters();
        for (Index i = 0; i < difference.size(); ++i) {
          EXPECT_NEAR(std::sqrt(m.covariance(i, i)) / factor[i] / deviations[i], 1, 1e-4) << i;
        }
      }
    }
  }
}

TEST(Units, ThatArePowersOfTwoChangeNoBit) {
  const double us = std::exp2(37), ys = std::exp2(-29);
  for (const Case& c : cases) {
    SCOPED_TRACE(c.name);
    const PolynomialModel plain = c.fit(record(1, 1)), m = c.fit(record(us, ys));
    EXPECT_EQ(m.A, plain.A);
    EXPECT_EQ(m.C, plain.C);
    EXPECT_EQ(m.F[0], plain.F[0]);
    EXPECT_EQ(m.B[0], VectorXd(plain.B[0] * (ys / us)));
    EXPECT_EQ(m.variance, plain.variance * ys * ys);
  }
}

TEST(Units, OfOneOutputDoNotOutweighTheOtherInTheSubspaceMethod) {
  const DataSet first = record(1, 1);
  DataSet both = first;
  both.outputs.push_back({"z", ""});
  Experiment& e = both.experiments[0];
  e.y.conservativeResize(Eigen::NoChange, 2);
  e.y.col(1) =
      filter(Eigen::Vector2d(0, 0.4), Eigen::Vector2d(1, -0.9), VectorXd(e.u.col(0))) + white_noise(500, 0.05, 8);
  const MatrixXd plain = simulate(fit_subspace(both, {.order = 3}), both)[0];
  for (const double unit : {1e-12, 1e-3, 1e6, 1e12}) {
    DataSet scaled = both;
    scaled.experiments[0].y.col(1) *= unit;
    scaled.experiments[0].u /= unit;
    const StateSpaceModel m = fit_subspace(scaled, {.order = 3});
    const MatrixXd y = simulate(m, scaled)[0];
    EXPECT_LT((y.col(0) - plain.col(0)).cwiseAbs().maxCoeff(), 1e-8) << unit;
    EXPECT_LT((y.col(1) / unit - plain.col(1)).cwiseAbs().maxCoeff(), 1e-8) << unit;
  }
}

}  // namespace
}  // namespace plantloop::identify
