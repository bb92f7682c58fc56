// What is left in the residuals: correlations with bounds, verdicts, histograms.

#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace plantloop::identify {

// Residuals or signals of each experiment. NaN (a missing value) counts as no contribution.
using Signals = std::vector<Eigen::VectorXd>;

// r at each lag, with the bounds that a white sequence of N samples keeps within at 95 % and 99 % of the lags:
// 1.96/sqrt(N), 2.576/sqrt(N).
struct Correlation {
  Eigen::VectorXd lag, r;
  double band95 = 0, band99 = 0;
};

// r_ee(tau) = sum (e(k+tau) - mean)(e(k) - mean) / sum (e(k) - mean)^2, tau = 0 ... lags.
Correlation autocorrelation(const Signals& e, int lags = 25);
// r_eu(tau) = sum (e(k+tau) - mean)(u(k) - mean) / sqrt(sum (e - mean)^2 sum (u - mean)^2), tau = -lags ... lags. At
// tau > 0 the error depends on past inputs: dynamics are missing; at tau < 0 the input depends on past errors:
// feedback.
Correlation cross_correlation(const Signals& e, const Signals& u, int lags = 25);

// What the correlations say. Whiteness: at most 20 % of the lags 1 ... outside of the 95 % band and none beyond twice
// the band.
struct Verdict {
  std::string name;    // "e with e", "e with u", "e^2 with u^2 ..."
  double outside = 0;  // part of the lags outside of the 95 % band, 0 to 1
  double largest = 0;  // greatest |r| of the lags that count
  bool passed = false;
  std::string meaning;  // in words
};
Verdict whiteness(const Correlation& autocorrelation);
Verdict independence(const Correlation& cross);

// The tests of linear and nonlinear models: e with e, with u, and (S. Billings and W. Voon 1986) u^2 with e, u^2 with
// e^2, e with e u, squares about their means.
struct ResidualTests {
  std::vector<Verdict> verdicts;
  std::vector<Correlation> correlations;  // of each verdict
};
ResidualTests residual_tests(const Signals& e, const Signals& u, int lags = 25);

// Counts in bins of equal width between the least and the greatest value, and the normal density of the same mean and
// variance (1/N), scaled to counts, at the middles of the bins.
struct Histogram {
  Eigen::VectorXd edges;   // bins + 1
  Eigen::VectorXd counts;  // bins
  Eigen::VectorXd normal;  // bins
  double mean = 0, deviation = 0;
};
Histogram histogram(const Eigen::VectorXd& x, int bins = 20);

}  // namespace plantloop::identify
