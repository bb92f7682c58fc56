// Removing weights, retraining, and keeping the best size.

#include "identify/mlp/prune.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "identify/error.h"
#include "identify/fit/training.h"
#include "identify/mlp/problems.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Set = std::vector<Index>;

// Where each weight stands in theta.
class Places {
 public:
  explicit Places(const Network& network) : network_(network) {
    Index at = 0;
    first_.resize(network.layers.size());
    for (std::size_t l = network.layers.size(); l-- > 0;) {
      first_[l] = at;
      at += network.layers[l].w.size();
    }
  }
  Index of(std::size_t layer, Index neuron, Index input) const {
    return first_[layer] + neuron * network_.layers[layer].w.cols() + input;
  }
  // All weights of a hidden neuron: incoming, bias, outgoing.
  Set around(std::size_t layer, Index neuron) const {
    Set set = incoming(layer, neuron);
    set.push_back(of(layer, neuron, network_.layers[layer].inputs()));
    for (const Index out : outgoing(layer, neuron)) set.push_back(out);
    return set;
  }
  Set incoming(std::size_t layer, Index neuron) const {
    Set set;
    for (Index k = 0; k < network_.layers[layer].inputs(); ++k) set.push_back(of(layer, neuron, k));
    return set;
  }
  Set outgoing(std::size_t layer, Index neuron) const {
    Set set;
    const Layer& above = network_.layers[layer + 1];
    for (Index i = 0; i < above.neurons(); ++i) set.push_back(of(layer + 1, i, neuron));
    return set;
  }

 private:
  const Network& network_;
  std::vector<Index> first_;
};

class Surgeon {
 public:
  Surgeon(const Mlp& model, const MatrixXd& X, const MatrixXd& Y, const PruneOptions& options)
      : network_(model.network()),
        places_(network_),
        training_(network_, model.x_scaling().normalised(X), model.y_scaling().normalised(Y)),
        options_(options),
        theta_(network_.theta()) {}

  const VectorXd& theta() const { return theta_; }
  int weights() const { return static_cast<int>((theta_.array() != 0).count()); }

  PruneStep step(const Training* test) {
    MatrixXd r;
    VectorXd g;
    PruneStep step;
    step.weights = weights();
    step.sse = training_.normal(theta_, r, g);
    step.theta = theta_;
    if (test != nullptr) step.test_sse = test->sse(theta_);
    step.fpe = step.sse / (2 * static_cast<double>(training_.targets()));
    const Set kept = alive();
    if (kept.empty()) return step;
    step.fpe =
        final_prediction_error(r(kept, kept), VectorXd::Constant(static_cast<Index>(kept.size()), options_.decay),
                               step.sse, static_cast<double>(training_.targets()));
    return step;
  }

  // Takes the least important weight or neuron out; false: nothing can be removed.
  bool remove() {
    MatrixXd r;
    VectorXd g;
    training_.normal(theta_, r, g);
    const Set kept = alive();
    if (kept.empty() || static_cast<int>(kept.size()) <= options_.least) return false;
    const auto n = static_cast<Index>(kept.size());
    const MatrixXd rk = r(kept, kept);
    MatrixXd h = rk;
    // A tiny share of the unit matrix where the weights are not determined.
    h.diagonal().array() += options_.decay + 1e-10 * rk.diagonal().maxCoeff();
    const MatrixXd inverse = Eigen::LDLT<MatrixXd>(h).solve(MatrixXd::Identity(n, n));
    const VectorXd theta = theta_(kept);
    const VectorXd pull = inverse * (options_.decay * theta);
    const VectorXd sharpness = ((inverse * rk).array() * inverse.array()).rowwise().sum();
    std::vector<Index> place(static_cast<std::size_t>(theta_.size()), -1);
    for (Index i = 0; i < n; ++i) place[static_cast<std::size_t>(kept[static_cast<std::size_t>(i)])] = i;

    double least = std::numeric_limits<double>::infinity();
    Set chosen;
    for (Index i = 0; i < n; ++i) {
      if (belongs_to_a_neuron(kept[static_cast<std::size_t>(i)])) continue;
      const double c = theta[i] / inverse(i, i);
      const double saliency = c * pull[i] + c * c * sharpness[i] / 2;
      if (saliency < least) least = saliency, chosen = {i};
    }
    for (const Set& neuron : thin_neurons()) {
      Set set;
      for (const Index j : neuron) {
        if (place[static_cast<std::size_t>(j)] >= 0) set.push_back(place[static_cast<std::size_t>(j)]);
      }
      if (set.empty()) continue;
      const VectorXd own = theta(set);
      const double saliency = 0.5 * own.dot(Eigen::LDLT<MatrixXd>(inverse(set, set)).solve(own));
      if (saliency < least) least = saliency, chosen = set;
    }
    if (chosen.empty()) return false;
    const VectorXd own = theta(chosen);
    const VectorXd change = -inverse(Eigen::all, chosen) * Eigen::LDLT<MatrixXd>(inverse(chosen, chosen)).solve(own);
    VectorXd moved = theta + change;
    for (const Index i : chosen) moved[i] = 0;
    for (Index i = 0; i < n; ++i) theta_[kept[static_cast<std::size_t>(i)]] = moved[i];
    return true;
  }

  void retrain(Watch& watch) {
    TrainingOptions how;
    how.iterations = options_.iterations;
    how.decay = options_.decay;
    how.fixed.assign(static_cast<std::size_t>(theta_.size()), false);
    for (Index i = 0; i < theta_.size(); ++i) how.fixed[static_cast<std::size_t>(i)] = theta_[i] == 0;
    const TrainingResult result = train(training_, theta_, how, watch);
    watch.skip(options_.iterations - result.iterations);
    if (std::isfinite(result.sse)) theta_ = result.theta;
  }

  Index targets() const { return training_.targets(); }

 private:
  Set alive() const {
    Set set;
    for (Index i = 0; i < theta_.size(); ++i) {
      if (theta_[i] != 0) set.push_back(i);
    }
    return set;
  }
  int count(const Set& set) const {
    return static_cast<int>(std::count_if(set.begin(), set.end(), [&](Index i) { return theta_[i] != 0; }));
  }
  // Neurons with one incoming or one outgoing weight left.
  std::vector<Set> thin_neurons() const {
    std::vector<Set> thin;
    for (std::size_t l = 0; l + 1 < network_.layers.size(); ++l) {
      for (Index i = 0; i < network_.layers[l].neurons(); ++i) {
        if (count(places_.around(l, i)) == 0) continue;
        if (count(places_.incoming(l, i)) <= 1 || count(places_.outgoing(l, i)) <= 1)
          thin.push_back(places_.around(l, i));
      }
    }
    return thin;
  }
  // A last weight goes with its neuron only.
  bool belongs_to_a_neuron(Index weight) const {
    for (std::size_t l = 0; l + 1 < network_.layers.size(); ++l) {
      for (Index i = 0; i < network_.layers[l].neurons(); ++i) {
        for (const Set& set : {places_.incoming(l, i), places_.outgoing(l, i)}) {
          if (count(set) == 1 && std::find(set.begin(), set.end(), weight) != set.end()) return true;
        }
      }
    }
    return false;
  }

  Network network_;
  Places places_;
  StaticTraining training_;
  const PruneOptions& options_;
  VectorXd theta_;
};

}  // namespace

Pruned prune(const Mlp& model, const MatrixXd& X, const MatrixXd& Y, const MatrixXd& X_test, const MatrixXd& Y_test,
             const PruneOptions& options, const FitControl& control) {
  if (X.rows() == 0 || X.rows() != Y.rows() || X.cols() != model.inputs() || Y.cols() != model.outputs())
    fail("the data is {} x {} and {} x {}; the network has {} inputs and {} outputs", X.rows(), X.cols(), Y.rows(),
         Y.cols(), model.inputs(), model.outputs());
  if (!X.allFinite() || !Y.allFinite()) fail("the data has numbers that are not finite; leave such rows out");
  if (!(options.decay >= 0)) fail("the weight decay is {:g}; it must be 0 or greater", options.decay);
  if (options.iterations < 0) fail("the number of iterations is {}; it must be 0 or more", options.iterations);
  if (options.least < 1)
    fail("'least' is the number of weights at which pruning ends, 1 or more; it is {}", options.least);
  Surgeon surgeon(model, X, Y, options);
  std::unique_ptr<StaticTraining> test;
  if (X_test.rows() > 0)
    test = std::make_unique<StaticTraining>(model.network(), model.x_scaling().normalised(X_test),
                                            model.y_scaling().normalised(Y_test));
  Watch watch(control, static_cast<double>(surgeon.weights()) * options.iterations);
  Pruned result;
  result.steps.push_back(surgeon.step(test.get()));
  while (surgeon.remove()) {
    surgeon.retrain(watch);
    result.steps.push_back(surgeon.step(test.get()));
  }
  const auto measure = [&](const PruneStep& step) { return test ? step.test_sse : step.fpe; };
  for (std::size_t i = 1; i < result.steps.size(); ++i) {
    if (measure(result.steps[i]) < measure(result.steps[result.best])) result.best = i;
  }
  const PruneStep& best = result.steps[result.best];
  Network network = model.network();
  network.set_theta(best.theta);
  result.model = std::make_shared<Mlp>(std::move(network), model.x_scaling(), model.y_scaling());
  FitReport& report = result.report;
  report.method = "optimal brain surgeon";
  report.measure = "mean square of the error of the normalised outputs";
  report.samples = X.rows();
  report.parameters = best.weights;
  report.reached = best.sse / static_cast<double>(surgeon.targets());
  report.iterations = static_cast<long long>(result.steps.size()) - 1;
  report.stopped = fmt::format("{} of {} weights have the least {}", best.weights, result.steps.front().weights,
                               test ? "test error" : "final prediction error");
  for (const PruneStep& step : result.steps)
    report.tried.push_back(fmt::format("{} weights: sum of squares {:.6g} in training, {} {:.6g}", step.weights,
                                       step.sse, test ? "sum of squares of the test" : "final prediction error",
                                       measure(step)));
  return result;
}

}  // namespace plantloop::identify
