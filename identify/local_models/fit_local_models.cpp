// Local models from data: on a grid, and by a tree that grows where the error is.

#include <algorithm>
#include <cmath>
#include <numeric>

#include "identify/error.h"
#include "identify/linear/least_squares.h"
#include "identify/local_models/local_model_network.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

struct Cell {
  VectorXd lower, upper;
};

class Fitting {
 public:
  Fitting(const MatrixXd& X, const MatrixXd& Y, const LocalModelOptions& options) : y_(Y), options_(options) {
    if (X.rows() == 0 || X.cols() == 0 || Y.cols() == 0) fail("the data has no rows or no columns");
    if (X.rows() != Y.rows()) fail("the inputs have {} rows and the targets {}; they must agree", X.rows(), Y.rows());
    if (!X.allFinite() || !Y.allFinite()) fail("the data has numbers that are not finite; leave such rows out");
    if (!(options.width > 0)) fail("the width of the weights is {:g} cells; it must be greater than 0", options.width);
    x_.resize(X.rows(), X.cols() + 1);
    x_ << X, VectorXd::Ones(X.rows());
    per_size_ = x_.colwise().stableNorm().transpose() / std::sqrt(static_cast<double>(X.rows()));
    for (double& size : per_size_) size = size > 0 ? 1 / size : 1;
    scheduling_ = options.scheduling;
    if (scheduling_.empty()) {
      scheduling_.resize(static_cast<std::size_t>(X.cols()));
      std::iota(scheduling_.begin(), scheduling_.end(), 0);
    }
    for (const int variable : scheduling_) {
      if (variable < 0 || variable >= X.cols())
        fail("scheduling variable {} is none of the {} regressors", variable + 1, X.cols());
    }
    s_ = X(Eigen::all, scheduling_);
  }

  Cell box() const {
    const auto n = static_cast<Index>(scheduling_.size());
    Cell box{s_.colwise().minCoeff(), s_.colwise().maxCoeff()};
    if (options_.lower.size() > 0) box.lower = options_.lower;
    if (options_.upper.size() > 0) box.upper = options_.upper;
    if (box.lower.size() != n || box.upper.size() != n)
      fail("the box has {} and {} limits, but there are {} scheduling variables", box.lower.size(), box.upper.size(),
           n);
    for (Index i = 0; i < n; ++i) {
      if (!(box.upper[i] > box.lower[i]))
        fail("scheduling variable {} does not vary: from {:g} to {:g}", scheduling_[static_cast<std::size_t>(i)] + 1,
             box.lower[i], box.upper[i]);
    }
    return box;
  }
  Index axes() const { return s_.cols(); }

  std::vector<LocalModel> place(const std::vector<Cell>& cells) const {
    std::vector<LocalModel> models;
    for (const Cell& cell : cells)
      models.push_back({(cell.lower + cell.upper) / 2, options_.width * (cell.upper - cell.lower), {}});
    return models;
  }

  // N x models.
  MatrixXd memberships(const std::vector<LocalModel>& models) const {
    MatrixXd mu(s_.rows(), static_cast<Index>(models.size()));
    for (Index i = 0; i < mu.cols(); ++i) {
      const LocalModel& model = models[static_cast<std::size_t>(i)];
      mu.col(i) =
          -0.5 *
          ((s_.rowwise() - model.centre.transpose()) * model.width.cwiseInverse().asDiagonal()).rowwise().squaredNorm();
    }
    const VectorXd greatest = mu.rowwise().maxCoeff();
    mu = (mu.colwise() - greatest).array().exp().matrix();
    const VectorXd sums = mu.rowwise().sum();
    return sums.cwiseInverse().asDiagonal() * mu;
  }

  // Weighted least squares of one model.
  void estimate_local(LocalModel& model, const VectorXd& mu, std::vector<std::string>* warnings = nullptr) const {
    const VectorXd root = mu.cwiseSqrt();
    const MatrixXd rows = root.asDiagonal() * x_ * per_size_.asDiagonal();
    model.parameters.resize(y_.cols(), x_.cols());
    for (Index o = 0; o < y_.cols(); ++o) {
      const LeastSquares found = least_squares(rows, root.cwiseProduct(y_.col(o)), {.ridge = options_.ridge});
      model.parameters.row(o) = found.theta.cwiseProduct(per_size_).transpose();
      if (warnings != nullptr && o == 0)
        warnings->insert(warnings->end(), found.warnings.begin(), found.warnings.end());
    }
  }
  void estimate_global(std::vector<LocalModel>& models, const MatrixXd& mu, std::vector<std::string>& warnings) const {
    const Index d = x_.cols();
    if (d * mu.cols() > 3000)
      fail(
          "{} local models have {} parameters, which global estimation solves for at once; it takes at most 3000: "
          "fewer "
          "models, or estimation = \"local\"",
          mu.cols(), d * mu.cols());
    MatrixXd rows(x_.rows(), d * mu.cols());
    for (Index i = 0; i < mu.cols(); ++i)
      rows.middleCols(i * d, d) = mu.col(i).asDiagonal() * x_ * per_size_.asDiagonal();
    for (LocalModel& model : models) model.parameters.resize(y_.cols(), d);
    for (Index o = 0; o < y_.cols(); ++o) {
      const LeastSquares found = least_squares(rows, y_.col(o), {.ridge = options_.ridge});
      for (Index i = 0; i < mu.cols(); ++i)
        models[static_cast<std::size_t>(i)].parameters.row(o) =
            found.theta.segment(i * d, d).cwiseProduct(per_size_).transpose();
      if (o == 0) warnings.insert(warnings.end(), found.warnings.begin(), found.warnings.end());
    }
  }
  MatrixXd errors(const std::vector<LocalModel>& models, const MatrixXd& mu) const {
    MatrixXd e = y_;
    for (Index i = 0; i < mu.cols(); ++i)
      e.noalias() -= mu.col(i).asDiagonal() * (x_ * models[static_cast<std::size_t>(i)].parameters.transpose());
    return e;
  }

  LocalModelFit finish(std::vector<LocalModel> models, FitReport report) const {
    const MatrixXd mu = memberships(models);
    if (options_.estimation == LocalEstimation::global) {
      estimate_global(models, mu, report.warnings);
    } else {
      for (std::size_t i = 0; i < models.size(); ++i) estimate_local(models[i], mu.col(static_cast<Index>(i)));
    }
    int starved = 0;
    for (Index i = 0; i < mu.cols(); ++i) starved += mu.col(i).sum() < static_cast<double>(x_.cols()) ? 1 : 0;
    if (starved > 0)
      report.warnings.push_back(
          fmt::format("{} of {} local models see fewer samples than they have parameters.", starved, models.size()));
    report.method +=
        options_.estimation == LocalEstimation::global ? ", global least squares" : ", local least squares";
    report.samples = x_.rows();
    report.parameters = static_cast<long long>(models.size()) * x_.cols() * y_.cols();
    report.measure = "mean square of the error";
    const LocalModelOptions usual;
    if (options_.width != usual.width) report.options.push_back(fmt::format("width {:g}", options_.width));
    if (options_.ridge != usual.ridge) report.options.push_back(fmt::format("ridge {:g}", options_.ridge));
    if (!options_.scheduling.empty()) {
      std::vector<int> numbers = options_.scheduling;
      for (int& number : numbers) ++number;
      report.options.push_back(fmt::format("scheduling {}", fmt::join(numbers, " ")));
    }
    report.reached = errors(models, mu).squaredNorm() / static_cast<double>(y_.size());
    return {std::make_shared<LocalModelNetwork>(scheduling_, std::move(models)), std::move(report), {}};
  }

 private:
  MatrixXd x_, y_, s_;  // [X, 1], targets, scheduling variables
  VectorXd per_size_;   // 1/root mean square of the columns of x_: the ridge is relative to them
  const LocalModelOptions& options_;
  std::vector<int> scheduling_;
};

}  // namespace

LocalModelFit fit_local_grid(const MatrixXd& X, const MatrixXd& Y, int cells, const LocalModelOptions& options,
                             const FitControl& control) {
  const Fitting fitting(X, Y, options);
  if (cells < 1) fail("the number of cells is {}; it must be 1 or more", cells);
  const double count = std::pow(cells, static_cast<double>(fitting.axes()));
  if (count > 10000)
    fail(
        "{} cells along each of {} scheduling variables are {:g} local models, more than 10000; schedule by fewer "
        "variables or use a tree",
        cells, fitting.axes(), count);
  const Cell box = fitting.box();
  const VectorXd side = (box.upper - box.lower) / cells;
  std::vector<Cell> grid;
  for (int number = 0; number < static_cast<int>(count); ++number) {
    VectorXd lower = box.lower;
    int rest = number;
    for (Index axis = 0; axis < side.size(); ++axis) {
      lower[axis] += (rest % cells) * side[axis];
      rest /= cells;
    }
    grid.push_back({lower, lower + side});
  }
  control.step(0);
  FitReport report;
  report.method = "grid of local models";
  report.stopped = fmt::format("{} cells along each axis were asked for", cells);
  report.tried.push_back(fmt::format("a grid of {} local models", grid.size()));
  return fitting.finish(fitting.place(grid), std::move(report));
}

LocalModelFit fit_lolimot(const MatrixXd& X, const MatrixXd& Y, int models, const LocalModelOptions& options,
                          const FitControl& control) {
  const Fitting fitting(X, Y, options);
  if (models < 1) fail("the number of local models is {}; it must be 1 or more", models);
  // A tree of more models would have some that see fewer rows than they have parameters.
  const Index most = std::max<Index>(1, X.rows() / (X.cols() + 1));
  const bool too_many = models > most;
  if (too_many) models = static_cast<int>(most);
  std::vector<Cell> cells{fitting.box()};
  std::vector<LocalModel> tree = fitting.place(cells);
  MatrixXd mu = fitting.memberships(tree);
  fitting.estimate_local(tree[0], mu.col(0));
  MatrixXd e = fitting.errors(tree, mu);
  FitReport report;
  report.method = "local linear model tree";
  report.stopped = fmt::format("{} local models were asked for", models);
  if (too_many) {
    report.stopped = fmt::format("{} rows have no more than {} models of {} parameters", X.rows(), most, X.cols() + 1);
    report.warnings.push_back(
        fmt::format("More local models were asked for than {} rows can have: {} of {} parameters each.", X.rows(), most,
                    X.cols() + 1));
  }
  std::vector<double> history;
  const auto note = [&] {
    history.push_back(std::sqrt(e.squaredNorm() / static_cast<double>(e.size())));
    report.tried.push_back(fmt::format("{} models: error {:.6g} (root mean square)", tree.size(), history.back()));
  };
  note();
  while (static_cast<int>(tree.size()) < models) {
    control.step(static_cast<double>(tree.size()) / models);
    // The worst cells first.
    const VectorXd losses = mu.transpose() * e.rowwise().squaredNorm();
    std::vector<Index> order(tree.size());
    std::iota(order.begin(), order.end(), Index{0});
    std::stable_sort(order.begin(), order.end(), [&](Index a, Index b) { return losses[a] > losses[b]; });
    double best = e.squaredNorm();
    std::vector<LocalModel> best_tree;
    std::vector<Cell> best_cells;
    for (const Index worst : order) {
      for (Index axis = 0; axis < fitting.axes(); ++axis) {
        control.look();
        std::vector<Cell> cut = cells;
        Cell& low = cut[static_cast<std::size_t>(worst)];
        Cell high = low;
        const double middle = (low.lower[axis] + low.upper[axis]) / 2;
        low.upper[axis] = high.lower[axis] = middle;
        cut.push_back(high);
        std::vector<LocalModel> grown = tree;
        const std::vector<LocalModel> placed = fitting.place(cut);
        grown[static_cast<std::size_t>(worst)] = placed[static_cast<std::size_t>(worst)];
        grown.push_back(placed.back());
        const MatrixXd trial = fitting.memberships(grown);
        fitting.estimate_local(grown[static_cast<std::size_t>(worst)], trial.col(worst));
        fitting.estimate_local(grown.back(), trial.col(trial.cols() - 1));
        const double sse = fitting.errors(grown, trial).squaredNorm();
        if (sse < best) best = sse, best_tree = std::move(grown), best_cells = std::move(cut);
      }
      if (!best_tree.empty()) break;
    }
    if (best_tree.empty()) {
      report.stopped = "no cut of any cell makes the error smaller";
      break;
    }
    tree = std::move(best_tree);
    cells = std::move(best_cells);
    mu = fitting.memberships(tree);
    e = fitting.errors(tree, mu);
    note();
  }
  report.iterations = static_cast<long long>(tree.size()) - 1;
  LocalModelFit fit = fitting.finish(std::move(tree), std::move(report));
  fit.errors = std::move(history);
  return fit;
}

}  // namespace plantloop::identify
