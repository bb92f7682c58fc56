// Estimates that plots show: quantiles, density, correlation, spectrum.

#pragma once

#include <vector>

namespace plantloop {

// `count` numbers, at least two, from one end to the other.
std::vector<double> evenly(double from, double to, int count);

// What is finite, ascending.
std::vector<double> finite_sorted(const std::vector<double>& values);
// By linear interpolation between the sorted values (definition 7 of Hyndman and Fan, 1996); NaN without values.
double quantile(const std::vector<double>& sorted, double part);
double mean(const std::vector<double>& values);
double deviation(const std::vector<double>& values);  // of the sample, with n - 1

// The width of a bar after Freedman and Diaconis (1981), 2 iqr n^(-1/3), rounded so that the bars end at nice numbers;
// edges of the bars, ascending. `count` > 0 asks for so many bars.
std::vector<double> histogram_edges(const std::vector<double>& sorted, int count);

// Density of the values at x, with a Gaussian kernel of Silverman's width (1986, eq. 3.31).
std::vector<double> kernel_density(const std::vector<double>& sorted, const std::vector<double>& x);

// sum (a_k - mean a)(b_(k+lag) - mean b) / (n sd a sd b) for lags -most to most; entries that are not finite count as
// the mean.
std::vector<double> correlation(const std::vector<double>& a, const std::vector<double>& b, int most);

// One-sided power spectral density after Welch (1967): segments of `length` samples with a Hann window, overlapping by
// half, the mean taken away from each. density in (unit of y)^2 / Hz; the integral over frequency is the variance.
struct Spectrum {
  std::vector<double> frequency, density;  // Hz
  int segments = 0;
};
Spectrum welch(const std::vector<double>& y, double period, std::size_t length);

}  // namespace plantloop
