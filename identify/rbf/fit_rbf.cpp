// Radial networks from data: centres, weights, and all of them together.

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "identify/error.h"
#include "identify/fit/parallel.h"
#include "identify/fit/training.h"
#include "identify/gp/inducing.h"
#include "identify/linear/least_squares.h"
#include "identify/rbf/rbf_network.h"

namespace plantloop::identify {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd radial_matrix(Radial function, const MatrixXd& centres, const MatrixXd& widths, const MatrixXd& X) {
  MatrixXd phi(X.rows(), centres.rows());
  for (Index i = 0; i < centres.rows(); ++i) {
    for (Index k = 0; k < X.rows(); ++k) {
      const double s = ((X.row(k) - centres.row(i)).array() / widths.row(i).array()).square().sum();
      phi(k, i) = radial_value(function, s);
    }
  }
  return phi;
}

namespace {

constexpr std::array<const char*, 3> centre_names{"ols", "box", "spread"};

// All parameters of a network: weights row by row, centres row by row, logarithms of the widths row by row.
class RbfTraining final : public Training {
 public:
  RbfTraining(RbfShape shape, bool constant, MatrixXd x, MatrixXd y)
      : shape_(std::move(shape)), constant_(constant), x_(std::move(x)), y_(std::move(y)) {}
  Index parameters() const override { return shape_.weights.size() + 2 * shape_.centres.size(); }
  Index targets() const override { return y_.size(); }

  VectorXd theta() const {
    const Index w = shape_.weights.size(), c = shape_.centres.size();
    VectorXd theta(parameters());
    theta.head(w) = shape_.weights.reshaped();
    theta.segment(w, c) = shape_.centres.reshaped();
    theta.tail(c) = shape_.widths.reshaped().array().log().matrix();
    return theta;
  }
  RbfShape at(const VectorXd& theta) const {
    RbfShape shape = shape_;
    const Index w = shape.weights.size(), c = shape.centres.size();
    shape.weights.reshaped() = theta.head(w);
    shape.centres.reshaped() = theta.segment(w, c);
    shape.widths.reshaped() = theta.tail(c).array().exp().matrix();
    return shape;
  }
  std::vector<bool> fixed() const {
    std::vector<bool> fixed(static_cast<std::size_t>(parameters()), false);
    const Index outputs = shape_.weights.rows(), m = shape_.centres.rows();
    for (Index o = 0; o < outputs && !constant_; ++o) fixed[static_cast<std::size_t>(m * outputs + o)] = true;
    return fixed;
  }
  double sse(const VectorXd& theta) const override {
    const RbfShape shape = at(theta);
    return (y_ - outputs_of(shape, radial_matrix(shape.function, shape.centres, shape.widths, x_))).squaredNorm();
  }
  double normal(const VectorXd& theta, MatrixXd& R, VectorXd& g) const override {
    const RbfShape shape = at(theta);
    const Index n = x_.rows(), m = shape.centres.rows(), d = shape.centres.cols(), outputs = shape.weights.rows();
    const MatrixXd phi = radial_matrix(shape.function, shape.centres, shape.widths, x_);
    const MatrixXd error = y_ - outputs_of(shape, phi);
    R.setZero(parameters(), parameters());
    g.setZero(parameters());
    MatrixXd j(n, parameters());
    for (Index o = 0; o < outputs; ++o) {
      j.setZero();
      for (Index i = 0; i < m; ++i) j.col(i * outputs + o) = phi.col(i);
      if (constant_) j.col(m * outputs + o).setOnes();
      for (Index i = 0; i < m; ++i) {
        for (Index c = 0; c < d; ++c) {
          for (Index k = 0; k < n; ++k) {
            const VectorXd z = (x_.row(k) - shape.centres.row(i)).cwiseQuotient(shape.widths.row(i)).transpose();
            const double slope =
                2 * shape.weights(o, i) * radial_slope(shape.function, z.squaredNorm(), phi(k, i)) * z[c];
            j(k, shape.weights.size() + c * m + i) = -slope / shape.widths(i, c);
            j(k, shape.weights.size() + m * d + c * m + i) = -slope * z[c];
          }
        }
      }
      R.noalias() += j.transpose() * j;
      g.noalias() += j.transpose() * error.col(o);
    }
    return error.squaredNorm();
  }

 private:
  static MatrixXd outputs_of(const RbfShape& shape, const MatrixXd& phi) {
    const Index m = phi.cols();
    return (phi * shape.weights.leftCols(m).transpose()).rowwise() + shape.weights.col(m).transpose();
  }
  RbfShape shape_;
  bool constant_;
  MatrixXd x_, y_;
};

MatrixXd centres_in_box(const MatrixXd& x, int count, std::uint64_t seed) {
  Random random(seed);
  MatrixXd centres(count, x.cols());
  for (Index i = 0; i < count; ++i) {
    for (Index c = 0; c < x.cols(); ++c) centres(i, c) = random.uniform(x.col(c).minCoeff(), x.col(c).maxCoeff());
  }
  return centres;
}

void check(const MatrixXd& X, const MatrixXd& Y, const RbfOptions& options) {
  if (X.rows() == 0 || X.cols() == 0 || Y.cols() == 0) fail("the data has no rows or no columns");
  if (X.rows() != Y.rows()) fail("the inputs have {} rows and the targets {}; they must agree", X.rows(), Y.rows());
  if (!X.allFinite() || !Y.allFinite()) fail("the data has numbers that are not finite; leave such rows out");
  if (options.functions < 1) fail("the number of functions is {}; it must be 1 or more", options.functions);
  if (!(options.width > 0)) fail("the width is {:g}; it must be greater than 0", options.width);
  if (!(options.ridge >= 0)) fail("the ridge is {:g}; it must be 0 or greater", options.ridge);
  if (!(options.tolerance >= 0 && options.tolerance < 1)) {
    fail("the tolerance is the part of the variance that may stay unexplained, 0 or more and less than 1; it is {:g}",
         options.tolerance);
  }
  if (options.iterations < 0) fail("the number of iterations is {}; it must be 0 or more", options.iterations);
}

// Weights by least squares, output by output.
MatrixXd fit_weights(const MatrixXd& phi, const MatrixXd& y, const RbfOptions& options, FitReport& report) {
  const Index m = phi.cols();
  MatrixXd design(phi.rows(), options.constant ? m + 1 : m);
  design.leftCols(m) = phi;
  if (options.constant) design.col(m).setOnes();
  MatrixXd weights = MatrixXd::Zero(y.cols(), m + 1);
  for (Index o = 0; o < y.cols(); ++o) {
    const LeastSquares found = least_squares(design, y.col(o), {.ridge = options.ridge});
    weights.row(o).head(design.cols()) = found.theta.transpose();
    if (o == 0) report.warnings.insert(report.warnings.end(), found.warnings.begin(), found.warnings.end());
  }
  return weights;
}

// The selection orders functions without a ridge; the weights of the model may explain less.
void say_what_the_ridge_costs(const std::vector<double>& ratios, double sse, const MatrixXd& y,
                              const RbfOptions& options, FitReport& report) {
  if (options.ridge == 0 || ratios.empty()) return;
  const double total = options.constant ? (y.rowwise() - y.colwise().mean()).squaredNorm() : y.squaredNorm();
  const double explained = 1 - sse / total;
  const double without = std::accumulate(ratios.begin(), ratios.end(), 0.0);
  report.tried.push_back(
      fmt::format("the weights, with ridge {:g}, explain {:.6g} of the variance", options.ridge, explained));
  if (1 - explained > 1.1 * (1 - without)) {
    report.warnings.push_back(
        fmt::format("The ridge {:g} makes the weights explain {:.4g} of the variance instead of {:.4g}; take a smaller "
                    "one, or narrower functions.",
                    options.ridge, explained, without));
  }
}

}  // namespace

RbfCentres find_rbf_centres(const std::string& name) {
  for (std::size_t i = 0; i < centre_names.size(); ++i) {
    if (name == centre_names[i]) return static_cast<RbfCentres>(i);
  }
  fail("there is no choice of centres '{}'; there are {}", name, fmt::join(centre_names, ", "));
}

RbfFit fit_rbf(const MatrixXd& X, const MatrixXd& Y, const RbfOptions& options, const FitControl& control) {
  check(X, Y, options);
  const Scaling xs = range_scaling(X);
  Scaling ys = range_scaling(Y);
  if (!options.constant) ys.offset.setZero();  // else the normalisation would be a constant term
  const MatrixXd x = xs.normalised(X), y = ys.normalised(Y);
  RbfFit fit;
  FitReport& report = fit.report;
  RbfShape shape;
  shape.function = options.function;
  const auto widths = [&](Index count) { return MatrixXd::Constant(count, x.cols(), options.width); };
  if (options.centres == RbfCentres::box) {
    shape.centres = centres_in_box(x, options.functions, options.seed);
    report.seed = options.seed;
  } else if (options.centres == RbfCentres::spread) {
    shape.centres =
        x(spread_subset(x, std::min(options.functions, static_cast<int>(x.rows())), options.seed), Eigen::all);
    report.seed = options.seed;
  } else {
    MatrixXd candidates = x;
    if (x.rows() > options.candidates) {
      candidates = x(spread_subset(x, options.candidates, options.seed), Eigen::all);
      report.warnings.push_back(
          fmt::format("Of {} rows the {} most spread ones were candidates for centres.", x.rows(), options.candidates));
    }
    MatrixXd columns = radial_matrix(options.function, candidates, widths(candidates.rows()), x), targets = y;
    if (options.constant) {
      // What a constant explains is no merit of a centre.
      columns.rowwise() -= columns.colwise().mean().eval();
      targets.rowwise() -= targets.colwise().mean().eval();
    }
    const OlsSelection selection = select_columns(std::move(columns), targets, options.functions, options.tolerance);
    shape.centres = candidates(selection.columns, Eigen::all);
    fit.ratios = selection.ratios;
    double explained = 0;
    for (std::size_t i = 0; i < selection.ratios.size(); ++i) {
      explained += selection.ratios[i];
      report.tried.push_back(fmt::format("{} functions explain {:.6g} of the variance", i + 1, explained));
    }
    if (static_cast<int>(selection.columns.size()) < options.functions)
      report.stopped = "no further function explains more";
  }
  if (shape.centres.rows() == 0) {
    // Nothing to explain: the targets are constant.
    shape.centres = x.row(0);
    report.warnings.emplace_back("All targets are equal, so nothing can be learned from them.");
  }
  shape.widths = widths(shape.centres.rows());
  report.method = "least squares";
  report.measure = "mean square of the error of outputs normalised to 0 ... 1";
  if (report.stopped.empty()) report.stopped = fmt::format("{} functions were asked for", options.functions);
  if (report.tried.empty()) report.tried.push_back(fmt::format("{} centres", shape.centres.rows()));
  shape.weights = fit_weights(radial_matrix(shape.function, shape.centres, shape.widths, x), y, options, report);

  const RbfTraining training(shape, options.constant, x, y);
  report.reached = training.sse(training.theta()) / static_cast<double>(y.size());
  say_what_the_ridge_costs(fit.ratios, report.reached * static_cast<double>(y.size()), y, options, report);
  report.parameters = shape.weights.rows() * (shape.centres.rows() + (options.constant ? 1 : 0));
  if (options.optimise) {
    TrainingOptions how;
    how.iterations = options.iterations;
    how.fixed = training.fixed();
    Watch watch(control, options.iterations);
    const TrainingResult result = train(training, training.theta(), how, watch);
    shape = training.at(result.theta);
    report.method = "levenberg_marquardt of weights, centres and widths";
    report.tried.push_back(fmt::format("before: mean square {:.6g}", report.reached));
    report.reached = result.sse / static_cast<double>(y.size());
    report.iterations = result.iterations;
    if (result.at_limit)
      report.warnings.push_back(fmt::format(
          "Training stopped at its limit of {} iterations; more may improve the network.", result.iterations));
    report.stopped = result.stopped;
    report.parameters += 2 * shape.centres.size();
  }
  report.samples = X.rows();
  report.options.push_back(fmt::format("{}, width {:g}", name_of(options.function), options.width));
  report.options.push_back(fmt::format("functions {}", options.functions));
  if (options.centres != RbfCentres::ols)
    report.options.push_back(fmt::format("centres {}", centre_names[static_cast<std::size_t>(options.centres)]));
  if (!options.constant) report.options.emplace_back("no constant");
  if (options.ridge > 0) report.options.push_back(fmt::format("ridge {:g}", options.ridge));
  if (options.tolerance > 0) report.options.push_back(fmt::format("tolerance {:g}", options.tolerance));
  if (options.optimise) report.options.push_back(fmt::format("optimise, iterations {}", options.iterations));
  if (options.function == Radial::quadratic)
    report.warnings.push_back(fmt::format(
        "Sums of r^2 are quadratic functions of the inputs, so more than {} functions add nothing.", X.cols() + 2));
  if (!is_bounded(options.function))
    report.warnings.push_back(fmt::format(
        "'{}' grows without bound away from the data, so a simulated model may do so too.", name_of(options.function)));
  fit.model = std::make_shared<RbfNetwork>(std::move(shape), xs, ys);
  return fit;
}

}  // namespace plantloop::identify
