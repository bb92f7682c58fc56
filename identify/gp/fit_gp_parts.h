// What fits of exact and of sparse processes share.

#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "identify/gp/posterior.h"

namespace plantloop::identify {

double variance_of(const Eigen::VectorXd& y);

// The logarithms of theta and, last, of v0.
Hyperparameters from_logs(const Eigen::VectorXd& logs);
Eigen::VectorXd logs_of(const Hyperparameters& at);
// A sensible place to start.
Eigen::VectorXd first_guess(const Covariance& covariance, const Eigen::MatrixXd& x, const Eigen::VectorXd& y);

// Of data that tell little, of numbers at the edge of rounding, and of what was found (`y`: the targets; `guess`,
// `bound`: as in GpOptions).
void warn_of_data(const Eigen::MatrixXd& x, Eigen::Index inputs, const Eigen::VectorXd& y,
                  std::vector<std::string>& warnings);
void warn_of_numbers(const GpPosterior& model, std::vector<std::string>& warnings);
void warn_of_result(const GpPosterior& model, const Eigen::VectorXd& y, const Eigen::VectorXd& guess, double bound,
                    std::vector<std::string>& warnings);

}  // namespace plantloop::identify
