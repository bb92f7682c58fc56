// Uncertain inputs: naive, first order, moment matching.

#include "identify/gp/propagate.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "identify/dense/dense.h"
#include "identify/error.h"
#include "identify/gp/pivoted_root.h"

namespace plantloop::identify {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

std::vector<GaussianTerm> terms_of(const GpPosterior& model) {
  if (model.x().cols() > model.inputs())
    fail("moment matching is for observed values, this model has observed slopes too; first_order works with both");
  std::vector<GaussianTerm> terms;
  const bool known = model.covariance().terms(model.hyperparameters().theta, model.inputs(), terms);
  const auto is_long = [](const GaussianTerm& term) { return term.factors.size() > most_factors; };
  if (!known || std::any_of(terms.begin(), terms.end(), is_long))
    fail(
        "moment matching has a closed form for sums and products of se_ard and linear, at most two linear in a "
        "product, not for '{}'; first_order works with every covariance",
        model.covariance().name());
  return terms;
}

// The part of the mean function that is linear in x.
VectorXd own_slope(const GpPosterior& model) {
  const VectorXd& b = model.mean_coefficients();
  return b.size() > 1 ? VectorXd(b.tail(b.size() - 1)) : VectorXd::Zero(model.inputs());
}

template <typename Models, typename Address>
std::vector<const GpPosterior*> pointers_to(const Models& models, Address address) {
  std::vector<const GpPosterior*> pointers;
  for (const auto& model : models) pointers.push_back(address(model));
  return pointers;
}

}  // namespace

void check_point(const UncertainPoint& point, int inputs) {
  const MatrixXd& S = point.covariance;
  if (point.mean.size() != inputs) fail("the point has {} inputs, the model {}", point.mean.size(), inputs);
  if (S.rows() != inputs || S.cols() != inputs)
    fail("the covariance of the point is {} x {}; the model has {} inputs, so it is {} x {}", S.rows(), S.cols(),
         inputs, inputs, inputs);
  if (!point.mean.allFinite() || !S.allFinite()) fail("the point has numbers that are not finite");
  const double size = S.cwiseAbs().maxCoeff();
  for (Index i = 0; i < S.rows(); ++i) {
    for (Index j = 0; j < i; ++j) {
      if (std::fabs(S(i, j) - S(j, i)) > 1e-12 * size)
        fail("the covariance of the point is not symmetric: its element {}, {} is {:g}, {}, {} is {:g}", i + 1, j + 1,
             S(i, j), j + 1, i + 1, S(j, i));
    }
  }
  const double least = Eigen::SelfAdjointEigenSolver<MatrixXd>(S, Eigen::EigenvaluesOnly).eigenvalues().minCoeff();
  if (least < -1e-12 * size) fail("the covariance of the point has the eigenvalue {:g}; no variance is below 0", least);
}

Propagation find_propagation(const std::string& name) {
  if (name == "naive") return Propagation::naive;
  if (name == "first_order") return Propagation::first_order;
  if (name == "moment_matching") return Propagation::moment_matching;
  fail("there is no propagation '{}'; there are naive, first_order, moment_matching", name);
}

Propagator::Propagator(const std::vector<std::shared_ptr<const GpPosterior>>& models, Propagation method)
    : Propagator(pointers_to(models, [](const auto& model) { return model.get(); }), method) {}

Propagator::Propagator(const std::vector<GaussianProcess>& models, Propagation method)
    : Propagator(pointers_to(models, [](const auto& model) { return &model; }), method) {}

Propagator::Propagator(std::vector<const GpPosterior*> models, Propagation method)
    : models_(std::move(models)), method_(method) {
  if (method != Propagation::moment_matching) return;
  Index points = 0;
  bool any_sparse = false;
  for (const GpPosterior* model : models_) {
    terms_.push_back(terms_of(*model));
    first_.push_back(points);
    points += model->x().rows();
    any_sparse = any_sparse || model->is_sparse();
  }
  first_.push_back(points);
  constexpr int most_directions = 8;
  const Index most_columns = points <= 200 ? 126 : 56;
  for (int r = 1; r <= std::min(most_directions, models_.front()->inputs()); ++r)
    indices_.emplace_back(r, most_columns);
  // Columns cost as much as the matrix itself where there are some hundred points: then some must do. Inducing inputs
  // are few, and their beta is too large for what is left.
  const auto size = static_cast<double>(points);
  rank_ = any_sparse ? points : std::min<Index>(points, std::max<Index>(32, static_cast<Index>(4e6 / size / size)));
  if (rank_ == points) return;
  for (const GpPosterior* model : models_)
    spread_.emplace_back(model->alpha() * model->alpha().transpose() - model->precision());
}

UncertainPrediction Propagator::predict(const UncertainPoint& point) const {
  if (method_ == Propagation::moment_matching) return moment_matching(point);
  return first_order(point);
}

UncertainPrediction Propagator::first_order(const UncertainPoint& point) const {
  const auto count = static_cast<Index>(models_.size());
  UncertainPrediction result{VectorXd(count), MatrixXd::Zero(count, count), MatrixXd::Zero(count, point.mean.size())};
  for (Index a = 0; a < count; ++a) {
    const GpPosterior& model = *models_[static_cast<std::size_t>(a)];
    const Prediction at = model.predict(point.mean.transpose());
    result.mean[a] = at.mean[0];
    result.covariance(a, a) = at.variance[0];
    if (method_ != Propagation::naive) result.slope.row(a) = model.mean_gradient(point.mean).transpose();
  }
  result.covariance += result.slope * point.covariance * result.slope.transpose();
  mirror_lower(result.covariance);
  return result;
}

UncertainPrediction Propagator::moment_matching(const UncertainPoint& point) const {
  const std::size_t count = models_.size();
  const auto outputs = static_cast<Index>(count);
  std::vector<KernelMoments> moments;
  for (std::size_t a = 0; a < count; ++a) moments.emplace_back(terms_[a], models_[a]->x(), point);
  bool finished = true;
  MatrixXd G = series(moments, finished);
  const Index of_series = G.cols();
  std::vector<std::vector<KernelPairs>> pairs(count);
  if (!finished) {
    VectorXd diagonal(first_.back()), enough(first_.back());
    for (std::size_t a = 0; a < count; ++a) {
      for (std::size_t b = 0; b < count; ++b) pairs[a].emplace_back(moments[a], moments[b]);
      const VectorXd own = pairs[a][a].diagonal().cwiseMax(0.0);
      diagonal.segment(first_[a], own.size()) = own;
      // Below this is rounding, which K^-1 would make large.
      enough.segment(first_[a], own.size()).setConstant(2e-15 * own.maxCoeff());
    }
    const auto column = [&](Index j) {
      std::size_t b = 0;
      while (first_[b + 1] <= j) ++b;
      VectorXd all(first_.back());
      for (std::size_t a = 0; a < count; ++a)
        all.segment(first_[a], models_[a]->x().rows()) = pairs[a][b].column(j - first_[b]);
      return all;
    };
    const VectorXd left = diagonal - G.rowwise().squaredNorm();
    G = pivoted_root(std::move(G), left, enough, rank_, column, finished);
  }

  UncertainPrediction result{VectorXd(outputs), MatrixXd(outputs, outputs), MatrixXd(outputs, point.mean.size())};
  MatrixXd mixed(G.cols(), outputs);  // (L^-1 G)'(L^-1 y) of each model
  VectorXd certain(outputs);          // the variance's part that no x makes
  MatrixXd own(outputs, point.mean.size());
  for (Index o = 0; o < outputs; ++o) {
    const auto a = static_cast<std::size_t>(o);
    const GpPosterior& model = *models_[a];
    VectorXd q = moments[a].q;
    solve_lower(model.factor(), q);
    // Of the last columns of the series P makes less than the rounding of k.
    MatrixXd H = G.middleRows(first_[a], model.x().rows());
    Index known = G.cols();
    const double little = 1e-17 * model.hyperparameters().v0 * moments[a].k;
    if (!model.is_sparse() && known == of_series) {
      while (known > 0 && H.col(known - 1).squaredNorm() < little) --known;
    }
    mixed.col(o).tail(G.cols() - known) = H.rightCols(G.cols() - known).transpose() * model.alpha();
    H.conservativeResize(Eigen::NoChange, known);
    solve_lower(model.factor(), H);
    mixed.col(o).head(known) = H.transpose() * model.whitened();
    result.mean[o] = model.whitened().dot(q);
    result.slope.row(o) = model.weighted(moments[a].g).transpose();
    certain[o] = moments[a].k - model.known(q) - model.known(H);
    own.row(o) = own_slope(model).transpose();
    if (model.mean_coefficients().size() > 0) result.mean[o] += model.mean_coefficients()[0];
  }
  result.covariance = mixed.transpose() * mixed;
  result.covariance.diagonal() += certain;
  if (!finished && !spread_.empty()) add_rest(pairs, G, result.covariance);
  // The mean functions are affine in x and add their own part, and their products with the rest.
  const MatrixXd with_own = own * point.covariance * result.slope.transpose();
  result.covariance += with_own + with_own.transpose() + own * point.covariance * own.transpose();
  result.mean += own * point.mean;
  result.slope += own;
  mirror_lower(result.covariance);
  for (Index o = 0; o < outputs; ++o) result.covariance(o, o) = std::max(result.covariance(o, o), 0.0);
  return result;
}

MatrixXd Propagator::series(const std::vector<KernelMoments>& moments, bool& converged) const {
  const auto r = static_cast<std::size_t>(moments.front().root.cols());
  MatrixXd G(first_.back(), 0);
  converged = r == 0;
  if (converged || r > indices_.size()) return G;
  const MultiIndices& indices = indices_[r - 1];
  std::vector<HermiteSeries> all;
  for (const KernelMoments& its : moments) all.emplace_back(its, indices);
  std::vector<double> greatest(moments.size(), 0.0);
  G.resize(first_.back(), indices.end(indices.degrees()) - 1);
  Index columns = 0;
  // Twice, since even or odd degrees may be 0.
  int small = 0;
  for (int degree = 1; degree <= indices.degrees() && small < 2; ++degree) {
    bool is_small = true;
    const Index more = indices.end(degree) - indices.begin(degree);
    for (std::size_t a = 0; a < moments.size(); ++a) {
      const MatrixXd c = all[a].next();
      const double now = c.cwiseAbs().maxCoeff();  // not its square, which far points make 0
      greatest[a] = std::max(greatest[a], now);
      is_small = is_small && now <= 3e-17 * greatest[a];
      G.block(first_[a], columns, c.rows(), more) = c;
    }
    columns += more;
    small = is_small ? small + 1 : 0;
  }
  converged = small == 2;
  G.conservativeResize(Eigen::NoChange, columns);
  return G;
}

// What G leaves of C, block by block.
void Propagator::add_rest(const std::vector<std::vector<KernelPairs>>& pairs, const MatrixXd& G,
                          MatrixXd& covariance) const {
  for (std::size_t a = 0; a < models_.size(); ++a) {
    const auto G_a = G.middleRows(first_[a], models_[a]->x().rows());
    for (std::size_t b = 0; b <= a; ++b) {
      const auto G_b = G.middleRows(first_[b], models_[b]->x().rows());
      double sum = 0;
      for (Index j = 0; j < models_[b]->x().rows(); ++j) {
        // Of a symmetric block the lower triangle, twice but for the diagonal.
        const Index from = a == b ? j : 0, rows = G_a.rows() - from;
        const VectorXd rest = pairs[a][b].column(j, from) - G_a.bottomRows(rows) * G_b.row(j).transpose();
        sum += a == b ? 2 * spread_[a].col(j).tail(rows).dot(rest) - spread_[a](j, j) * rest[0]
                      : models_[a]->alpha().dot(rest) * models_[b]->alpha()[j];
      }
      const auto i = static_cast<Index>(a), k = static_cast<Index>(b);
      covariance(i, k) += sum;
      if (i != k) covariance(k, i) += sum;
    }
  }
}

}  // namespace plantloop::identify
