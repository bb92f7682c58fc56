// Frequency responses of models and of data against closed forms.

#include "identify/spectra/spectra.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "identify/data/excitation.h"
#include "identify/error.h"
#include "identify/linear/filter.h"
#include "identify/linear/fit_linear.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using Complex = std::complex<double>;
constexpr double pi = std::numbers::pi;

TEST(Fourier, IsTheDefiningSumForAnyLength) {
  for (const Index n : {1, 2, 7, 127, 128, 210}) {
    const VectorXd x = white_noise(n, 1, 3);
    const Eigen::VectorXcd X = fourier_transform(x);
    ASSERT_EQ(X.size(), n);
    for (Index k = 0; k < n; ++k) {
      Complex sum = 0;
      for (Index i = 0; i < n; ++i)
        sum += x[i] * std::polar(1.0, -2 * pi * static_cast<double>(k * i % n) / static_cast<double>(n));
      EXPECT_LT(std::abs(X[k] - sum), 1e-12 * std::sqrt(static_cast<double>(n)) * 10) << n << " " << k;
    }
  }
}

TEST(Fourier, ThePeriodogramKeepsThePower) {
  const VectorXd x = white_noise(101, 1, 3);
  const Spectrum s = periodogram(x, 0.1);
  // Parseval: sum |X_k|^2/N = sum x^2; all bins but 0 count twice for an odd length.
  EXPECT_NEAR(s.power[0] + 2 * s.power.tail(50).sum(), x.squaredNorm(), 1e-11);
  EXPECT_NEAR(s.w[50], 2 * pi * 50 / (101 * 0.1), 1e-12);
}

TEST(Fourier, ThePrbsHasItsFirstZeroAtTheClock) {
  // 127 bits of 5 samples of 0.02 s: zero at 2 pi/0.1 s, and 0.405 of the power at half of it.
  const Spectrum s = periodogram(prbs(7, 5), 0.02);
  const Index zero = 127;  // bins of 2 pi/12.7 rad/s
  EXPECT_NEAR(s.w[zero], 62.83, 0.01);
  EXPECT_LT(s.power[zero], 1e-20);
  // Held samples: power [sin(5 a)/(5 sin a)]^2 with a = w Ts/2, against bin 1.
  const auto envelope = [](double w) {
    const double a = w * 0.01;
    return std::pow(std::sin(5 * a) / (5 * std::sin(a)), 2);
  };
  for (const Index k : {20, 64, 100}) EXPECT_NEAR(s.power[k] / s.power[1], envelope(s.w[k]) / envelope(s.w[1]), 1e-10);
  EXPECT_NEAR(std::pow(std::sin(pi / 2) / (pi / 2), 2), 0.405, 0.001);
}

PolynomialModel second_order() {
  const DataSet empty = make_data_set(VectorXd::Zero(10), VectorXd::Zero(10), 0.1);
  PolynomialModel m = make_polynomial_model({.nb = {2}, .nf = {2}, .delay = {1}}, empty, 0);
  m.set_parameters(Eigen::Vector4d(0.3, 0.2, -1.5, 0.7));
  return m;
}

TEST(FrequencyResponse, OfAModelIsItsTransferFunction) {
  const PolynomialModel m = second_order();
  const VectorXd w = frequencies(0.1, 0.1, 20);
  EXPECT_EQ(w[19], pi / 0.1);
  const FrequencyResponse r = frequency_response(m, w);
  const FrequencyResponse s = frequency_response(to_state_space(m), w);
  for (Index k = 0; k < 20; ++k) {
    const Complex q = std::polar(1.0, -w[k] * 0.1);
    const Complex G = q * q * (0.3 + 0.2 * q) / (1.0 - 1.5 * q + 0.7 * q * q);
    EXPECT_LT(std::abs(r.G[k] - G), 1e-13);
    EXPECT_LT(std::abs(s.G[k] - G), 1e-12);
  }
  EXPECT_NEAR(m.gain(0), 2.5, 1e-13);
  // Two delays of 2 pi each at the end: the phase goes on and does not jump.
  for (Index k = 1; k < 20; ++k) EXPECT_LT(std::abs(r.phase()[k] - r.phase()[k - 1]), pi);
}

TEST(FrequencyResponse, ItsDeviationIsThatOfEstimatesFromManyRecords) {
  const VectorXd u = prbs(8);
  const VectorXd w = (VectorXd(3) << 0.05, 0.4, 1.5).finished();
  VectorXd sum = VectorXd::Zero(3), squares = VectorXd::Zero(3), told = VectorXd::Zero(3);
  constexpr int records = 200;
  for (int i = 0; i < records; ++i) {
    const Eigen::Vector2d A(1, -0.8);
    const VectorXd y = filter(Eigen::Vector2d(0, 0.5), A, u) +
                       filter(VectorXd::Ones(1), A, white_noise(u.size(), 0.3, 100 + static_cast<std::uint64_t>(i)));
    const PolynomialModel m = fit_linear(make_data_set(u, y, 1), {.na = 1});
    const FrequencyResponse r = frequency_response(m, w);
    sum += r.magnitude();
    squares += r.magnitude().cwiseAbs2();
    told += r.deviation;
  }
  for (Index k = 0; k < 3; ++k) {
    const double scatter = std::sqrt(squares[k] / records - std::pow(sum[k] / records, 2));
    EXPECT_NEAR(told[k] / records, scatter, 0.2 * scatter);  // 200 records: 5 % of a standard deviation
  }
}

TEST(FourierAnalysis, OfPeriodicDataIsExact) {
  const VectorXd u = prbs(7, 1, 1, 127 * 10);
  const PolynomialModel m = second_order();
  const VectorXd y = filter(m.numerator(0), m.F[0], u);
  // The last period is in the steady state.
  const DataSet data = make_data_set(u.tail(127), y.tail(127), 0.1);
  const FrequencyResponse r = fourier_analysis(data);
  const FrequencyResponse exact = frequency_response(m, r.w);
  EXPECT_LT((r.G - exact.G).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(SpectralAnalysis, IsAtLeastTwiceAsGoodAsFourierInNoise) {
  const VectorXd u = white_noise(1000, 1, 1);
  const PolynomialModel m = second_order();
  const VectorXd y = filter(m.numerator(0), m.F[0], u) + white_noise(1000, 0.5, 2);
  const DataSet data = make_data_set(u, y, 0.1);
  const FrequencyResponse raw = fourier_analysis(data);
  const auto median_error = [&](const FrequencyResponse& r) {
    const FrequencyResponse exact = frequency_response(m, r.w);
    std::vector<double> errors;
    for (Index k = 0; k < r.w.size(); ++k) {
      if (r.w[k] < 10) errors.push_back(std::abs(r.G[k] - exact.G[k]) / std::abs(exact.G[k]));
    }
    std::nth_element(errors.begin(), errors.begin() + static_cast<long>(errors.size() / 2), errors.end());
    return errors[errors.size() / 2];
  };
  const SpectralAnalysis smooth = spectral_analysis(data, 35, raw.w);
  EXPECT_LT(2 * median_error(smooth.response), median_error(raw));
  // White input of variance 1 and noise of variance 0.25: coherence |G|^2/(|G|^2 + 0.25).
  const FrequencyResponse exact = frequency_response(m, raw.w);
  for (const Index k : {20, 50, 200}) {
    const double power = std::norm(exact.G[k]);
    EXPECT_NEAR(smooth.coherence[k], power / (power + 0.25), 0.1);
  }
}

// Beside the strong frequencies of slow signals Hamming's window makes power spectra negative and coherences of 10.
TEST(SpectralAnalysis, CoherencesLieBetween0And1AndPowersAreNotNegative) {
  const VectorXd w = frequencies(0.01, 1, 200);
  for (const int lags : {2, 5, 20, 35, 60, 120, 299}) {
    for (const LagWindow window : {LagWindow::hamming, LagWindow::hann, LagWindow::bartlett, LagWindow::parzen}) {
      for (const auto& u : {staircase(300, 5, 20, -1, 1, 3), multisine(300, 150, 1, 8, 1), white_noise(300, 1, 3)}) {
        const VectorXd y = filter(Eigen::Vector2d(0, 0.05), Eigen::Vector2d(1, -0.95), u);
        const SpectralAnalysis s = spectral_analysis(make_data_set(u, y, 1), lags, w, 0, 0, window);
        EXPECT_GE(s.coherence.minCoeff(), 0);
        EXPECT_LE(s.coherence.maxCoeff(), 1);
        EXPECT_GE(s.noise.minCoeff(), 0);
        EXPECT_GE(s.input.minCoeff(), 0);
        EXPECT_GE(s.output.minCoeff(), 0);
      }
    }
  }
}

// Of white noise beside the signal, for windows of the same smoothing.
TEST(SpectralAnalysis, EveryWindowFindsTheCoherenceOfNoise) {
  const VectorXd u = white_noise(20000, 1, 1), y = u + white_noise(20000, 1, 2);
  for (const LagWindow window : {LagWindow::hamming, LagWindow::hann, LagWindow::bartlett, LagWindow::parzen}) {
    const SpectralAnalysis s = spectral_analysis(make_data_set(u, y, 1), 30, frequencies(0.05, 1, 30), 0, 0, window);
    // Standard deviation of the estimate: sqrt(2 c) (1 - c) sqrt(sum of squared weights/N) = 0.019 at most.
    EXPECT_LT((s.coherence.array() - 0.5).abs().maxCoeff(), 0.06);
    EXPECT_LT((s.noise.array() - 1).abs().maxCoeff(), 0.15);
  }
  EXPECT_EQ(weight_of(LagWindow::parzen, 0.5), 0.25);
  EXPECT_EQ(weight_of(LagWindow::parzen, 0.25), 1 - 6.0 / 16 + 6.0 / 64);
  EXPECT_EQ(weight_of(LagWindow::bartlett, -0.25), 0.75);
  EXPECT_THROW(find_lag_window("hanning"), IdentifyError);
}

TEST(Fourier, APeriodogramNeedsASamplingTime) {
  for (const double Ts : {0.0, -1.0, HUGE_VAL}) EXPECT_THROW(periodogram(VectorXd::Ones(4), Ts), IdentifyError);
}

TEST(SpectralAnalysis, IsTheDefiningSum) {
  const VectorXd u = white_noise(60, 1, 1);
  const VectorXd y = white_noise(60, 1, 2);
  const VectorXd w = (VectorXd(2) << 0.3, 2.5).finished();
  const SpectralAnalysis s = spectral_analysis(make_data_set(u, y, 1), 5, w);
  const VectorXd uc = u.array() - u.mean();
  const VectorXd yc = y.array() - y.mean();
  for (Index i = 0; i < 2; ++i) {
    Complex yu = 0;
    Complex uu = 0;
    for (int tau = -5; tau <= 5; ++tau) {
      double r_yu = 0;
      double r_uu = 0;
      for (int k = 0; k < 60; ++k) {
        if (k + tau < 0 || k + tau >= 60) continue;
        r_yu += yc[k + tau] * uc[k] / 60;
        r_uu += uc[k + tau] * uc[k] / 60;
      }
      const Complex e = (0.54 + 0.46 * std::cos(pi * tau / 5)) * std::polar(1.0, -w[i] * tau);
      yu += r_yu * e;
      uu += r_uu * e;
    }
    EXPECT_LT(std::abs(s.response.G[i] - yu / uu), 1e-12);
  }
}

}  // namespace
}  // namespace plantloop::identify
