// What is left in the residuals: correlations with bounds, verdicts, histograms.

#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace plantloop::identify {

// Residuals or signals of each experiment. NaN (a missing value) counts as no contribution.
using Signals = std::vector<Eigen::VectorXd>;

// r at each lag, with the bounds that it keeps within at 95 % and 99 % of the lags when there is nothing to find:
// 1.96 sqrt(P_0/N), 2.576 sqrt(P_0/N). For a sequence with itself P_0 = 1, which is for white ones. For two sequences
// that do not depend on each other, N cov(r(tau), r(tau + l)) = P_l = sum_k r_aa(k) r_bb(k + l) (M. Bartlett 1955; L.
// Ljung 1999, section 16.6): slow ones are alike by chance far more often than white ones. The sum is over |k| <= 100
// (at most a quarter of the samples) with weights that fall to 0 along a line, and is at least 1/4.
struct Correlation {
  Eigen::VectorXd lag, r;
  double band95 = 0, band99 = 0;
  Eigen::VectorXd alike;  // P_l/P_0, l = 0 ...: how far r at neighbouring lags is one and the same chance
};

// r_ee(tau) = sum (e(k+tau) - mean)(e(k) - mean) / sum (e(k) - mean)^2, tau = 0 ... lags.
Correlation autocorrelation(const Signals& e, int lags = 25);
// r_eu(tau) = sum (e(k+tau) - mean)(u(k) - mean) / sqrt(sum (e - mean)^2 sum (u - mean)^2), tau = -lags ... lags. At
// tau > 0 the error depends on past inputs: dynamics are missing; at tau < 0 the input depends on past errors:
// feedback.
Correlation cross_correlation(const Signals& e, const Signals& u, int lags = 25);

// What the correlations say, at a level of 1 % for all lags together: in one hundred records without anything to find,
// one is found fault with. Half of it goes to the greatest |r| (N. Sidak 1967), which finds a lone lag, and half to the
// sum of squares over the lags, which finds many small ones. That sum is sum_i lambda_i chi^2 with the eigenvalues of
// the matrix of `alike`, near g chi^2_h with its mean and variance (F. Satterthwaite 1946), whose quantile is that of
// E. Wilson and M. Hilferty (1931).
struct Verdict {
  std::string name;    // "e with e", "e with u", "e^2 with u^2 ..."
  double outside = 0;  // part of the lags outside of the 95 % band, 0 to 1; 0.05 is to be expected
  double largest = 0;  // greatest |r| of the lags that count
  bool passed = false;
  std::string meaning;  // in words
};
Verdict whiteness(const Correlation& autocorrelation);
Verdict independence(const Correlation& cross);

// The tests of linear and nonlinear models: e with e, with u, and (S. Billings and W. Voon 1986) u^2 with e, u^2 with
// e^2, e with e u at lags from 1, squares about their means. What a square that does not vary cannot show is said.
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
