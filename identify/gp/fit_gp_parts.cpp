// Guesses and warnings of fits.

#include "identify/gp/fit_gp_parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace plantloop::identify {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

double variance_of(const VectorXd& y) { return (y.array() - y.mean()).square().mean(); }

Hyperparameters from_logs(const VectorXd& logs) {
  const Index p = logs.size() - 1;
  return {logs.head(p).array().exp().matrix(), std::exp(logs[p])};
}

VectorXd logs_of(const Hyperparameters& at) {
  VectorXd logs(at.theta.size() + 1);
  logs << at.theta.array().log().matrix(), std::log(at.v0);
  return logs;
}

VectorXd first_guess(const Covariance& covariance, const MatrixXd& x, const VectorXd& y) {
  const double v = variance_of(y), variance = v > 0 ? v : 1;
  return logs_of({covariance.guess(x, variance), 0.01 * variance});
}

void warn_of_data(const MatrixXd& x, Index inputs, const VectorXd& y, std::vector<std::string>& warnings) {
  if (variance_of(y) == 0) warnings.emplace_back("All targets are equal, so nothing can be learned from them.");
  for (Index d = 0; d < inputs; ++d) {
    if ((x.col(d).array() == x(0, d)).all())
      warnings.push_back(fmt::format("Input {} is constant, so its weight is not determined.", d + 1));
  }
  std::vector<Index> order(static_cast<std::size_t>(x.rows()));
  std::iota(order.begin(), order.end(), Index{0});
  const auto less = [&](Index a, Index b) {
    for (Index d = 0; d < x.cols(); ++d) {
      if (x(a, d) != x(b, d)) return x(a, d) < x(b, d);
    }
    return false;
  };
  std::sort(order.begin(), order.end(), less);
  int repeated = 0;
  for (std::size_t i = 1; i < order.size(); ++i) {
    if (!less(order[i - 1], order[i])) ++repeated;
  }
  if (repeated > 0)
    warnings.push_back(
        fmt::format("{} of {} points repeat an earlier one; they tell about the noise only, so it cannot become zero.",
                    repeated, x.rows()));
}

void warn_of_numbers(const GpPosterior& model, std::vector<std::string>& warnings) {
  if (model.jitter() > 0)
    warnings.push_back(fmt::format(
        "The covariances{} were singular to working precision; a jitter of {:.2g} was added to their diagonal.",
        model.is_sparse() ? " of the inducing inputs" : "", model.jitter()));
  const double scale = model.covariance().at(model.hyperparameters().theta, model.x()).mean();
  if (model.hyperparameters().v0 < 1e-9 * scale)
    warnings.push_back(fmt::format(
        "The noise variance {:.2g} is below 1e-9 of the function's; predicted variances are limited by rounding.",
        model.hyperparameters().v0));
}

void warn_of_result(const GpPosterior& model, const VectorXd& y, const VectorXd& guess, double bound,
                    std::vector<std::string>& warnings) {
  const Hyperparameters& found = model.hyperparameters();
  const std::vector<std::string> names = model.covariance().names(model.inputs());
  for (Index i = 0; i < found.theta.size(); ++i) {
    const double away = std::log(found.theta[i]) - guess[i];
    if (std::fabs(away) > bound - 1e-9)
      warnings.push_back(fmt::format("Hyperparameter {} stands at its {} bound {:.3g}.",
                                     names[static_cast<std::size_t>(i)], away < 0 ? "lower" : "upper", found.theta[i]));
  }
  const double variance = variance_of(y);
  if (variance > 0 && found.v0 > 0.9 * variance)
    warnings.push_back(fmt::format(
        "The noise variance {:.3g} explains nearly the whole variance {:.3g} of the targets.", found.v0, variance));
  warn_of_numbers(model, warnings);
}

}  // namespace plantloop::identify
