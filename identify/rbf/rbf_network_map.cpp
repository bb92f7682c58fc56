// Evaluating radial networks, and their model file.

#include <memory>

#include "identify/error.h"
#include "identify/rbf/rbf_network.h"

namespace plantloop::identify {

using Eigen::Index;
using Eigen::MatrixXd;

RbfNetwork::RbfNetwork(RbfShape shape, Scaling x, Scaling y)
    : shape_(std::move(shape)), x_(std::move(x)), y_(std::move(y)) {
  const Index m = shape_.centres.rows(), d = shape_.centres.cols();
  if (shape_.widths.rows() != m || shape_.widths.cols() != d || shape_.weights.cols() != m + 1 || x_.size() != d ||
      y_.size() != shape_.weights.rows())
    fail("{} centres of {} inputs need {} x {} widths and {} weights for each output", m, d, m, d, m + 1);
  if (m > 0 && !(shape_.widths.array() > 0).all()) fail("widths must be greater than 0");
}

void RbfNetwork::evaluate(const double* x, double* y, double* scratch) const {
  const Index m = shape_.centres.rows(), d = shape_.centres.cols();
  double* z = scratch + m;
  for (Index j = 0; j < d; ++j) z[j] = (x[j] - x_.offset[j]) / x_.scale[j];
  for (Index i = 0; i < m; ++i) {
    double s = 0;
    for (Index j = 0; j < d; ++j) {
      const double distance = (z[j] - shape_.centres(i, j)) / shape_.widths(i, j);
      s += distance * distance;
    }
    scratch[i] = radial_value(shape_.function, s);
  }
  for (Index o = 0; o < shape_.weights.rows(); ++o) {
    double sum = shape_.weights(o, m);
    for (Index i = 0; i < m; ++i) sum += shape_.weights(o, i) * scratch[i];
    y[o] = y_.offset[o] + y_.scale[o] * sum;
  }
}

void RbfNetwork::derivative(const double* x, double* jacobian, double* scratch) const {
  const Index m = shape_.centres.rows(), d = shape_.centres.cols(), outputs = shape_.weights.rows();
  double* z = scratch + m;
  for (Index j = 0; j < d; ++j) z[j] = (x[j] - x_.offset[j]) / x_.scale[j];
  for (Index k = 0; k < outputs * d; ++k) jacobian[k] = 0;
  for (Index i = 0; i < m; ++i) {
    double s = 0;
    for (Index j = 0; j < d; ++j) {
      const double distance = (z[j] - shape_.centres(i, j)) / shape_.widths(i, j);
      s += distance * distance;
    }
    const double slope = 2 * radial_slope(shape_.function, s, radial_value(shape_.function, s));
    for (Index j = 0; j < d; ++j) {
      const double width = shape_.widths(i, j);
      const double by_z = slope * (z[j] - shape_.centres(i, j)) / (width * width);
      for (Index o = 0; o < outputs; ++o) jacobian[o * d + j] += shape_.weights(o, i) * by_z;
    }
  }
  for (Index o = 0; o < outputs; ++o) {
    for (Index j = 0; j < d; ++j) jacobian[o * d + j] *= y_.scale[o] / x_.scale[j];
  }
}

void RbfNetwork::write(Item& item) const {
  write_scaling(item, "x_scaling", x_);
  write_scaling(item, "y_scaling", y_);
  item.set("function", name_of(shape_.function))
      .set("centres", shape_.centres)
      .set("widths", shape_.widths)
      .set("weights", shape_.weights);
}

std::shared_ptr<const Approximator> read_rbf_network(const Item& item) {
  RbfShape shape;
  const std::string name = item.text("function");
  try {
    shape.function = find_radial(name);
  } catch (const IdentifyError& error) {
    item.at("function").wrong(error.what());
  }
  shape.centres = item.matrix("centres");
  if (shape.centres.rows() < 1 || shape.centres.cols() < 1)
    item.at("centres").wrong("a network needs at least one centre with at least one input");
  shape.widths = item.matrix("widths", shape.centres.rows(), shape.centres.cols());
  shape.weights = item.matrix("weights", -1, shape.centres.rows() + 1);
  if (shape.weights.rows() < 1) item.at("weights").wrong("a network needs a row of weights for each output");
  if (!(shape.widths.array() > 0).all()) item.at("widths").wrong("widths must be greater than 0");
  if (!shape.centres.allFinite() || !shape.widths.allFinite() || !shape.weights.allFinite())
    item.wrong("centres, widths and weights must be finite");
  Scaling x = read_scaling(item, "x_scaling", shape.centres.cols());
  Scaling y = read_scaling(item, "y_scaling", shape.weights.rows());
  return std::make_shared<RbfNetwork>(std::move(shape), std::move(x), std::move(y));
}

}  // namespace plantloop::identify
