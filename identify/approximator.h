// A learned map from a vector of regressors to outputs, whatever it is made of: what simulation and blocks run.

#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "identify/model_file/item.h"

namespace plantloop::identify {

// Immutable and shared by threads; what changes while evaluating lives in the caller's scratch. All numbers are in the
// user's units: a normalisation is inside.
class Approximator {
 public:
  virtual ~Approximator() = default;
  // Of the model file, and of the block that runs it: "mlp", "rbf_network", ...
  virtual std::string type() const = 0;
  virtual int inputs() const = 0;
  virtual int outputs() const = 0;
  // Doubles that evaluate and derivative may use.
  virtual int scratch_size() const = 0;
  virtual void evaluate(const double* x, double* y, double* scratch) const = 0;
  // dy_i/dx_j, row by row (outputs x inputs).
  virtual void derivative(const double* x, double* jacobian, double* scratch) const = 0;
  // Whether the outputs are affine in x, so that the derivative is the same everywhere.
  virtual bool is_affine() const { return false; }
  // How certain each output is: the variance of the function, without the noise of a measurement; 0 where the map does
  // not know. Then its derivative, as above.
  virtual bool has_variance() const { return false; }
  virtual void variance(const double* x, double* result, double* scratch) const;
  virtual void variance_derivative(const double* x, double* jacobian, double* scratch) const;
  // Adds what read_approximator needs.
  virtual void write(Item& item) const = 0;
};

// For each row of X, N x inputs: N x outputs, by evaluate().
Eigen::MatrixXd evaluate_rows(const Approximator& map, const Eigen::MatrixXd& X);

// The map that a model file holds; `item` is what read_model_file gave. Raises IdentifyError.
std::shared_ptr<const Approximator> read_approximator(const Item& item);

// A kind of map that a model file may hold. A file <type>_map.cpp defines read_<type>(); CMake makes the list.
struct ApproximatorType {
  std::string_view name;
  std::shared_ptr<const Approximator> (*read)(const Item& item);
};
const std::vector<ApproximatorType>& approximators();

}  // namespace plantloop::identify
