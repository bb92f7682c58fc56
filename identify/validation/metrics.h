// How far a prediction is from what was measured: the measures of the book, by name.

#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

namespace plantloop::identify {

// Raises IdentifyError unless measures of these samples mean something: some sample was measured; from the first
// prediction on every measured sample has one, unless `partial`; variances, when there are any, are greater than 0
// where they count. Samples are counted from 1 and from `skipped` + 1. Gives how many samples count, and at how many
// measured ones there is no prediction.
struct Counted {
  Eigen::Index samples = 0, without_prediction = 0;
};
Counted check_predictions(const Eigen::VectorXd& y, const Eigen::VectorXd& prediction, const Eigen::VectorXd& variance,
                          Eigen::Index skipped, bool partial);

// y: measured, prediction: of the model, both of one length; e = y - prediction. Samples at which either is NaN are not
// counted: see check_predictions(). All are NaN when no sample is left.
double absolute_error(const Eigen::VectorXd& y, const Eigen::VectorXd& prediction);          // AE = mean |e|
double squared_error(const Eigen::VectorXd& y, const Eigen::VectorXd& prediction);           // SE = mean e^2
double root_mean_square_error(const Eigen::VectorXd& y, const Eigen::VectorXd& prediction);  // RMSE = sqrt(SE)
double normalised_rmse(const Eigen::VectorXd& y, const Eigen::VectorXd& prediction);  // RMSE / std(y), std with 1/N
double fit_percent(const Eigen::VectorXd& y, const Eigen::VectorXd& prediction);  // FIT = 100 (1 - |e| / |y - mean y|)
double largest_error(const Eigen::VectorXd& y, const Eigen::VectorXd& prediction);  // max |e|
// LD = 1/(2N) sum [log 2pi + log s2 + e^2/s2], the mean negative log density; `variance` is that of each prediction.
double log_density_error(const Eigen::VectorXd& y, const Eigen::VectorXd& prediction, const Eigen::VectorXd& variance);
// The part (0 to 1) of the samples within `factor` standard deviations of the prediction.
double coverage(const Eigen::VectorXd& y, const Eigen::VectorXd& prediction, const Eigen::VectorXd& variance,
                double factor = 1.959963984540054);

// Criteria for models of different size, of the sum of squared errors, the number of samples and of parameters.
double akaike(double sse, double samples, double parameters);                      // AIC = N log(SSE/N) + 2p
double minimum_description_length(double sse, double samples, double parameters);  // MDL = N log(SSE/N) + p log N
double final_prediction_error(double sse, double samples, double parameters);      // FPE = (N+p)/(N-p) SSE/(2N)

// The measures without variance under the names that reports and scripts use: AE, SE, RMSE, nRMSE, FIT, max.
struct Metric {
  std::string_view name;
  std::string_view doc;
  double (*value)(const Eigen::VectorXd& y, const Eigen::VectorXd& prediction);
  bool in_units = false;  // of the output; else a pure number or a square
};
const std::vector<Metric>& metrics();

}  // namespace plantloop::identify
