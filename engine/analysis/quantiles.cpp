// P(|T| <= t) = 1 - I_x(n/2, 1/2), x = n/(n + t^2), by the continued fraction of the incomplete beta function
// (M. Abramowitz and I. Stegun, 26.5.8 and 26.7.1).

#include "engine/analysis/quantiles.h"

#include <cmath>
#include <initializer_list>
#include <limits>

namespace plantloop {

namespace {

// Lentz's method; converges fast for x < (a + 1)/(a + b + 2).
double beta_fraction(double a, double b, double x) {
  constexpr double tiny = 1e-300;
  double c = 1, d = 1 - (a + b) * x / (a + 1);
  d = 1 / (std::fabs(d) < tiny ? tiny : d);
  double fraction = d;
  for (int m = 1; m < 10'000; ++m) {
    for (const bool even : {true, false}) {
      const double term = even ? m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m))
                               : -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1));
      d = 1 + term * d;
      d = 1 / (std::fabs(d) < tiny ? tiny : d);
      c = 1 + term / c;
      if (std::fabs(c) < tiny) c = tiny;
      fraction *= d * c;
    }
    if (std::fabs(d * c - 1) < 1e-16) break;
  }
  return fraction;
}

// The regularised incomplete beta function; y = 1 - x, given apart so that nothing is lost near x = 1.
double incomplete_beta(double a, double b, double x, double y) {
  if (x <= 0) return 0;
  if (y <= 0) return 1;
  const double front =
      std::exp(std::lgamma(a + b) - std::lgamma(a) - std::lgamma(b) + a * std::log(x) + b * std::log(y));
  if (x < (a + 1) / (a + b + 2)) return front * beta_fraction(a, b, x) / a;
  return 1 - front * beta_fraction(b, a, y) / b;
}

}  // namespace

double student_within(double t, double degrees) {
  const double y = t * t / (degrees + t * t);
  return incomplete_beta(0.5, 0.5 * degrees, y, degrees / (degrees + t * t));
}

double student_quantile(double p, double degrees) {
  if (!(degrees > 0)) return std::numeric_limits<double>::infinity();
  double lower = 0, upper = 1;
  while (student_within(upper, degrees) < p && upper < 1e300) upper *= 2;
  for (int i = 0; i < 200 && upper - lower > 1e-15 * upper; ++i) {
    const double middle = 0.5 * (lower + upper);
    (student_within(middle, degrees) < p ? lower : upper) = middle;
  }
  return 0.5 * (lower + upper);
}

}  // namespace plantloop
