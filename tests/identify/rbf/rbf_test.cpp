// Radial networks: exact derivatives, forward selection against brute force, and the book's examples.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <Eigen/QR>
#include <cmath>

#include "identify/error.h"
#include "identify/mlp/fit_mlp.h"
#include "identify/model_file/model_file.h"
#include "identify/random.h"
#include "identify/rbf/rbf_network.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using ::testing::Contains;

double rms(const MatrixXd& e) { return std::sqrt(e.array().square().mean()); }

// z = sin(0.4 x^3 - 1.6 y^2 + 0.5) on 21 x 21 points of [-1, 1]^2, (1.10) of the book.
struct Surface {
  MatrixXd x{441, 2}, z{441, 1};
  Surface() {
    for (Index i = 0; i < 441; ++i) {
      x.row(i) << -1 + 0.1 * static_cast<double>(i % 21), -1 + 0.1 * static_cast<double>(i / 21);
      z(i, 0) = std::sin(0.4 * std::pow(x(i, 0), 3) - 1.6 * std::pow(x(i, 1), 2) + 0.5);
    }
  }
  double deviation() const { return rms(z.array() - z.mean()); }
};

class EveryRadial : public ::testing::TestWithParam<Radial> {};

TEST_P(EveryRadial, HasTheDerivativeOfItsInputs) {
  const Surface s;
  RbfOptions options;
  options.function = GetParam();
  options.functions = 6;
  options.centres = RbfCentres::box;
  options.width = 0.4;
  const RbfFit fit = fit_rbf(s.x, s.z, options);
  std::vector<double> scratch(static_cast<std::size_t>(fit.model->scratch_size()));
  const VectorXd at = (VectorXd(2) << 0.3, -0.45).finished();
  VectorXd slope(2);
  fit.model->derivative(at.data(), slope.data(), scratch.data());
  for (Index d = 0; d < 2; ++d) {
    const double h = 1e-3;
    const auto value = [&](double step) {
      VectorXd moved = at;
      moved[d] += step;
      double y = 0;
      fit.model->evaluate(moved.data(), &y, scratch.data());
      return y;
    };
    EXPECT_NEAR(slope[d], (8 * (value(h) - value(-h)) - (value(2 * h) - value(-2 * h))) / (12 * h), 1e-8);
  }
}

INSTANTIATE_TEST_SUITE_P(Radials, EveryRadial,
                         ::testing::Values(Radial::gaussian, Radial::gaussian_list, Radial::logistic, Radial::linear,
                                           Radial::quadratic, Radial::thin_plate, Radial::multiquadric),
                         [](const auto& text) { return name_of(text.param); });

TEST(Radial, HasItsValues) {
  EXPECT_DOUBLE_EQ(radial_value(Radial::gaussian, 2), std::exp(-1));
  EXPECT_DOUBLE_EQ(radial_value(Radial::gaussian_list, 2), std::exp(-2));
  EXPECT_DOUBLE_EQ(radial_value(Radial::logistic, 0), 0.5);
  EXPECT_DOUBLE_EQ(radial_value(Radial::linear, 4), 2);
  EXPECT_DOUBLE_EQ(radial_value(Radial::thin_plate, 4), 4 * std::log(2));
  EXPECT_DOUBLE_EQ(radial_value(Radial::thin_plate, 0), 0);
  EXPECT_DOUBLE_EQ(radial_value(Radial::multiquadric, 3), 2);
}

// The same centres as trying every column and solving anew.
TEST(Ols, ChoosesAsBruteForceDoes) {
  Random random(4);
  MatrixXd p(60, 20), d(60, 2);
  for (double& v : p.reshaped()) v = random.normal();
  for (double& v : d.reshaped()) v = random.normal();
  const OlsSelection selection = select_columns(p, d, 6);
  std::vector<Index> chosen;
  double before = d.squaredNorm();
  for (int round = 0; round < 6; ++round) {
    Index best = -1;
    double least = 0;
    for (Index c = 0; c < 20; ++c) {
      std::vector<Index> trial = chosen;
      trial.push_back(c);
      const MatrixXd columns = p(Eigen::all, trial);
      const double error = (d - columns * columns.colPivHouseholderQr().solve(d)).squaredNorm();
      if (best < 0 || error < least) best = c, least = error;
    }
    chosen.push_back(best);
    EXPECT_NEAR(selection.ratios[static_cast<std::size_t>(round)], (before - least) / d.squaredNorm(), 1e-12);
    before = least;
  }
  EXPECT_EQ(selection.columns, chosen);
}

// Wide functions are nearly dependent; what is left of each must stay orthogonal to all that was chosen.
TEST(Ols, ChoosesAsBruteForceDoesAmongNearlyDependentFunctions) {
  const Index rows = 80, candidates = 25;
  MatrixXd p(rows, candidates);
  VectorXd d(rows);
  for (Index k = 0; k < rows; ++k) {
    const double x = static_cast<double>(k) / (rows - 1);
    d[k] = std::sin(9 * x) + x * x;
    for (Index c = 0; c < candidates; ++c) {
      const double distance = x - static_cast<double>(c) / (candidates - 1);
      p(k, c) = std::exp(-distance * distance / (2 * 0.15 * 0.15));
    }
  }
  const OlsSelection selection = select_columns(p, d, 7);
  ASSERT_EQ(selection.columns.size(), 7U);
  std::vector<Index> chosen;
  double before = d.squaredNorm();
  for (std::size_t round = 0; round < 7; ++round) {
    double least = HUGE_VAL;
    for (Index c = 0; c < candidates; ++c) {
      std::vector<Index> trial = chosen;
      trial.push_back(c);
      const MatrixXd columns = p(Eigen::all, trial);
      least = std::min(least, (d - columns * columns.householderQr().solve(d)).squaredNorm());
    }
    EXPECT_NEAR(selection.ratios[round], (before - least) / d.squaredNorm(), 1e-12);
    chosen.push_back(selection.columns[round]);
    before = least;
  }
}

TEST(Ols, StopsWhereNothingIsLeft) {
  MatrixXd p(4, 3);
  p << 1, 2, 0, 0, 0, 1, 1, 2, 0, 0, 0, 1;
  EXPECT_EQ(select_columns(p, VectorXd::LinSpaced(4, 1, 4), 3).columns.size(), 2U);
}

// 18 wide functions: a ridge of 1e-8, once the default, took a quarter of the variance away that the report told of.
TEST(FitRbf, TheReportSaysWhatTheModelExplains) {
  const Surface s;
  const auto explained = [&](const RbfFit& fit) {
    MatrixXd y(441, 1);
    std::vector<double> scratch(static_cast<std::size_t>(fit.model->scratch_size()));
    for (Index i = 0; i < 441; ++i) {
      const VectorXd x = s.x.row(i).transpose();
      fit.model->evaluate(x.data(), &y(i, 0), scratch.data());
    }
    return 1 - std::pow(rms(s.z - y) / s.deviation(), 2);
  };
  for (const double width : {0.3, 0.7, 1.0}) {
    RbfOptions options;
    options.functions = 18;
    options.width = width;
    const RbfFit plain = fit_rbf(s.x, s.z, options);
    double said = 0;
    for (const double ratio : plain.ratios) said += ratio;
    EXPECT_NEAR(explained(plain), said, 1e-5);
    options.ridge = 1e-3;
    const RbfFit ridge = fit_rbf(s.x, s.z, options);
    EXPECT_THAT(
        ridge.report.tried,
        Contains(fmt::format("the weights, with ridge 0.001, explain {:.6g} of the variance", explained(ridge))));
  }
}

TEST(FitRbf, RefusesATolerance) {
  const Surface s;
  for (const double tolerance : {-1.0, 1.0, 2.0}) {
    RbfOptions options;
    options.tolerance = tolerance;
    try {
      fit_rbf(s.x, s.z, options);
      ADD_FAILURE();
    } catch (const IdentifyError& error) {
      EXPECT_EQ(
          error.what(),
          fmt::format("the tolerance is the part of the variance that may stay unexplained, 0 or more and less than "
                      "1; it is {:g}",
                      tolerance));
    }
  }
}

// Figures 1.18 to 1.21 of the book: 3, 5, 11 and 31 functions of width 0.1 of the normalised range.
TEST(FitRbf, ReachesTheBooksErrors) {
  const Surface s;
  RbfOptions options;
  options.width = 0.1;
  options.constant = false;
  options.ridge = 0;
  const auto error = [&](int functions) {
    options.functions = functions;
    return rms(evaluate_rows(*fit_rbf(s.x, s.z, options).model, s.x) - s.z) / s.deviation();
  };
  EXPECT_NEAR(error(3), 0.777, 0.01);
  EXPECT_NEAR(error(5), 0.626, 0.01);
  EXPECT_NEAR(error(11), 0.379, 0.015);
  EXPECT_NEAR(error(31), 0.088, 0.015);
}

TEST(FitRbf, GetsBetterWhenCentresAndWidthsAreOptimisedToo) {
  const Surface s;
  RbfOptions options;
  options.functions = 6;
  options.width = 0.2;
  options.ridge = 0;
  const double before = rms(evaluate_rows(*fit_rbf(s.x, s.z, options).model, s.x) - s.z);
  options.optimise = true;
  options.iterations = 60;
  const RbfFit fit = fit_rbf(s.x, s.z, options);
  EXPECT_LT(rms(evaluate_rows(*fit.model, s.x) - s.z), 0.2 * before);
}

// y(k+1) = 0.2 tanh(y(k)) + sin(u(k)), Figure 1.23: twenty random centres do.
TEST(FitRbf, LearnsTheBooksDynamicExample) {
  Random random(5);
  MatrixXd u(2207, 1), y(2207, 1);
  double level = 0;
  y(0, 0) = 0;
  for (Index k = 0; k < 2207; ++k) {
    if (k % 3 == 0) level = random.uniform(-1, 1);
    u(k, 0) = level;
    if (k > 0) y(k, 0) = 0.2 * std::tanh(y(k - 1, 0)) + std::sin(u(k - 1, 0));
  }
  const DataSet data = make_data_set(u, y, 1, {{"u", ""}}, {{"y", ""}});
  const RegressorSet regressors = parse_regressors("y(k-1), u(k-1)", data);
  const Regression rows = make_regression(data, regressors);
  RbfOptions options;
  options.centres = RbfCentres::box;
  options.seed = 3;
  const RbfFit fit = fit_rbf(rows.X, rows.Y, options);
  const NarxModel model = make_narx(fit.model, regressors, data, fit.report);
  EXPECT_LT(rms(evaluate_rows(*fit.model, rows.X) - rows.Y), 0.035);
  EXPECT_LT(rms(free_run(model, data)[0] - y), 0.039);
  const std::string text = to_yaml(model);
  const NarxModel back = read_narx(read_model_file(text, "rbf.yaml"));
  EXPECT_EQ(to_yaml(back), text);
  EXPECT_EQ(free_run(back, data)[0], free_run(model, data)[0]);
}

TEST(FitRbf, WarnsOfWhatItsFunctionsCannotDo) {
  const Surface s;
  RbfOptions options;
  options.function = Radial::quadratic;
  const FitReport report = fit_rbf(s.x, s.z, options).report;
  EXPECT_THAT(report.warnings,
              Contains("Sums of r^2 are quadratic functions of the inputs, so more than 4 functions add nothing."));
  EXPECT_THAT(report.warnings,
              Contains("'quadratic' grows without bound away from the data, so a simulated model may do so too."));
  EXPECT_THAT(fit_rbf(s.x, MatrixXd::Ones(441, 1)).report.warnings,
              Contains("All targets are equal, so nothing can be learned from them."));
}

template <typename Action>
std::string complaint(const Action& action) {
  try {
    action();
  } catch (const IdentifyError& error) {
    return error.what();
  }
  return "none";
}

TEST(RbfErrors, AreInTheUsersWords) {
  const Surface s;
  RbfOptions options;
  options.width = 0;
  EXPECT_EQ(complaint([&] { fit_rbf(s.x, s.z, options); }), "the width is 0; it must be greater than 0");
  EXPECT_EQ(complaint([] { find_rbf_centres("kmeans"); }),
            "there is no choice of centres 'kmeans'; there are ols, box, spread");
  EXPECT_EQ(complaint([] { find_radial("bump"); }),
            "there is no radial function 'bump'; there are gaussian, gaussian_list, logistic, linear, quadratic, "
            "thin_plate, multiquadric");
}

}  // namespace
}  // namespace plantloop::identify
