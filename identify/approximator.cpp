// Learned maps: rows of data through them, and reading them from model files.

#include "identify/approximator.h"

#include <fmt/format.h>

#include <algorithm>

namespace plantloop::identify {

void Approximator::variance(const double*, double* result, double*) const { std::fill_n(result, outputs(), 0.0); }

void Approximator::variance_derivative(const double*, double* jacobian, double*) const {
  std::fill_n(jacobian, outputs() * inputs(), 0.0);
}

Eigen::MatrixXd evaluate_rows(const Approximator& map, const Eigen::MatrixXd& X) {
  std::vector<double> scratch(static_cast<std::size_t>(map.scratch_size()));
  Eigen::MatrixXd Y(X.rows(), map.outputs());
  Eigen::VectorXd x(X.cols()), y(map.outputs());
  for (Eigen::Index i = 0; i < X.rows(); ++i) {
    x = X.row(i).transpose();
    map.evaluate(x.data(), y.data(), scratch.data());
    Y.row(i) = y.transpose();
  }
  return Y;
}

std::shared_ptr<const Approximator> read_approximator(const Item& item) {
  const std::string type = item.text("type");
  std::vector<std::string_view> known;
  for (const ApproximatorType& kind : approximators()) {
    if (kind.name == type) return kind.read(item);
    known.push_back(kind.name);
  }
  item.at("type").wrong(
      fmt::format("a model of type '{}' is no learned map; there are {}", type, fmt::join(known, ", ")));
}

}  // namespace plantloop::identify
