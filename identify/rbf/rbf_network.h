// Networks of radial basis functions: a weighted sum of functions of the distance from centres.

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "identify/approximator.h"
#include "identify/fit_report.h"
#include "identify/rbf/radial.h"
#include "identify/scaling.h"

namespace plantloop::identify {

// y = weights [phi(|x - c_1|), ..., phi(|x - c_M|), 1], of normalised numbers.
struct RbfShape {
  Radial function = Radial::gaussian;
  Eigen::MatrixXd centres;  // M x D
  Eigen::MatrixXd widths;   // M x D, rho_ij > 0
  Eigen::MatrixXd weights;  // outputs x (M + 1); the constant is the last column
};

class RbfNetwork final : public Approximator {
 public:
  // Raises IdentifyError when sizes differ or a width is not greater than 0.
  RbfNetwork(RbfShape shape, Scaling x, Scaling y);

  std::string type() const override { return "rbf_network"; }
  int inputs() const override { return static_cast<int>(shape_.centres.cols()); }
  int outputs() const override { return static_cast<int>(shape_.weights.rows()); }
  int scratch_size() const override { return static_cast<int>(shape_.centres.rows()) + inputs(); }
  void evaluate(const double* x, double* y, double* scratch) const override;
  void derivative(const double* x, double* jacobian, double* scratch) const override;
  void write(Item& item) const override;

  const RbfShape& shape() const { return shape_; }
  const Scaling& x_scaling() const { return x_; }
  const Scaling& y_scaling() const { return y_; }

 private:
  RbfShape shape_;
  Scaling x_, y_;
};

// phi for all rows of X (N x D, normalised): N x M.
Eigen::MatrixXd radial_matrix(Radial function, const Eigen::MatrixXd& centres, const Eigen::MatrixXd& widths,
                              const Eigen::MatrixXd& X);

// Orthogonal least squares (S. Chen, C. Cowan, P. Grant 1991): of the columns of P those that explain D best, one
// after the other, by their error reduction ratio sum_o (w'd_o)^2/(w'w)/sum_o d_o'd_o after what the chosen ones
// explain is taken away. Ends at `most` columns, when 1 - sum of ratios is below `tolerance`, or when what is left of
// every column is rounding (1e-10 of its square).
struct OlsSelection {
  std::vector<Eigen::Index> columns;
  std::vector<double> ratios;
};
OlsSelection select_columns(Eigen::MatrixXd P, const Eigen::MatrixXd& D, int most, double tolerance = 0);

enum class RbfCentres {
  ols,     // rows of the data, chosen by orthogonal least squares
  box,     // uniformly distributed in the box of the data
  spread,  // rows of the data that lie far from each other
};
RbfCentres find_rbf_centres(const std::string& name);  // raises IdentifyError

struct RbfOptions {
  Radial function = Radial::gaussian;
  RbfCentres centres = RbfCentres::ols;
  int functions = 20;
  double width = 0.3;    // rho of every function and input, where inputs are normalised to [0, 1]
  bool constant = true;  // add a constant term
  // Adds ridge |weights|^2 to the sum of squared errors, in units of the normalised outputs. Wide functions are nearly
  // dependent and need great weights, on which even a ridge of 1e-8 weighs heavily.
  double ridge = 0;
  double tolerance = 0;   // of ols: ends when less than this part of the variance is unexplained, 0 to 1
  int candidates = 2000;  // of ols: from more rows than that the most spread ones are taken
  bool optimise = false;  // go on with centres and widths by Levenberg-Marquardt
  int iterations = 200;
  std::uint64_t seed = 1;
};

struct RbfFit {
  std::shared_ptr<const RbfNetwork> model;
  FitReport report;            // `reached`: mean square of the error in units of the outputs' ranges
  std::vector<double> ratios;  // of ols: error reduction of each centre, in the order of choice
};

// X: N x D, Y: N x outputs. Weights by least squares. Raises IdentifyError.
RbfFit fit_rbf(const Eigen::MatrixXd& X, const Eigen::MatrixXd& Y, const RbfOptions& options = {},
               const FitControl& control = {});

}  // namespace plantloop::identify
