// Frequency responses of data: Fourier and spectral analysis.

#include <algorithm>
#include <cmath>
#include <complex>
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

Complex transform(const VectorXd& r, double angle) {
  const Index lags = r.size() / 2;
  Complex sum = 0;
  for (Index i = 0; i < r.size(); ++i) sum += r[i] * std::polar(1.0, -angle * static_cast<double>(i - lags));
  return sum;
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

SpectralAnalysis spectral_analysis(const DataSet& data, int lags, const VectorXd& w, std::size_t input,
                                   std::size_t output) {
  check_channels(data, input, output, "spectral analysis");
  if (lags < 2 || lags >= data.samples()) fail("the window has 2 lags or more and fewer than samples, not {}", lags);
  VectorXd yu = VectorXd::Zero(2 * lags + 1);
  VectorXd uu = yu;
  VectorXd yy = yu;
  const double u_mean = data.all_u().col(static_cast<Index>(input)).mean();
  const double y_mean = data.all_y().col(static_cast<Index>(output)).mean();
  for (const Experiment& e : data.experiments) {
    const VectorXd u = e.u.col(static_cast<Index>(input)).array() - u_mean;
    const VectorXd y = e.y.col(static_cast<Index>(output)).array() - y_mean;
    yu += correlate(y, u, lags);
    uu += correlate(u, u, lags);
    yy += correlate(y, y, lags);
  }
  const auto samples = static_cast<double>(data.samples());
  VectorXd window(2 * lags + 1);
  for (int tau = -lags; tau <= lags; ++tau) window[tau + lags] = 0.54 + 0.46 * std::cos(std::numbers::pi * tau / lags);
  for (VectorXd* r : {&yu, &uu, &yy}) *r = r->cwiseProduct(window) / samples;

  const Index count = w.size();
  SpectralAnalysis s{{w, VectorXcd(count), VectorXd(count), VectorXd(count)},
                     VectorXd(count),
                     VectorXd(count),
                     VectorXd(count),
                     VectorXd(count)};
  for (Index k = 0; k < count; ++k) {
    const double angle = w[k] * data.Ts;
    const Complex cross = transform(yu, angle);
    const double in = transform(uu, angle).real();
    const double out = transform(yy, angle).real();
    s.response.G[k] = cross / in;
    s.input[k] = in;
    s.output[k] = out;
    s.coherence[k] = std::norm(cross) / (in * out);
    s.noise[k] = std::max(0.0, out - std::norm(cross) / in);
    s.response.deviation[k] = std::sqrt(window.squaredNorm() / samples * s.noise[k] / std::fabs(in) / 2);
    s.response.phase_deviation[k] = s.response.deviation[k] / std::abs(s.response.G[k]);
  }
  return s;
}

}  // namespace plantloop::identify
