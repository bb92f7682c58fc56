// Frequency responses and roots.

#include "render/numbers/frequency.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace plantloop {
namespace {

constexpr double pi = 3.14159265358979323846;

Complex horner(const Polynomial& p, Complex s) {
  Complex sum = 0;
  for (const double c : p) sum = sum * s + c;
  return sum;
}

// Evenly on the logarithm, and about each resonance.
std::vector<double> frequencies(const Transfer& system, double from, double to) {
  std::vector<double> w;
  constexpr int count = 400;
  const double a = std::log10(from), b = std::log10(to);
  for (int i = 0; i <= count; ++i) w.push_back(std::pow(10.0, a + (b - a) * i / count));
  for (const Polynomial* p : {&system.num, &system.den})
    for (const Complex root : roots(*p)) {
      const double size = std::abs(root), damping = std::abs(root.real()) / size;
      if (!(size > 0) || root.imag() < 0 || damping > 0.3) continue;
      const double width = std::max(damping, 1e-6);
      for (int i = -30; i <= 30; ++i) {
        const double at = size * (1 + width * std::copysign(std::pow(std::abs(i) / 6.0, 2), i));
        if (at > from && at < to) w.push_back(at);
      }
    }
  std::sort(w.begin(), w.end());
  w.erase(std::unique(w.begin(), w.end()), w.end());
  return w;
}

std::pair<double, double> natural_range(const Transfer& system) {
  double least = std::numeric_limits<double>::infinity(), most = 0;
  for (const Polynomial* p : {&system.num, &system.den})
    for (const Complex root : roots(*p)) {
      const double size = std::abs(root);
      if (!(size > 1e-12)) continue;
      least = std::min(least, size);
      most = std::max(most, size);
    }
  if (system.delay > 0) {
    least = std::min(least, 1 / system.delay);
    most = std::max(most, 1 / system.delay);
  }
  if (!(most > 0)) return {0.01, 100};
  return {std::pow(10.0, std::floor(std::log10(least)) - 1), std::pow(10.0, std::ceil(std::log10(most)) + 1)};
}

// Zeros of a polynomial at the origin.
int at_origin(const Polynomial& p) {
  int count = 0;
  for (auto c = p.rbegin(); c != p.rend() && *c == 0; ++c) ++count;
  return count;
}

void set_gain_and_phase(Response& r, std::optional<double> start) {
  double turn = 0;
  for (std::size_t i = 0; i < r.value.size(); ++i) {
    r.gain.push_back(20 * std::log10(std::abs(r.value[i])));
    double phase = std::arg(r.value[i]) * 180 / pi;
    if (i == 0 && start) turn = 360 * std::round((*start - phase) / 360);
    if (i > 0) turn = 360 * std::round((r.phase.back() - phase) / 360);
    phase += turn;
    r.phase.push_back(phase);
  }
}

}  // namespace

Complex Transfer::at(Complex s) const { return horner(num, s) / horner(den, s) * std::exp(-s * delay); }

std::vector<Complex> roots(const Polynomial& polynomial) {
  Polynomial p = polynomial;
  if (!std::all_of(p.begin(), p.end(), [](double c) { return std::isfinite(c); })) return {};
  while (!p.empty() && p.front() == 0) p.erase(p.begin());
  std::vector<Complex> result;
  while (p.size() > 1 && p.back() == 0) {
    p.pop_back();
    result.emplace_back(0);
  }
  if (p.size() > 1 && p.size() <= 201) {
    const auto n = static_cast<Eigen::Index>(p.size()) - 1;
    Eigen::MatrixXd companion = Eigen::MatrixXd::Zero(n, n);
    for (Eigen::Index i = 0; i < n; ++i) companion(0, i) = -p[static_cast<std::size_t>(i) + 1] / p[0];
    for (Eigen::Index i = 1; i < n; ++i) companion(i, i - 1) = 1;
    if (companion.allFinite()) {
      const Eigen::VectorXcd values = Eigen::EigenSolver<Eigen::MatrixXd>(companion, false).eigenvalues();
      result.insert(result.end(), values.data(), values.data() + values.size());
    }
  }
  std::sort(result.begin(), result.end(),
            [](Complex a, Complex b) { return a.real() != b.real() ? a.real() < b.real() : a.imag() < b.imag(); });
  return result;
}

Response respond(const Transfer& system, std::optional<double> from, std::optional<double> to) {
  Response r;
  auto [lower, upper] = natural_range(system);
  if (from && *from > 0 && std::isfinite(*from)) lower = *from;
  if (to && *to > 0 && std::isfinite(*to)) upper = *to;
  if (!(lower < upper)) upper = 100 * lower;
  for (const double w : frequencies(system, lower, upper)) {
    const Complex value = system.at({0, w});
    if (!std::isfinite(value.real()) || !std::isfinite(value.imag()) || value == Complex(0)) continue;
    r.w.push_back(w);
    r.value.push_back(value);
  }
  const int slope = at_origin(system.num) - at_origin(system.den);
  const Complex rest = [&] {
    Polynomial num = system.num, den = system.den;
    for (int i = at_origin(num); i > 0; --i) num.pop_back();
    for (int i = at_origin(den); i > 0; --i) den.pop_back();
    return num.empty() || den.empty() ? 1.0 : num.back() / den.back();
  }();
  set_gain_and_phase(r, 90.0 * slope + (rest.real() < 0 ? -180 : 0));
  return r;
}

Response respond(const std::vector<double>& w, const std::vector<double>& real, const std::vector<double>& imaginary) {
  std::vector<std::pair<double, Complex>> all;
  for (std::size_t i = 0; i < std::min({w.size(), real.size(), imaginary.size()}); ++i) {
    const Complex value(real[i], imaginary[i]);
    if (w[i] > 0 && std::isfinite(w[i]) && std::isfinite(real[i]) && std::isfinite(imaginary[i]) && std::abs(value) > 0)
      all.emplace_back(w[i], value);
  }
  std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  Response r;
  for (const auto& [at, value] : all) {
    r.w.push_back(at);
    r.value.push_back(value);
  }
  set_gain_and_phase(r, std::nullopt);
  return r;
}

Margins margins(const Response& r) {
  Margins m;
  for (std::size_t i = 0; i + 1 < r.w.size(); ++i) {
    // Between samples both are straight over the logarithm of the frequency.
    const auto between = [&](const std::vector<double>& y, double level) { return (level - y[i]) / (y[i + 1] - y[i]); };
    const auto at = [&](const std::vector<double>& y, double t) { return y[i] + t * (y[i + 1] - y[i]); };
    const auto frequency = [&](double t) { return r.w[i] * std::pow(r.w[i + 1] / r.w[i], t); };
    if (r.gain[i] >= 0 && r.gain[i + 1] < 0) {
      const double t = between(r.gain, 0);
      m.gain_crossover = frequency(t);
      m.phase_margin = 180 + at(r.phase, t);
    }
    if (!m.phase_crossover && r.phase[i] >= -180 && r.phase[i + 1] < -180) {
      const double t = between(r.phase, -180);
      m.phase_crossover = frequency(t);
      m.gain_margin = -at(r.gain, t);
    }
  }
  return m;
}

}  // namespace plantloop
