// The discrete Fourier transform of a signal of any length, and the periodogram.

#include <cmath>
#include <numbers>
#include <unsupported/Eigen/FFT>
#include <vector>

#include "identify/error.h"
#include "identify/spectra/spectra.h"

namespace plantloop::identify {

using Eigen::Index;

Eigen::VectorXcd fourier_transform(const Eigen::VectorXd& x) {
  if (x.size() == 0) fail("there is no spectrum of no samples");
  if (!x.allFinite()) fail("a spectrum needs finite numbers; some are missing or infinite");
  if (x.size() == 1) return x.cast<std::complex<double>>();  // the library does not take one sample
  // Complex input: the real path of the library does not take odd lengths.
  const std::vector<std::complex<double>> signal(x.begin(), x.end());
  std::vector<std::complex<double>> result;
  Eigen::FFT<double> fft;
  fft.fwd(result, signal);
  return Eigen::Map<const Eigen::VectorXcd>(result.data(), static_cast<Index>(result.size()));
}

Spectrum periodogram(const Eigen::VectorXd& x, double Ts) {
  if (!(Ts > 0) || !std::isfinite(Ts))
    fail("the sampling time of a periodogram must be greater than 0 s, it is {:g} s", Ts);
  const Eigen::VectorXcd X = fourier_transform(x);
  const Index count = x.size() / 2 + 1;
  const auto samples = static_cast<double>(x.size());
  return {
      Eigen::VectorXd::LinSpaced(count, 0, static_cast<double>(count - 1)) * (2 * std::numbers::pi / (samples * Ts)),
      X.head(count).cwiseAbs2() / samples};
}

}  // namespace plantloop::identify
