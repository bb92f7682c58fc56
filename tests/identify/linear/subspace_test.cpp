// The subspace method against known poles, and state-space forms against the polynomials they come from.

#include <gtest/gtest.h>

#include "identify/data/excitation.h"
#include "identify/error.h"
#include "identify/linear/filter.h"
#include "identify/linear/fit_linear.h"
#include "identify/linear/state_space.h"
#include "identify/model_file/model_file.h"

namespace plantloop::identify {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// (0.3 q^-1 + 0.2 q^-2)/(1 - 1.5 q^-1 + 0.7 q^-2) q^-d
DataSet record(int delay, double sigma) {
  const VectorXd u = prbs(9, 2);
  VectorXd B = VectorXd::Zero(delay + 3);
  B[delay + 1] = 0.3;
  B[delay + 2] = 0.2;
  VectorXd y = filter(B, Eigen::Vector3d(1, -1.5, 0.7), u);
  if (sigma > 0) y += white_noise(u.size(), sigma, 4);
  return make_data_set(u, y, 0.1);
}

TEST(Subspace, FindsOrderAndPolesExactlyWithoutNoise) {
  const StateSpaceModel m = fit_subspace(record(0, 0));
  ASSERT_EQ(m.order(), 2);
  const Eigen::VectorXcd z = m.poles();
  EXPECT_NEAR(z[0].real(), 0.75, 1e-9);
  EXPECT_NEAR(z[1].imag(), std::sqrt(0.7 - 0.5625), 1e-9);
  EXPECT_LT((simulate(m, record(0, 0))[0] - record(0, 0).all_y()).norm(), 1e-9);
}

TEST(Subspace, ADelayIsAFurtherState) {
  const StateSpaceModel m = fit_subspace(record(1, 0));
  ASSERT_EQ(m.order(), 3);
  const Eigen::VectorXcd z = m.poles();
  EXPECT_NEAR(std::abs(z[0]), 0, 1e-5);  // the delay's pole at 0
  EXPECT_NEAR(z[1].real(), 0.75, 1e-9);
  EXPECT_LT((simulate(m, record(1, 0))[0] - record(1, 0).all_y()).norm() / std::sqrt(1022.0), 2e-12);
}

TEST(Subspace, IsConsistentWithNoiseAtTheOutput) {
  const StateSpaceModel m = fit_subspace(record(0, 0.2));
  ASSERT_EQ(m.order(), 2);
  EXPECT_NEAR(m.poles()[0].real(), 0.75, 0.02);
  EXPECT_NEAR(std::abs(m.poles()[1].imag()), 0.3708, 0.02);
}

TEST(Subspace, TakesSeveralInputsOutputsAndExperiments) {
  MatrixXd u(600, 2);
  u << prbs(10, 1, 1, 600), white_noise(600, 1, 3);
  MatrixXd y(600, 2);
  y.col(0) = filter(Eigen::Vector2d(0, 1), Eigen::Vector2d(1, -0.8), u.col(0));
  y.col(1) = filter(Eigen::Vector2d(0.5, 0), Eigen::Vector2d(1, 0.5), u.col(1)) + y.col(0);
  DataSet data = make_data_set(u, y, 1);
  const auto [first, second] = split(data, 0.4);
  data = join(first, second);
  const StateSpaceModel m = fit_subspace(data, {.order = 2});
  const Eigen::VectorXcd z = m.poles();
  EXPECT_NEAR(z[0].real(), -0.5, 1e-9);
  EXPECT_NEAR(z[1].real(), 0.8, 1e-9);
  const auto s = simulate(m, data);
  EXPECT_LT((s[0] - first.all_y()).norm() + (s[1] - second.all_y()).norm(), 1e-9);
  const StateSpaceModel back = state_space_of(read_model_file(to_yaml("state_space", to_item(m)), "m.yaml"));
  EXPECT_EQ(back.A, m.A);
  EXPECT_EQ(simulate(back, data)[1], s[1]);
}

TEST(StateSpace, OfAPolynomialModelRespondsAlike) {
  const Orders orders{.na = 1, .nb = {2, 3}, .nf = {2, 0}, .delay = {-1, 2}};
  MatrixXd u(100, 2);
  u << white_noise(100, 1, 1), white_noise(100, 1, 2);
  const DataSet data = make_data_set(u, VectorXd::Zero(100), 1);
  PolynomialModel m = make_polynomial_model(orders, data, 0);
  m.set_parameters((VectorXd(8) << -0.5, 1, 0.4, 0.3, 0.2, 0.1, -0.9, 0.3).finished());
  m.u0 = Eigen::Vector2d(1, 2);
  m.y0 = 3;
  const StateSpaceModel s = to_state_space(m);
  EXPECT_LT((simulate(s, data, StateStart::zero)[0].col(0) - simulate(m, data, Start::zero)[0]).norm(), 1e-12);
}

TEST(Subspace, SaysWhenARecordIsTooShort) {
  const DataSet data = make_data_set(white_noise(40, 1, 1), white_noise(40, 1, 2), 1);
  try {
    fit_subspace(data);
    FAIL();
  } catch (const IdentifyError& e) {
    EXPECT_STREQ(e.what(),
                 "10 block rows of 2 signals need experiments with 59 samples or more in all; take fewer block rows");
  }
}

}  // namespace
}  // namespace plantloop::identify
