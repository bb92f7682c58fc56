// Frequency responses of data: Fourier and spectral analysis.

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>

#include "identify/error.h"
#include "identify/spectra/spectra.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;
using Eigen::VectorXcd;
using Eigen::VectorXd;
using Complex = std::complex<double>;

void check_channels(const DataSet& data, std::size_t input, std::size_t output, std::string_view method) {
  check(data);
  refuse_missing(data, method);
  if (input >= data.inputs.size() || output >= data.outputs.size()) {
    fail("the data have {} inputs and {} outputs, there is no input {} with output {}", data.inputs.size(),
         data.outputs.size(), input + 1, output + 1);
  }
}

VectorXd centred(const VectorXd& x) { return x.array() - x.mean(); }

// sum_k a(k+tau) b(k) for tau = -lags ... lags.
VectorXd correlate(const VectorXd& a, const VectorXd& b, Index lags) {
  VectorXd r(2 * lags + 1);
  for (Index tau = -lags; tau <= lags; ++tau) {
    const Index overlap = a.size() - std::abs(tau);
    r[tau + lags] = overlap <= 0 ? 0
                    : tau >= 0   ? a.tail(overlap).dot(b.head(overlap))
                                 : a.head(overlap).dot(b.tail(overlap));
  }
  return r;
}

// sum of weights(tau) r(tau) e^{-j angle tau}, over the lags of the weights.
Complex transform(const VectorXd& r, const VectorXd& weights, double angle) {
  const Index lags = weights.size() / 2, first = r.size() / 2 - lags;
  Complex sum = 0;
  for (Index i = 0; i < weights.size(); ++i)
    sum += weights[i] * r[first + i] * std::polar(1.0, -angle * static_cast<double>(i - lags));
  return sum;
}

VectorXd weights_of(LagWindow window, int lags) {
  VectorXd weights(2 * lags + 1);
  for (int tau = -lags; tau <= lags; ++tau) weights[tau + lags] = weight_of(window, static_cast<double>(tau) / lags);
  return weights;
}

struct Correlations {
  VectorXd yu, uu, yy;
};

// Of the signals about their means over all experiments, over the number of samples.
Correlations correlations(const DataSet& data, std::size_t input, std::size_t output, Index lags) {
  Correlations r{VectorXd::Zero(2 * lags + 1), VectorXd::Zero(2 * lags + 1), VectorXd::Zero(2 * lags + 1)};
  const double u_mean = data.all_u().col(static_cast<Index>(input)).mean();
  const double y_mean = data.all_y().col(static_cast<Index>(output)).mean();
  for (const Experiment& e : data.experiments) {
    const VectorXd u = e.u.col(static_cast<Index>(input)).array() - u_mean;
    const VectorXd y = e.y.col(static_cast<Index>(output)).array() - y_mean;
    r.yu += correlate(y, u, lags);
    r.uu += correlate(u, u, lags);
    r.yy += correlate(y, y, lags);
  }
  for (VectorXd* each : {&r.yu, &r.uu, &r.yy}) *each /= static_cast<double>(data.samples());
  return r;
}

}  // namespace

FrequencyResponse fourier_analysis(const DataSet& data, std::size_t input, std::size_t output) {
  check_channels(data, input, output, "Fourier analysis");
  const Index samples = data.experiments[0].samples();
  if (samples < 4) fail("Fourier analysis needs at least 4 samples, there are {}", samples);
  VectorXcd cross = VectorXcd::Zero(samples);
  VectorXd power = VectorXd::Zero(samples);
  VectorXcd ratio;
  for (const Experiment& e : data.experiments) {
    if (e.samples() != samples) {
      fail("Fourier analysis of several experiments needs equal lengths; there are {} and {} samples", samples,
           e.samples());
    }
    const VectorXcd U = fourier_transform(centred(e.u.col(static_cast<Index>(input))));
    const VectorXcd Y = fourier_transform(centred(e.y.col(static_cast<Index>(output))));
    ratio = Y.cwiseQuotient(U);
    cross += Y.cwiseProduct(U.conjugate());
    power += U.cwiseAbs2();
  }
  const Index count = samples / 2;
  FrequencyResponse r;
  r.w = VectorXd::LinSpaced(count, 1, static_cast<double>(count)) *
        (2 * std::numbers::pi / (static_cast<double>(samples) * data.Ts));
  r.G = data.experiments.size() == 1
            ? VectorXcd(ratio.segment(1, count))
            : VectorXcd(cross.segment(1, count).cwiseQuotient(power.segment(1, count).cast<Complex>()));
  return r;
}

LagWindow find_lag_window(const std::string& name) {
  constexpr std::array<const char*, 4> names{"hamming", "hann", "bartlett", "parzen"};
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (name == names[i]) return static_cast<LagWindow>(i);
  }
  fail("there is no window '{}'; there are {}", name, fmt::join(names, ", "));
}

double weight_of(LagWindow window, double x) {
  const double size = std::fabs(x);
  switch (window) {
    case LagWindow::hamming:
      return 0.54 + 0.46 * std::cos(std::numbers::pi * x);
    case LagWindow::hann:
      return 0.5 + 0.5 * std::cos(std::numbers::pi * x);
    case LagWindow::bartlett:
      return 1 - size;
    case LagWindow::parzen:
      return size < 0.5 ? 1 - 6 * size * size * (1 - size) : 2 * std::pow(1 - size, 3);
  }
  return 0;
}

SpectralAnalysis spectral_analysis(const DataSet& data, int lags, const VectorXd& w, std::size_t input,
                                   std::size_t output, LagWindow window) {
  check_channels(data, input, output, "spectral analysis");
  if (lags < 2 || lags >= data.samples()) fail("the window has 2 lags or more and fewer than samples, not {}", lags);
  const VectorXd weights = weights_of(window, lags);
  const bool leaks = window == LagWindow::hamming || window == LagWindow::hann;
  const auto alike = static_cast<int>(std::lround(weights.squaredNorm() / (151.0 / 280)));
  const VectorXd smooth = leaks ? weights_of(LagWindow::parzen, alike) : weights;
  const Correlations r = correlations(data, input, output, std::max(lags, static_cast<int>(smooth.size() / 2)));

  const auto samples = static_cast<double>(data.samples());
  const Index count = w.size();
  SpectralAnalysis s{{w, VectorXcd(count), VectorXd(count), VectorXd(count)},
                     VectorXd(count),
                     VectorXd(count),
                     VectorXd(count),
                     VectorXd(count)};
  for (Index k = 0; k < count; ++k) {
    const double angle = w[k] * data.Ts;
    const double denominator = transform(r.uu, weights, angle).real();
    s.response.G[k] = transform(r.yu, weights, angle) / denominator;
    const Complex cross = transform(r.yu, smooth, angle);
    // Never negative but for rounding.
    const double in = std::max(0.0, transform(r.uu, smooth, angle).real());
    const double out = std::max(0.0, transform(r.yy, smooth, angle).real());
    s.input[k] = in;
    s.output[k] = out;
    s.coherence[k] = in > 0 && out > 0 ? std::min(1.0, std::norm(cross) / in / out) : 0;
    s.noise[k] = out * (1 - s.coherence[k]);
    s.response.deviation[k] = denominator > 0 && in > 0
                                  ? std::sqrt(weights.squaredNorm() / samples * s.noise[k] / in / 2)
                                  : std::numeric_limits<double>::infinity();
    s.response.phase_deviation[k] = s.response.deviation[k] / std::abs(s.response.G[k]);
  }
  return s;
}

}  // namespace plantloop::identify
