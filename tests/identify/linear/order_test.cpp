// Order and delay: tables against single fits, and the book's test of the information matrix.

#include "identify/linear/order.h"

#include <gtest/gtest.h>

#include "identify/data/excitation.h"
#include "identify/linear/filter.h"
#include "identify/validation/metrics.h"

namespace plantloop::identify {
namespace {

// The textbook's transfer function of the motor-generator with white noise at its output.
DataSet textbook(double sigma) {
  const Eigen::VectorXd u = prbs(7, 5, 1);
  Eigen::VectorXd B(5);
  B << 0, 0, 0, 0.0554, -0.0215;
  Eigen::VectorXd y = filter(B, Eigen::Vector3d(1, -1.743, 0.7816), u);
  if (sigma > 0) y += white_noise(u.size(), sigma, 5);
  return make_data_set(u, y, 0.02);
}

TEST(ArxTable, EachCandidateIsTheLeastSquaresFitOfTheSameRows) {
  const DataSet data = textbook(0.02);
  const ArxTable table = arx_table(data, {.na_least = 1, .na_most = 3, .nb_least = 1, .nb_most = 3, .delay_most = 3});
  EXPECT_EQ(table.candidates.size(), 36U);
  EXPECT_EQ(table.rows, 635 - 6);
  for (const ArxCandidate& c : table.candidates) {
    // The same rows by leaving out the first samples that this candidate would have used in addition.
    const int own = c.orders.longest_lag();
    const PolynomialModel single = fit_linear(part(data, 6 - own, 635), c.orders);
    EXPECT_NEAR(single.fit.reached * static_cast<double>(table.rows), c.sse, 1e-9 * c.sse);
    EXPECT_DOUBLE_EQ(c.aic, akaike(c.sse, 629, c.parameters));
  }
}

TEST(ArxTable, FindsTheStructureOfAnArxProcess) {
  const Eigen::VectorXd u = prbs(9);
  const Eigen::VectorXd e = white_noise(u.size(), 0.3, 2);
  const Eigen::Vector3d A(1, -1.5, 0.7);
  const Eigen::VectorXd y = filter(Eigen::Vector4d(0, 0, 1, 0.5), A, u) + filter(Eigen::VectorXd::Ones(1), A, e);
  const ArxTable table = arx_table(make_data_set(u, y, 1), {.na_most = 5, .nb_most = 5});
  const ArxCandidate& best = table.candidates[table.best_mdl];
  EXPECT_EQ(best.orders.na, 2);
  EXPECT_EQ(best.orders.nb[0], 2);
  EXPECT_EQ(best.orders.delay[0], 1);
}

TEST(InformationTest, HasTheBooksDecadesAndVerdict) {
  const InformationTest test = information_test(textbook(0.02), 4, 2);
  const double expected[] = {0.311, 4.4e-4, 2.3e-7, 7.6e-11};
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_LT(test.determinants[i], 4 * expected[i]);
    EXPECT_GT(test.determinants[i], expected[i] / 4);
  }
  EXPECT_EQ(test.order, 2);
  EXPECT_LT(information_test(textbook(0), 3, 2).determinants[2], 1e-15);
}

TEST(DelayTable, FindsTheDelayInNoiseAndExactlyWithout) {
  const auto noisy = delay_table(textbook(0.05), 2, 0, 4);
  const double expected[] = {0.0517, 0.0514, 0.0496, 0.0643, 0.1089};
  for (std::size_t i = 0; i < 5; ++i) EXPECT_NEAR(noisy[i].rmse, expected[i], 0.08 * expected[i]) << i;
  const auto exact = delay_table(textbook(0), 2, 1, 3);
  EXPECT_LT(exact[1].rmse, 1e-10);
  EXPECT_GT(exact[0].rmse, 1e-5);
}

}  // namespace
}  // namespace plantloop::identify
