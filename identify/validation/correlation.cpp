// What is left in the residuals.

#include "identify/validation/correlation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "identify/error.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

// About the mean of all experiments; missing values are 0 then.
struct Centred {
  Signals x;
  double squares = 0;
  double count = 0;
};

Centred centred(const Signals& given) {
  Centred c{given};
  double sum = 0;
  for (const VectorXd& x : given) {
    for (const double v : x) {
      if (std::isnan(v)) continue;
      sum += v;
      c.count += 1;
    }
  }
  if (c.count == 0) fail("there are no values to correlate");
  for (VectorXd& x : c.x) {
    for (double& v : x) v = std::isnan(v) ? 0 : v - sum / c.count;
    c.squares += x.squaredNorm();
  }
  return c;
}

double product(const VectorXd& a, const VectorXd& b, Index tau) {
  const Index overlap = a.size() - std::abs(tau);
  if (overlap <= 0) return 0;
  return tau >= 0 ? a.tail(overlap).dot(b.head(overlap)) : a.head(overlap).dot(b.tail(overlap));
}

// sum_k x(k+tau) x(k)/sum x^2, tau = 0 ... most.
VectorXd own_correlation(const Centred& c, Index most) {
  VectorXd r(most + 1);
  for (Index tau = 0; tau <= most; ++tau) {
    double sum = 0;
    for (const VectorXd& x : c.x) sum += product(x, x, tau);
    r[tau] = c.squares > 0 ? sum / c.squares : 0;
  }
  return r;
}

// P_l of two sequences that do not depend on each other, l = 0 ... most.
VectorXd chance(const Centred& a, const Centred& b, Index most) {
  const Index width = std::min<Index>(100, static_cast<Index>(a.count) / 4);
  const VectorXd raa = own_correlation(a, width), rbb = own_correlation(b, width + most);
  VectorXd P(most + 1);
  for (Index l = 0; l <= most; ++l) {
    P[l] = 0;
    for (Index k = -width; k <= width; ++k) {
      const double weight = 1 - static_cast<double>(std::abs(k)) / static_cast<double>(width + 1);
      P[l] += weight * raa[std::abs(k)] * rbb[std::abs(k + l)];
    }
  }
  P[0] = std::max(P[0], 0.25);
  return P;
}

Correlation correlate(const Signals& a, const Signals& b, int from, int to, bool independent) {
  const Centred one = centred(a);
  const Centred other = centred(b);
  if (one.x.size() != other.x.size()) fail("there are {} and {} experiments", one.x.size(), other.x.size());
  const double scale = std::sqrt(one.squares) * std::sqrt(other.squares);
  Correlation c;
  c.lag.resize(to - from + 1);
  c.r.resize(to - from + 1);
  for (int tau = from; tau <= to; ++tau) {
    double sum = 0;
    for (std::size_t i = 0; i < one.x.size(); ++i) {
      if (one.x[i].size() != other.x[i].size()) {
        fail("the signals of an experiment have {} and {} samples", one.x[i].size(), other.x[i].size());
      }
      sum += product(one.x[i], other.x[i], tau);
    }
    c.lag[tau - from] = tau;
    c.r[tau - from] = scale > 0 ? sum / scale : std::numeric_limits<double>::quiet_NaN();
  }
  const VectorXd P = independent ? chance(one, other, to - from) : VectorXd::Unit(to - from + 1, 0);
  c.alike = (P / P[0]).cwiseMax(-1).cwiseMin(1);
  c.band95 = 1.959963984540054 * std::sqrt(P[0] / one.count);
  c.band99 = 2.5758293035489 * std::sqrt(P[0] / one.count);
  return c;
}

// The number that a standard normal one exceeds with this probability (by bisection of its tail).
double normal_quantile(double tail) {
  double low = 0, high = 40;
  for (int i = 0; i < 100; ++i) {
    const double z = (low + high) / 2;
    (std::erfc(z / std::numbers::sqrt2) / 2 > tail ? low : high) = z;
  }
  return low;
}

// Over the lags that `counts` selects, which follow each other.
template <typename Counts>
Verdict judge(const Correlation& c, Counts counts) {
  Verdict v;
  double lags = 0, squares = 0;
  for (Index i = 0; i < c.r.size(); ++i) {
    if (!counts(c.lag[i])) continue;
    lags += 1;
    v.outside += std::fabs(c.r[i]) > c.band95 ? 1 : 0;
    v.largest = std::max(v.largest, std::isnan(c.r[i]) ? HUGE_VAL : std::fabs(c.r[i]));
    squares += c.r[i] * c.r[i];
  }
  if (lags == 0) return v;
  v.outside /= lags;
  constexpr double level = 0.005;  // of each of the two
  const double deviation = c.band95 / 1.959963984540054;
  const double each = 1 - std::pow(1 - level, 1 / lags);
  double sum_of_lambda_squares = lags;
  for (Index l = 1; l < static_cast<Index>(lags); ++l) {
    sum_of_lambda_squares += 2 * (lags - static_cast<double>(l)) * c.alike[l] * c.alike[l];
  }
  const double g = sum_of_lambda_squares / lags, h = lags / g;
  const double quantile = h * std::pow(1 - 2 / (9 * h) + normal_quantile(level) * std::sqrt(2 / (9 * h)), 3);
  v.passed = v.largest <= deviation * normal_quantile(each / 2) && squares <= deviation * deviation * g * quantile;
  return v;
}

// All equal, but for rounding.
bool constant(const Signals& given) {
  double least = HUGE_VAL, greatest = -HUGE_VAL;
  for (const VectorXd& x : given) {
    for (const double v : x) {
      if (std::isnan(v)) continue;
      least = std::min(least, v);
      greatest = std::max(greatest, v);
    }
  }
  return greatest - least <= 1e-10 * std::max(std::fabs(least), std::fabs(greatest));
}

template <typename Change>
Signals changed(const Signals& a, const Signals& b, Change change) {
  Signals result;
  for (std::size_t i = 0; i < a.size(); ++i) {
    VectorXd x(a[i].size());
    for (Index k = 0; k < x.size(); ++k) x[k] = change(a[i][k], b[i][k]);
    result.push_back(std::move(x));
  }
  return result;
}

double mean(const Signals& given) {
  double sum = 0;
  double count = 0;
  for (const VectorXd& x : given) {
    for (const double v : x) {
      if (std::isnan(v)) continue;
      sum += v;
      count += 1;
    }
  }
  return sum / count;
}

}  // namespace

Correlation autocorrelation(const Signals& e, int lags) {
  if (lags < 1) fail("there is at least one lag, not {}", lags);
  return correlate(e, e, 0, lags, false);
}

Correlation cross_correlation(const Signals& e, const Signals& u, int lags) {
  if (lags < 1) fail("there is at least one lag, not {}", lags);
  return correlate(e, u, -lags, lags, true);
}

Verdict whiteness(const Correlation& c) {
  Verdict v = judge(c, [](double lag) { return lag > 0; });
  v.name = "e with e";
  v.meaning = v.passed ? "the residuals are white" : "the residuals are predictable from their own past";
  return v;
}

Verdict independence(const Correlation& c) {
  Verdict v = judge(c, [](double lag) { return lag >= 0; });
  v.name = "e with u";
  const Verdict before = judge(c, [](double lag) { return lag < 0; });
  v.meaning = v.passed ? "the residuals do not depend on past inputs"
                       : "the residuals depend on past inputs: dynamics are missing";
  if (!before.passed) v.meaning += "; the input depends on past residuals, as feedback makes it";
  return v;
}

ResidualTests residual_tests(const Signals& e, const Signals& u, int lags) {
  ResidualTests tests;
  const auto add = [&](Correlation c, Verdict v) {
    tests.correlations.push_back(std::move(c));
    tests.verdicts.push_back(std::move(v));
  };
  const Correlation ee = autocorrelation(e, lags);
  add(ee, whiteness(ee));
  if (u.empty()) return tests;
  const Correlation eu = cross_correlation(e, u, lags);
  add(eu, independence(eu));
  const double u_mean = mean(u);
  const Signals u2 = changed(u, u, [&](double a, double) { return (a - u_mean) * (a - u_mean); });
  const Signals e2 = changed(e, e, [](double a, double) { return a * a; });
  const Signals eu_product = changed(e, u, [&](double a, double b) { return a * (b - u_mean); });
  const auto nonlinear = [&](const Signals& a, const Signals& b, const char* name, const char* words, int first = 0) {
    const Correlation c = cross_correlation(a, b, lags);
    Verdict v = judge(c, [first](double lag) { return lag >= first; });
    v.name = name;
    v.meaning = v.passed ? "nothing nonlinear is seen in it" : words;
    // Squares of two levels about their mean are equal but for rounding.
    if (&b == &u2 && constant(u2)) {
      v.passed = true;
      v.outside = v.largest = 0;
      v.meaning = "the square of the input does not vary, so this is not tested";
    }
    add(c, v);
  };
  nonlinear(e, u2, "e with u^2", "the residuals depend on squares of past inputs");
  nonlinear(e2, u2, "e^2 with u^2", "the size of the residuals depends on squares of past inputs");
  nonlinear(e, eu_product, "e with e u", "the residuals depend on products of past residuals and inputs", 1);
  return tests;
}

Histogram histogram(const VectorXd& given, int bins) {
  if (bins < 1 || bins > 10'000) fail("a histogram has 1 to 10000 bins, not {}", bins);
  std::vector<double> x;
  for (const double v : given) {
    if (std::isfinite(v)) x.push_back(v);
  }
  if (x.empty()) fail("there are no values for a histogram");
  const auto [least, most] = std::minmax_element(x.begin(), x.end());
  double from = *least;
  double to = *most;
  if (from == to) {
    const double half = std::max(1e-300, std::fabs(from) * 1e-6);
    from -= half;
    to += half;
  }
  Histogram h;
  h.edges = VectorXd::LinSpaced(bins + 1, from, to);
  h.counts = VectorXd::Zero(bins);
  for (const double v : x) {
    const auto bin = static_cast<Index>(std::floor((v - from) / (to - from) * bins));
    h.counts[std::clamp<Index>(bin, 0, bins - 1)] += 1;
    h.mean += v / static_cast<double>(x.size());
  }
  double variance = 0;
  for (const double v : x) variance += (v - h.mean) * (v - h.mean) / static_cast<double>(x.size());
  h.deviation = std::sqrt(variance);
  h.normal = VectorXd::Zero(bins);
  if (h.deviation > 0) {
    const double scale =
        static_cast<double>(x.size()) * (to - from) / bins / (h.deviation * std::sqrt(2 * std::numbers::pi));
    for (Index i = 0; i < bins; ++i) {
      const double z = ((h.edges[i] + h.edges[i + 1]) / 2 - h.mean) / h.deviation;
      h.normal[i] = scale * std::exp(-z * z / 2);
    }
  }
  return h;
}

}  // namespace plantloop::identify
