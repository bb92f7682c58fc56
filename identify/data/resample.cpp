// Another sampling time, by a windowed sinc without phase.

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "identify/data/preprocess.h"
#include "identify/error.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double crossings = 10;  // zero crossings of the sinc to each side

// Kaiser's window with 60 dB of attenuation: beta = 0.1102 (60 - 8.7) (J. Kaiser 1974).
double window(double x) {
  constexpr double beta = 0.1102 * (60 - 8.7);
  return std::fabs(x) >= 1 ? 0 : std::cyl_bessel_i(0.0, beta * std::sqrt(1 - x * x)) / std::cyl_bessel_i(0.0, beta);
}

double sinc(double x) {
  const double a = std::numbers::pi * x;
  return std::fabs(a) < 1e-8 ? 1 : std::sin(a) / a;
}

VectorXd resampled(const VectorXd& x, int up, int down) {
  const double cutoff = std::min(1.0, static_cast<double>(up) / down);  // of the old Nyquist frequency
  const double reach = crossings / cutoff;                              // old samples to each side
  const Index count = (x.size() - 1) * up / down + 1;
  VectorXd y(count);
  for (Index k = 0; k < count; ++k) {
    // The time in old samples, its whole part exactly.
    const Index whole = k * down / up;
    const double part = static_cast<double>(k * down % up) / up;
    double sum = 0;
    double weights = 0;
    for (Index i = whole - static_cast<Index>(reach); i <= whole + static_cast<Index>(reach) + 1; ++i) {
      const double distance = static_cast<double>(i - whole) - part;
      const double weight = sinc(distance * cutoff) * window(distance / reach);
      sum += weight * x[std::clamp<Index>(i, 0, x.size() - 1)];
      weights += weight;
    }
    y[k] = sum / weights;  // a constant stays one
  }
  return y;
}

}  // namespace

DataSet resample(const DataSet& data, int up, int down) {
  refuse_missing(data, "resampling");
  check(data);
  if (up < 1 || up > 1000 || down < 1 || down > 1000)
    fail("up and down lie between 1 and 1000, not {} and {}", up, down);
  const int common = std::gcd(up, down);
  up /= common;
  down /= common;
  DataSet result = data;
  result.Ts = data.Ts * down / up;
  for (Experiment& e : result.experiments) {
    const Experiment old = e;
    const Index count = (old.samples() - 1) * up / down + 1;
    e.u.resize(count, old.u.cols());
    e.y.resize(count, old.y.cols());
    for (Index c = 0; c < old.u.cols(); ++c) e.u.col(c) = resampled(old.u.col(c), up, down);
    for (Index c = 0; c < old.y.cols(); ++c) e.y.col(c) = resampled(old.y.col(c), up, down);
  }
  return result;
}

}  // namespace plantloop::identify
