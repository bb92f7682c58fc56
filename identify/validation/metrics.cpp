// How far a prediction is from what was measured.

#include "identify/validation/metrics.h"

#include <cmath>
#include <limits>
#include <numbers>

#include "identify/error.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double nothing = std::numeric_limits<double>::quiet_NaN();

// What the measures are made of, over the samples that both have.
struct Sums {
  double count = 0, absolute = 0, squared = 0, largest = 0, mean = 0, spread = 0;  // spread: sum (y - mean)^2
};

Sums sums(const VectorXd& y, const VectorXd& prediction) {
  if (y.size() != prediction.size())
    fail("there are {} measured and {} predicted samples", y.size(), prediction.size());
  Sums s;
  const auto counts = [&](Index k) { return !std::isnan(y[k]) && !std::isnan(prediction[k]); };
  for (Index k = 0; k < y.size(); ++k) {
    if (!counts(k)) continue;
    const double e = std::fabs(y[k] - prediction[k]);
    s.count += 1;
    s.absolute += e;
    s.squared += e * e;
    s.largest = std::max(s.largest, e);
    s.mean += y[k];
  }
  s.mean /= s.count;
  for (Index k = 0; k < y.size(); ++k) {
    if (counts(k)) s.spread += (y[k] - s.mean) * (y[k] - s.mean);
  }
  return s;
}

}  // namespace

Counted check_predictions(const VectorXd& y, const VectorXd& prediction, const VectorXd& variance, Index skipped,
                          bool partial) {
  if (y.size() != prediction.size())
    fail("there are {} measured and {} predicted samples", y.size(), prediction.size());
  if (variance.size() > 0 && variance.size() != y.size())
    fail("there are {} predicted samples and {} variances", y.size(), variance.size());
  Counted counted;
  Index measured = 0, begun = 0, lost = 0, first_lost = 0;
  for (Index k = 0; k < y.size(); ++k) {
    if (std::isnan(y[k])) continue;
    ++measured;
    if (std::isnan(prediction[k])) {
      ++counted.without_prediction;
      if (begun > 0 && lost++ == 0) first_lost = k;
      continue;
    }
    ++begun;
    ++counted.samples;
    if (variance.size() > 0 && !(variance[k] > 0))
      fail(
          "the variance of sample {} is {}; it must be greater than 0: leave the first samples out with 'skip', or add "
          "the variance of the noise",
          skipped + k + 1, variance[k]);
  }
  const std::string rest = skipped > 0 ? fmt::format(" after the first {}", skipped) : "";
  if (measured == 0) fail("there is no measured sample to compare with{}", rest);
  if (counted.samples == 0) fail("there is no prediction at any of the {} measured samples{}", measured, rest);
  if (lost > 0 && !partial)
    fail(
        "there is no prediction at {} of {} measured samples, the first of them sample {}: a measure would speak of "
        "the "
        "others only. With 'partial = true' they are left out",
        lost, measured, skipped + first_lost + 1);
  return counted;
}

double absolute_error(const VectorXd& y, const VectorXd& prediction) {
  const Sums s = sums(y, prediction);
  return s.absolute / s.count;
}
double squared_error(const VectorXd& y, const VectorXd& prediction) {
  const Sums s = sums(y, prediction);
  return s.squared / s.count;
}
double root_mean_square_error(const VectorXd& y, const VectorXd& prediction) {
  return std::sqrt(squared_error(y, prediction));
}
double normalised_rmse(const VectorXd& y, const VectorXd& prediction) {
  const Sums s = sums(y, prediction);
  return std::sqrt(s.squared / s.spread);
}
double fit_percent(const VectorXd& y, const VectorXd& prediction) { return 100 * (1 - normalised_rmse(y, prediction)); }
double largest_error(const VectorXd& y, const VectorXd& prediction) {
  const Sums s = sums(y, prediction);
  return s.count > 0 ? s.largest : nothing;
}

double log_density_error(const VectorXd& y, const VectorXd& prediction, const VectorXd& variance) {
  if (y.size() != prediction.size() || y.size() != variance.size()) {
    fail("there are {} measured samples, {} predictions and {} variances", y.size(), prediction.size(),
         variance.size());
  }
  double sum = 0;
  double count = 0;
  for (Index k = 0; k < y.size(); ++k) {
    const double e = y[k] - prediction[k];
    if (std::isnan(e)) continue;
    sum += std::log(2 * std::numbers::pi) + std::log(variance[k]) + e * e / variance[k];
    count += 1;
  }
  return sum / (2 * count);
}

double coverage(const VectorXd& y, const VectorXd& prediction, const VectorXd& variance, double factor) {
  if (y.size() != prediction.size() || y.size() != variance.size()) {
    fail("there are {} measured samples, {} predictions and {} variances", y.size(), prediction.size(),
         variance.size());
  }
  double inside = 0;
  double count = 0;
  for (Index k = 0; k < y.size(); ++k) {
    const double e = y[k] - prediction[k];
    if (std::isnan(e)) continue;
    count += 1;
    if (std::fabs(e) <= factor * std::sqrt(variance[k])) inside += 1;
  }
  return inside / count;
}

double akaike(double sse, double samples, double parameters) {
  return samples * std::log(sse / samples) + 2 * parameters;
}
double minimum_description_length(double sse, double samples, double parameters) {
  return samples * std::log(sse / samples) + parameters * std::log(samples);
}
double final_prediction_error(double sse, double samples, double parameters) {
  if (!(samples > parameters)) return nothing;
  return (samples + parameters) / (samples - parameters) * sse / (2 * samples);
}

const std::vector<Metric>& metrics() {
  static const std::vector<Metric> list{
      {"AE", "mean of |e|", absolute_error, true},
      {"SE", "mean of e^2", squared_error},
      {"RMSE", "root of the mean of e^2", root_mean_square_error, true},
      {"nRMSE", "RMSE over the standard deviation of the measured output", normalised_rmse},
      {"FIT", "100 (1 - |e|/|y - mean y|), in %", fit_percent},
      {"max", "largest |e|", largest_error, true},
  };
  return list;
}

}  // namespace plantloop::identify
