// What is done to data before a fit, and that it can be undone.

#include "identify/data/preprocess.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "identify/data/excitation.h"
#include "identify/error.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double nothing = std::numeric_limits<double>::quiet_NaN();

DataSet two_channels() {
  const VectorXd k = VectorXd::LinSpaced(50, 0, 49);
  const VectorXd u = white_noise(50, 2, 1).array() + 3;
  const VectorXd y = (white_noise(50, 0.5, 2) + 0.1 * k).array() - 7;
  return make_data_set(u, y, 0.1);
}

TEST(Preprocess, ALineThatIsRemovedLeavesNoSlopeAndComesBack) {
  const DataSet data = two_channels();
  const std::vector<Trend> trends = fit_trends(data, TrendKind::line);
  const DataSet flat = remove(data, trends);
  const Trend again = fit_trends(flat, TrendKind::line)[0];
  EXPECT_NEAR(again.y_slope[0], 0, 1e-14);
  EXPECT_NEAR(again.y_offset[0], 0, 1e-13);
  EXPECT_LT((restore(flat, trends).all_y() - data.all_y()).norm(), 1e-13);
}

TEST(Preprocess, TheMeanIsOneForAllExperimentsAndIgnoresGaps) {
  DataSet data = make_data_set(VectorXd::Ones(4), Eigen::Vector4d(1, 2, 3, nothing), 1);
  data = join(data, make_data_set(VectorXd::Ones(4), Eigen::Vector4d(4, 5, 6, 7), 1));
  const std::vector<Trend> trends = fit_trends(data, TrendKind::mean);
  ASSERT_EQ(trends.size(), 1U);
  EXPECT_DOUBLE_EQ(trends[0].y_offset[0], 4);
}

TEST(Preprocess, NormalisationIsThatOfTheIdentificationDataAndRemembersItself) {
  const DataSet data = two_channels();
  const Normalisation n = fit_normalisation(data);
  const DataSet scaled = n.apply(data);
  const VectorXd y = scaled.all_y().col(0);
  EXPECT_NEAR(y.mean(), 0, 1e-14);
  EXPECT_NEAR(y.squaredNorm() / 50, 1, 1e-13);
  EXPECT_LT((n.undo(scaled).all_u() - data.all_u()).norm(), 1e-13);
  EXPECT_DOUBLE_EQ(n.variances(Eigen::MatrixXd::Ones(1, 1))(0, 0), n.y_scale[0] * n.y_scale[0]);
  // Other data get the same scale, not their own.
  const DataSet shifted = make_data_set(data.all_u(), data.all_y().array() + 1, 0.1);
  EXPECT_NEAR(n.apply(shifted).all_y().mean(), 1 / n.y_scale[0], 1e-13);
}

TEST(Preprocess, AConstantChannelIsNamedAndNotDividedByZero) {
  const DataSet data = make_data_set(VectorXd::Constant(5, 0.1), VectorXd::LinSpaced(5, 0, 4), 1);
  for (const auto kind : {Normalisation::Kind::mean_and_deviation, Normalisation::Kind::least_and_greatest}) {
    const Normalisation n = fit_normalisation(data, kind);
    EXPECT_EQ(n.constant, std::vector<std::string>{"u"});
    EXPECT_TRUE(n.apply(data).all_u().allFinite());
  }
  const DataSet range = fit_normalisation(data, Normalisation::Kind::least_and_greatest).apply(data);
  EXPECT_EQ(range.all_y()(4, 0), 1);
}

TEST(Preprocess, ResamplingKeepsASlowSineAndRemovesAFastOne) {
  const Index count = 400;
  VectorXd slow(count);
  VectorXd fast(count);
  for (Index k = 0; k < count; ++k) {
    slow[k] = std::sin(2 * std::numbers::pi * 0.02 * static_cast<double>(k));
    fast[k] = std::sin(2 * std::numbers::pi * 0.4 * static_cast<double>(k));
  }
  const DataSet data = make_data_set(fast, slow, 1);
  const DataSet half = resample(data, 1, 2);
  EXPECT_EQ(half.Ts, 2);
  ASSERT_EQ(half.samples(), 200);
  const DataSet finer = resample(data, 3, 2);
  for (Index k = 30; k < 170; ++k) {  // away from the ends
    EXPECT_NEAR(half.all_y()(k, 0), slow[2 * k], 2e-3);
    EXPECT_NEAR(half.all_u()(k, 0), 0, 2e-3);
    EXPECT_NEAR(finer.all_y()(3 * k / 2, 0),
                std::sin(2 * std::numbers::pi * 0.02 * static_cast<double>(3 * k / 2) * 2 / 3), 2e-3);
  }
  const DataSet flat = resample(make_data_set(VectorXd::Constant(20, 5), VectorXd::Constant(20, 5), 1), 2, 3);
  EXPECT_LT((flat.all_y().array() - 5).abs().maxCoeff(), 1e-14);
}

TEST(Preprocess, GapsAreFilledByALineOrHeldOnlyUpToALength) {
  const VectorXd y = (VectorXd(8) << nothing, 1, nothing, 3, nothing, nothing, 9, nothing).finished();
  const DataSet data = make_data_set(VectorXd::Ones(8), y, 1);
  const Eigen::MatrixXd lines = fill_missing(data, Fill::line).all_y();
  EXPECT_EQ(lines(2, 0), 2);
  EXPECT_EQ(lines(4, 0), 5);
  EXPECT_TRUE(std::isnan(lines(0, 0)) && std::isnan(lines(7, 0)));
  const Eigen::MatrixXd shorts = fill_missing(data, Fill::hold, 1).all_y();
  EXPECT_EQ(shorts(2, 0), 1);
  EXPECT_TRUE(std::isnan(shorts(4, 0)));
  EXPECT_EQ(shorts(7, 0), 9);
}

TEST(Preprocess, PiecesCoverEverySampleOnceBehindTheirFirstOnes) {
  Eigen::MatrixXd y(103, 1);
  for (Eigen::Index k = 0; k < 103; ++k) y(k, 0) = static_cast<double>(k);
  const DataSet data = make_data_set(Eigen::MatrixXd::Zero(103, 1), y, 1, {{"u", ""}}, {{"y", ""}});
  double next = 3;
  for (const Experiment& piece : in_pieces(data, 20, 3).experiments) {
    EXPECT_GE(piece.samples(), 23);
    for (Eigen::Index k = 3; k < piece.samples(); ++k) EXPECT_EQ(piece.y(k, 0), next++);
  }
  EXPECT_EQ(next, 103);
}

TEST(Excitation, ThePrbsHasTheCorrelationOfAMaximumLengthSequence) {
  const VectorXd u = prbs(7);
  ASSERT_EQ(u.size(), 127);
  EXPECT_EQ(u.sum(), 1);
  for (Index tau = 0; tau < 127; ++tau) {
    double sum = 0;
    for (Index k = 0; k < 127; ++k) sum += u[k] * u[(k + tau) % 127];
    EXPECT_EQ(sum, tau == 0 ? 127 : -1);
  }
  // 7 ones, then 5 minus ones
  EXPECT_EQ(u.head(7).sum(), 7);
  EXPECT_EQ(u.segment(7, 5).sum(), -5);
  EXPECT_NEAR(prbs(7, 5).mean(), 0.0078740157, 1e-10);
  for (int bits = 2; bits <= 12; ++bits) EXPECT_EQ(prbs(bits).sum(), 1) << bits;
}

TEST(Excitation, ThePortableNoiseIsTheTabulatedOne) {
  const VectorXd e = portable_noise(3, 1, 7919);
  EXPECT_NEAR(e[0], -1.41312584, 1e-8);
  EXPECT_NEAR(e[1], 0.90007888, 1e-8);
  EXPECT_NEAR(e[2], 0.16735025, 1e-8);
}

TEST(Excitation, TheMultisineHoldsOnlyItsHarmonicsAndALowCrest) {
  const VectorXd u = multisine(128, 128, 3, 20, 2);
  EXPECT_DOUBLE_EQ(u.cwiseAbs().maxCoeff(), 2);
  double power = 0;
  for (int h = 1; h < 64; ++h) {
    std::complex<double> sum = 0;
    for (Index k = 0; k < 128; ++k)
      sum += u[k] * std::polar(1.0, -2 * std::numbers::pi * h * static_cast<double>(k) / 128);
    if (h < 3 || h > 20) {
      EXPECT_LT(std::abs(sum), 1e-11) << h;
    } else if (h == 3) {
      power = std::abs(sum);
    } else {
      EXPECT_NEAR(std::abs(sum), power, 1e-11);
    }
  }
  EXPECT_LT(2 / std::sqrt(u.squaredNorm() / 128), 2.0);  // crest factor; of a sum in phase it is 6
}

TEST(Excitation, LevelsStayInTheirBoundsAndSeedsDecide) {
  const VectorXd u = staircase(1000, 3, 7, -1, 2, 5);
  EXPECT_GE(u.minCoeff(), -1);
  EXPECT_LE(u.maxCoeff(), 2);
  EXPECT_EQ(u, staircase(1000, 3, 7, -1, 2, 5));
  EXPECT_NE(u, staircase(1000, 3, 7, -1, 2, 6));
  const VectorXd e = white_noise(20000, 0.5, 1);
  EXPECT_NEAR(e.squaredNorm() / 20000, 0.25, 4 * 0.25 * std::sqrt(2.0 / 20000));
  EXPECT_NEAR(e.mean(), 0, 4 * 0.5 / std::sqrt(20000.0));
}

}  // namespace
}  // namespace plantloop::identify
