// The motor-generator of the book's chapter 2: the estimates of a table computed independently.

#include "tests/identify/linear/motor.h"

#include <gtest/gtest.h>

#include "identify/linear/filter.h"
#include "identify/linear/fit_linear.h"
#include "identify/validation/metrics.h"

namespace plantloop::identify {
namespace {

const Orders second{.na = 2, .nb = {2}, .nf = {}, .delay = {2}};
const LinearOptions about_means{.output = "", .remove_means = true};

void expect_near(const Eigen::VectorXd& theta, const Eigen::Vector4d& expected, double tolerance) {
  ASSERT_EQ(theta.size(), 4);
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(theta[i], expected[i], tolerance) << "parameter " << i;
}

// a1, a2, b1, b2 of an OE model.
Eigen::VectorXd as_arx(const PolynomialModel& m) {
  Eigen::VectorXd theta(4);
  theta << m.F[0].tail(2), m.B[0];
  return theta;
}

TEST(Motor, RespondsAsTabulated) {
  const Eigen::VectorXd y = motor::respond(prbs(7, 5, 1));
  const int at[] = {0, 10, 50, 100, 300, 634};
  const double expected[] = {6.6375000, 7.2935875, 5.7061364, 6.1185736, 7.6429363, 6.7774079};
  // The table's plant has unrounded poles; wn and damping here are rounded to 5 decimals.
  for (int i = 0; i < 6; ++i) EXPECT_NEAR(y[at[i]], expected[i], 2e-6);
}

TEST(Motor, LeastSquaresWithoutNoise) {
  const PolynomialModel m = fit_linear(motor::prbs_record(), second, about_means);
  expect_near(m.parameters(), {-1.698939, 0.744852, 0.034048, 0.005565}, 1e-5);
}

TEST(Motor, LeastSquaresWithNoiseAndItsDeviations) {
  const PolynomialModel m = fit_linear(motor::prbs_record(0.0105), second, about_means);
  expect_near(m.parameters(), {-1.636143, 0.685166, 0.032362, 0.012466}, 1e-5);
  const Eigen::VectorXd deviations = m.covariance.diagonal().cwiseSqrt();
  const double expected[] = {0.01279, 0.01225, 0.00147, 0.00190};
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(deviations[i], expected[i], 0.02 * expected[i]);
}

TEST(Motor, FilteredLeastSquaresWithNoise) {
  const PolynomialModel m = fit_filtered(motor::prbs_record(0.0105), second, about_means);
  expect_near(as_arx(m), {-1.705559, 0.750585, 0.039203, 0.000565}, 2e-5);
}

TEST(Motor, MeansOverThirtySeedsAreThoseOfTheTable) {
  Eigen::Vector4d plain = Eigen::Vector4d::Zero();
  Eigen::Vector4d filtered = Eigen::Vector4d::Zero();
  for (std::uint32_t seed = 1; seed <= 30; ++seed) {
    const DataSet data = motor::prbs_record(0.0105, seed * 1009);
    plain += fit_linear(data, second, about_means).parameters() / 30;
    filtered += as_arx(fit_filtered(data, second, about_means)) / 30;
  }
  // 3 standard deviations of a difference of two means of 30.
  const double scatter[] = {0.0059, 0.0054, 0.0011, 0.0016};
  const double mean[] = {-1.6420, 0.6904, 0.0334, 0.0107};
  const double filtered_scatter[] = {0.0007, 0.0006, 0.0002, 0.0003};
  const double filtered_mean[] = {-1.7062, 0.7511, 0.0396, 0.0001};
  for (int i = 0; i < 4; ++i) {
    EXPECT_NEAR(plain[i], mean[i], 3 * scatter[i]) << i;
    EXPECT_NEAR(filtered[i], filtered_mean[i], 3 * filtered_scatter[i]) << i;
  }
}

TEST(Motor, TheFilteredModelSimulatesBetterInValidation) {
  const DataSet data = motor::prbs_record(0.0105);
  const DataSet validation = motor::record(square_wave(600, 50, 1), 0.0105, 11);
  const PolynomialModel plain = fit_linear(data, second, about_means);
  const PolynomialModel filtered = fit_filtered(data, second, about_means);
  const auto error = [&](const PolynomialModel& m) {
    return root_mean_square_error(validation.all_y().col(0), simulate(m, validation)[0]);
  };
  EXPECT_LT(3 * error(filtered), error(plain));
}

// The textbook's transfer function (0.0554 q^-1 - 0.0215 q^-2)/(1 - 1.743 q^-1 + 0.7816 q^-2) q^-2 with noise at the
// output.
DataSet textbook(double sigma, std::uint64_t seed) {
  const Eigen::VectorXd u = prbs(7, 5, 1);
  Eigen::VectorXd B(5);
  B << 0, 0, 0, 0.0554, -0.0215;
  Eigen::VectorXd y = filter(B, Eigen::Vector3d(1, -1.743, 0.7816), u);
  if (sigma > 0) y += white_noise(u.size(), sigma, seed);
  return make_data_set(u, y, 0.02);
}

TEST(Motor, OutputErrorFindsTheTextbookModelInNoise) {
  const PolynomialModel m = fit_linear(textbook(0.02, 3), {.nb = {2}, .nf = {2}, .delay = {2}});
  const Eigen::Vector4d truth(-1.743, 0.7816, 0.0554, -0.0215);
  const Eigen::VectorXd theta = as_arx(m);
  Eigen::Vector4d deviations;  // in the order a1, a2, b1, b2
  for (int i = 0; i < 4; ++i) deviations[i] = std::sqrt(m.covariance((i + 2) % 4, (i + 2) % 4));
  for (int i = 0; i < 4; ++i) EXPECT_LT(std::abs(theta[i] - truth[i]), 3 * deviations[i]) << i;
  // (0.0012, 0.0011, 0.0004, 0.0006) for the filtered estimate
  EXPECT_NEAR(deviations[0], 0.0012, 0.0006);
  EXPECT_NEAR(deviations[2], 0.0004, 0.0002);
  const PolynomialModel filtered = fit_filtered(textbook(0.02, 3), second);
  for (int i = 0; i < 4; ++i) EXPECT_LT(std::abs(as_arx(filtered)[i] - theta[i]), deviations[i]) << i;
  EXPECT_LE(filtered.fit.iterations, 12);
}

TEST(Motor, WithOneNumeratorCoefficientTheModelIsTheBooks) {
  const PolynomialModel m = fit_linear(textbook(0, 0), {.nb = {1}, .nf = {2}, .delay = {2}});
  EXPECT_NEAR(m.B[0][0], 0.0401, 0.0003);
  EXPECT_NEAR(m.F[0][1], -1.7039, 0.003);
  EXPECT_NEAR(m.F[0][2], 0.7490, 0.003);
  EXPECT_NEAR(m.gain(0), 0.887, 0.005);
}

TEST(Motor, DelayIsFoundByOutputErrorAlsoInNoise) {
  const double expected[] = {0.0235, 0.0236, 0.0198, 0.0455, 0.0994};
  std::vector<double> found;
  for (int d = 0; d <= 4; ++d) {
    const DataSet data = textbook(0.02, 5);
    const PolynomialModel m = fit_linear(data, {.nb = {2}, .nf = {2}, .delay = {d}});
    found.push_back(root_mean_square_error(data.all_y().col(0), simulate(m, data, Start::zero)[0]));
    EXPECT_NEAR(found.back(), expected[d], 0.1 * expected[d]) << "delay " << d;
  }
  EXPECT_EQ(std::min_element(found.begin(), found.end()) - found.begin(), 2);
}

}  // namespace
}  // namespace plantloop::identify
