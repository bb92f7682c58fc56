// Quantiles, densities, correlations, spectra.

#include "render/numbers/statistics.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <unsupported/Eigen/FFT>

#include "render/layout/ticks.h"

namespace plantloop {
namespace {

constexpr double pi = 3.14159265358979323846;

double interquartile(const std::vector<double>& sorted) { return quantile(sorted, 0.75) - quantile(sorted, 0.25); }

// Differences from the mean; what is not finite is none.
std::vector<double> centred(const std::vector<double>& values) {
  double sum = 0, count = 0;
  for (const double v : values)
    if (std::isfinite(v)) sum += v, ++count;
  const double middle = count > 0 ? sum / count : 0;
  std::vector<double> result;
  for (const double v : values) result.push_back(std::isfinite(v) ? v - middle : 0);
  return result;
}

}  // namespace

std::vector<double> evenly(double from, double to, int count) {
  std::vector<double> result;
  for (int i = 0; i < count; ++i) result.push_back(from + (to - from) * i / (count - 1));
  return result;
}

std::vector<double> finite_sorted(const std::vector<double>& values) {
  std::vector<double> sorted;
  for (const double v : values)
    if (std::isfinite(v)) sorted.push_back(v);
  std::sort(sorted.begin(), sorted.end());
  return sorted;
}

double quantile(const std::vector<double>& sorted, double part) {
  if (sorted.empty()) return std::numeric_limits<double>::quiet_NaN();
  const double place = std::clamp(part, 0.0, 1.0) * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  const double t = place - static_cast<double>(below);
  return (1 - t) * sorted[below] + t * sorted[above];
}

double mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v;
  return values.empty() ? std::numeric_limits<double>::quiet_NaN() : sum / static_cast<double>(values.size());
}

double deviation(const std::vector<double>& values) {
  if (values.size() < 2) return 0;
  const double middle = mean(values);
  double sum = 0;
  for (const double v : values) sum += (v - middle) * (v - middle);
  return std::sqrt(sum / static_cast<double>(values.size() - 1));
}

std::vector<double> histogram_edges(const std::vector<double>& sorted, int count) {
  if (sorted.empty()) return {};
  const double lower = sorted.front(), upper = sorted.back(), span = upper - lower;
  if (!(span > 0) || !std::isfinite(span)) {
    const double half = lower == 0 || !std::isfinite(span) ? 0.5 : 0.05 * std::abs(lower);
    return {lower - half, lower + half};
  }
  if (count <= 0) {
    double width = 2 * interquartile(sorted) / std::cbrt(static_cast<double>(sorted.size()));
    if (!(width > span / 100)) width = span / std::clamp(std::sqrt(static_cast<double>(sorted.size())), 1.0, 60.0);
    // 1, 2 or 5 times a power of ten, so that bars end where numbers stand.
    const double decade = std::pow(10.0, std::floor(std::log10(width))), m = width / decade;
    if (std::isfinite(m)) width = decade * (m < 1.5 ? 1 : m < 3.5 ? 2 : m < 7.5 ? 5 : 10);
    const double first = std::floor(lower / width), last = std::max(std::ceil(upper / width), first + 1);
    if (last - first < 500 && std::abs(first) < 1e15) {
      std::vector<double> edges;
      for (double k = first; k <= last; ++k) edges.push_back(k * width);
      return edges;
    }
    count = 30;
  }
  std::vector<double> edges;
  for (int i = 0; i <= count; ++i) edges.push_back(lower + span * i / count);
  return edges;
}

std::vector<double> kernel_density(const std::vector<double>& sorted, const std::vector<double>& x) {
  std::vector<double> density(x.size(), 0.0);
  if (sorted.size() < 2) return density;
  double spread = deviation(sorted);
  const double quartiles = interquartile(sorted) / 1.34;
  if (quartiles > 0) spread = std::min(spread, quartiles);
  const double n = static_cast<double>(sorted.size()), width = 0.9 * spread * std::pow(n, -0.2);
  if (!(width > 0) || !std::isfinite(width)) return density;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const auto from = std::lower_bound(sorted.begin(), sorted.end(), x[i] - 5 * width);
    const auto to = std::upper_bound(sorted.begin(), sorted.end(), x[i] + 5 * width);
    for (auto v = from; v != to; ++v) density[i] += std::exp(-0.5 * std::pow((x[i] - *v) / width, 2));
    density[i] /= n * width * std::sqrt(2 * pi);
  }
  return density;
}

std::vector<double> correlation(const std::vector<double>& a, const std::vector<double>& b, int most) {
  const std::vector<double> u = centred(a), v = centred(b);
  const std::size_t n = std::min(u.size(), v.size());
  double uu = 0, vv = 0;
  for (std::size_t i = 0; i < n; ++i) uu += u[i] * u[i], vv += v[i] * v[i];
  const double scale = std::sqrt(uu) * std::sqrt(vv);
  std::vector<double> result;
  for (int lag = -most; lag <= most; ++lag) {
    double sum = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const auto k = static_cast<std::ptrdiff_t>(i) + lag;
      if (k >= 0 && k < static_cast<std::ptrdiff_t>(n)) sum += u[i] * v[static_cast<std::size_t>(k)];
    }
    result.push_back(scale > 0 && std::isfinite(scale) ? sum / scale : 0);
  }
  return result;
}

Spectrum welch(const std::vector<double>& y, double period, std::size_t length) {
  Spectrum result;
  length = std::min(length, y.size());
  if (length < 4 || !(period > 0)) return result;
  std::vector<double> window;
  double power = 0;
  for (std::size_t i = 0; i < length; ++i) {
    window.push_back(0.5 - 0.5 * std::cos(2 * pi * static_cast<double>(i) / static_cast<double>(length)));
    power += window.back() * window.back();
  }
  const std::size_t half = length / 2;
  result.density.assign(half + 1, 0.0);
  Eigen::FFT<double> transform;
  std::vector<double> piece;
  std::vector<std::complex<double>> image;
  for (std::size_t begin = 0; begin + length <= y.size(); begin += std::max<std::size_t>(length / 2, 1)) {
    const auto from = y.begin() + static_cast<std::ptrdiff_t>(begin);
    piece = centred({from, from + static_cast<std::ptrdiff_t>(length)});
    for (std::size_t i = 0; i < length; ++i) piece[i] *= window[i];
    transform.fwd(image, piece);
    for (std::size_t k = 0; k <= half; ++k) result.density[k] += std::norm(image[k]);
    ++result.segments;
  }
  for (std::size_t k = 0; k <= half; ++k) {
    const bool twice = k > 0 && !(k == half && length % 2 == 0);
    result.density[k] *= (twice ? 2 : 1) * period / (power * result.segments);
    result.frequency.push_back(static_cast<double>(k) / (static_cast<double>(length) * period));
  }
  return result;
}

}  // namespace plantloop
