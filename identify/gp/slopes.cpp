// Values and slopes: fast blocks where values meet, pairs where slopes do.

#include "identify/gp/slopes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "identify/error.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

class SlopeCovariance final : public Covariance {
 public:
  SlopeCovariance(std::shared_ptr<const Covariance> base, int inputs) : base_(std::move(base)), d_(inputs) {}

  std::string name() const override { return base_->name(); }
  std::vector<std::string> names(int inputs) const override { return base_->names(inputs); }
  int inputs_of(Index) const override { return d_; }
  Vector noise_weight(const Matrix& x) const override {
    Vector weight = Vector::Ones(x.rows());
    for (Index i = 0; i < x.rows(); ++i) weight[i] = noise(x, i) < 0 ? 1 : 0;
    return weight;
  }
  Vector noise_variances(const Matrix& x, double v0) const override {
    Vector variances(x.rows());
    for (Index i = 0; i < x.rows(); ++i) variances[i] = noise(x, i) < 0 ? v0 : noise(x, i);
    return variances;
  }
  Vector guess(const Matrix& x, double variance) const override {
    return base_->guess(x(values_of(x), Eigen::seqN(0, d_)), variance);
  }

  Matrix between(const Vector& theta, const Matrix& x, const Matrix& z) const override {
    const std::vector<Index> xv = values_of(x), zv = values_of(z);
    Matrix k(x.rows(), z.rows());
    k(xv, zv) = base_->between(theta, points(x, xv), points(z, zv));
    Matrix block;
    for (Index j = 0; j < z.rows(); ++j) {
      for (Index i = 0; i < x.rows(); ++i) {
        if (what(x, i) == 0 && what(z, j) == 0) continue;
        base_->slopes(theta, point(x, i), point(z, j), block, nullptr);
        k(i, j) = block(what(x, i), what(z, j));
      }
    }
    return k;
  }
  Matrix lower(const Vector& theta, const Matrix& x) const override {
    const std::vector<Index> v = values_of(x);
    Matrix k = Matrix::Zero(x.rows(), x.rows());
    k(v, v) = base_->lower(theta, points(x, v));
    Matrix block;
    each_pair(x, [&](Index i, Index j) {
      base_->slopes(theta, point(x, i), point(x, j), block, nullptr);
      k(i, j) = block(what(x, i), what(x, j));
    });
    for (Index i = 0; i < x.rows(); ++i) k(i, i) += std::max(0.0, noise(x, i));
    return k;
  }
  Vector at(const Vector& theta, const Matrix& x) const override {
    const std::vector<Index> v = values_of(x);
    Vector k(x.rows());
    k(v) = base_->at(theta, points(x, v));
    Matrix block;
    for (Index i = 0; i < x.rows(); ++i) {
      if (what(x, i) == 0) continue;
      base_->slopes(theta, point(x, i), point(x, i), block, nullptr);
      k[i] = block(what(x, i), what(x, i));
    }
    return k;
  }
  Vector gradient(const Vector& theta, const Matrix& x, const Matrix&, const Matrix& weight) const override {
    const std::vector<Index> v = values_of(x);
    const Matrix xv = points(x, v);
    Vector sums = Vector::Zero(theta.size());
    if (!v.empty()) sums = base_->gradient(theta, xv, base_->lower(theta, xv), weight(v, v));
    Matrix block;
    std::vector<Matrix> by_theta;
    each_pair(x, [&](Index i, Index j) {
      base_->slopes(theta, point(x, i), point(x, j), block, &by_theta);
      const double w = (i == j ? 1 : 2) * weight(i, j);
      for (Index p = 0; p < sums.size(); ++p) sums[p] += w * by_theta[at_index(p)](what(x, i), what(x, j));
    });
    return sums;
  }
  // Sparse processes are of values alone.
  Vector cross_gradient(const Vector&, const Matrix&, const Matrix&, const Matrix&, const Matrix&,
                        Matrix*) const override {
    fail("a sparse process cannot take observations of slopes");
  }
  Vector own_gradient(const Vector&, const Matrix&, const Vector&) const override {
    fail("a sparse process cannot take observations of slopes");
  }
  // At a value x.
  Matrix input_gradient(const Vector& theta, const Vector& x, const Matrix& z) const override {
    const std::vector<Index> v = values_of(z);
    Matrix gradient(z.rows(), d_);
    gradient(v, Eigen::all) = base_->input_gradient(theta, x, points(z, v));
    Matrix block;
    for (Index j = 0; j < z.rows(); ++j) {
      if (what(z, j) == 0) continue;
      base_->slopes(theta, x, point(z, j), block, nullptr);
      gradient.row(j) = block.col(what(z, j)).tail(d_).transpose();
    }
    return gradient;
  }

 private:
  static std::size_t at_index(Index p) { return static_cast<std::size_t>(p); }
  int what(const Matrix& x, Index i) const { return x.cols() == d_ ? 0 : static_cast<int>(x(i, d_)); }
  double noise(const Matrix& x, Index i) const { return x.cols() == d_ ? -1 : x(i, d_ + 1); }
  Vector point(const Matrix& x, Index i) const { return x.row(i).head(d_).transpose(); }
  Matrix points(const Matrix& x, const std::vector<Index>& rows) const { return x(rows, Eigen::seqN(0, d_)); }
  std::vector<Index> values_of(const Matrix& x) const {
    std::vector<Index> rows;
    for (Index i = 0; i < x.rows(); ++i) {
      if (what(x, i) == 0) rows.push_back(i);
    }
    return rows;
  }
  // The pairs i >= j of which one at least is a slope.
  template <typename F>
  void each_pair(const Matrix& x, F f) const {
    for (Index j = 0; j < x.rows(); ++j) {
      for (Index i = j; i < x.rows(); ++i) {
        if (what(x, i) > 0 || what(x, j) > 0) f(i, j);
      }
    }
  }
  std::shared_ptr<const Covariance> base_;
  int d_;
};

// The regressor of one lag, or -1.
int place_of(const RegressorSet& set, bool of_output, int channel, int lag) {
  const Factor wanted{of_output, channel, lag, 1};
  for (std::size_t i = 0; i < set.list.size(); ++i) {
    if (set.list[i].factors.size() == 1 && set.list[i].factors.front() == wanted) return static_cast<int>(i);
  }
  return -1;
}

// -a1 ... -an, then the numerators' coefficients from delay 0 on, of y(k) = sum ... about the operating point.
VectorXd coefficients(const PolynomialModel& model) {
  const PolynomialModel::Common c = model.common();
  Index size = c.denominator.size() - 1;
  for (const VectorXd& b : c.numerators) size += b.size();
  VectorXd all(size);
  all.head(c.denominator.size() - 1) = -c.denominator.tail(c.denominator.size() - 1);
  size = c.denominator.size() - 1;
  for (const VectorXd& b : c.numerators) {
    all.segment(size, b.size()) = b;
    size += b.size();
  }
  return all;
}

// To first order, by central differences of the parameters.
VectorXd variances_of(const PolynomialModel& model) {
  const VectorXd theta = model.parameters(), at = coefficients(model);
  if (model.covariance.rows() != theta.size()) return VectorXd::Zero(at.size());
  if (!model.covariance.allFinite())
    fail("the linear model's parameters have no finite covariance: its data do not determine them");
  MatrixXd jacobian(at.size(), theta.size());
  PolynomialModel moved = model;
  for (Index p = 0; p < theta.size(); ++p) {
    const double h = 1e-5 * std::max(1.0, std::fabs(theta[p]));
    VectorXd there = theta, back = theta;
    there[p] += h;
    back[p] -= h;
    moved.set_parameters(there);
    jacobian.col(p) = coefficients(moved);
    moved.set_parameters(back);
    jacobian.col(p) = (jacobian.col(p) - coefficients(moved)).eval() / (2 * h);
  }
  return (jacobian * model.covariance * jacobian.transpose()).diagonal().cwiseMax(0.0);
}

}  // namespace

std::shared_ptr<const Covariance> with_slopes(std::shared_ptr<const Covariance> base, int inputs) {
  const VectorXd theta = VectorXd::Ones(base->count(inputs)), origin = VectorXd::Zero(inputs);
  MatrixXd block;
  if (!base->slopes(theta, origin, origin, block, nullptr))
    fail(
        "slopes can be observed with se_ard, matern_3_2, matern_5_2, rational_quadratic, linear, their sums and "
        "products, not with '{}'",
        base->name());
  return std::make_shared<SlopeCovariance>(std::move(base), inputs);
}

std::vector<Observation> observations_of(const PolynomialModel& model, const RegressorSet& regressors) {
  const auto channel_of = [](const std::vector<std::string>& names, const std::string& name) {
    const auto found = std::find(names.begin(), names.end(), name);
    if (found == names.end())
      fail("the linear model has the signal '{}', the regressors are of {}", name, fmt::join(names, ", "));
    return static_cast<int>(found - names.begin());
  };
  const int output = channel_of(regressors.outputs, model.output.name);
  std::vector<int> inputs;
  for (const Channel& channel : model.inputs) inputs.push_back(channel_of(regressors.inputs, channel.name));
  VectorXd rest(regressors.size());
  for (Index i = 0; i < rest.size(); ++i) {
    const Regressor& r = regressors.list[static_cast<std::size_t>(i)];
    if (r.degree() > 1) fail("a linear model tells slopes by single lags, not by '{}'", to_text(r, regressors));
    rest[i] = 1;
    if (r.factors.empty()) continue;
    const Factor& f = r.factors.front();
    const auto input = std::find(inputs.begin(), inputs.end(), f.channel);
    if (f.of_output ? f.channel != output : input == inputs.end())
      fail("the linear model says nothing of '{}': the signal is not part of it", to_text(r, regressors));
    rest[i] = f.of_output ? model.level() : model.u0[input - inputs.begin()];
  }

  const double samples = static_cast<double>(std::max(1LL, model.fit.samples));
  std::vector<Observation> list{{rest, 0, model.level(), model.variance / samples}};
  const VectorXd slopes = coefficients(model), variances = variances_of(model);
  Index at = 0;
  const auto add = [&](bool of_output, int channel, int lag) {
    const int place = place_of(regressors, of_output, channel, lag);
    // Zeros of a delay stand in the numerators; they say something only where somebody asks.
    if (place >= 0) {
      list.push_back({rest, place + 1, slopes[at], variances[at]});
    } else if (slopes[at] != 0) {
      const std::string& name = of_output ? regressors.outputs[static_cast<std::size_t>(channel)]
                                          : regressors.inputs[static_cast<std::size_t>(channel)];
      fail("the linear model looks back to {}(k-{}), which is not among the regressors", name, lag);
    }
    ++at;
  };
  const PolynomialModel::Common c = model.common();
  for (int lag = 1; lag < c.denominator.size(); ++lag) add(true, output, lag);
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    for (int lag = 0; lag < c.numerators[i].size(); ++lag) add(false, inputs[i], lag);
  }
  return list;
}

MatrixXd rows_of(const std::vector<Observation>& observations, int inputs) {
  MatrixXd rows(static_cast<Index>(observations.size()), inputs + 2);
  for (Index i = 0; i < rows.rows(); ++i) {
    const Observation& o = observations[static_cast<std::size_t>(i)];
    if (o.x.size() != inputs) fail("an observation has {} inputs, the model {}", o.x.size(), inputs);
    if (o.slope_of < 0 || o.slope_of > inputs)
      fail("an observation is of the slope by input {}; there are inputs 1 to {}, and 0 for the value", o.slope_of,
           inputs);
    if (!(o.noise >= 0) || !std::isfinite(o.noise))
      fail("the noise variance of an observation is {:g}; it must be 0 or greater", o.noise);
    rows.row(i) << o.x.transpose(), o.slope_of, o.noise;
  }
  return rows;
}

}  // namespace plantloop::identify
