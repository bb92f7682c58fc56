// Evaluating networks of local models, and their model file.

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "identify/error.h"
#include "identify/local_models/local_model_network.h"

namespace plantloop::identify {

using Eigen::Index;

LocalModelNetwork::LocalModelNetwork(std::vector<int> scheduling, std::vector<LocalModel> models)
    : scheduling_(std::move(scheduling)), models_(std::move(models)) {
  if (models_.empty()) fail("a network of local models needs at least one model");
  const auto s = static_cast<Index>(scheduling_.size());
  for (const LocalModel& model : models_) {
    if (model.centre.size() != s || model.width.size() != s ||
        model.parameters.cols() != models_.front().parameters.cols() ||
        model.parameters.rows() != models_.front().parameters.rows())
      fail("all local models need {} numbers in centre and width, and as many parameters as the first one", s);
    if (!(model.width.array() > 0).all()) fail("widths must be greater than 0");
  }
  for (const int variable : scheduling_) {
    if (variable < 0 || variable >= inputs())
      fail("scheduling variable {} is none of the {} regressors", variable + 1, inputs());
  }
}

void LocalModelNetwork::weights(const double* x, double* mu) const {
  const std::size_t m = models_.size();
  double greatest = -std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < m; ++i) {
    double exponent = 0;
    for (std::size_t j = 0; j < scheduling_.size(); ++j) {
      const auto at = static_cast<Index>(j);
      const double z = (x[scheduling_[j]] - models_[i].centre[at]) / models_[i].width[at];
      exponent -= 0.5 * z * z;
    }
    mu[i] = exponent;
    greatest = std::max(greatest, exponent);
  }
  double sum = 0;
  for (std::size_t i = 0; i < m; ++i) sum += mu[i] = std::exp(mu[i] - greatest);
  for (std::size_t i = 0; i < m; ++i) mu[i] /= sum;
}

void LocalModelNetwork::evaluate(const double* x, double* y, double* scratch) const {
  weights(x, scratch);
  const Index d = inputs();
  for (Index o = 0; o < outputs(); ++o) {
    y[o] = 0;
    for (std::size_t i = 0; i < models_.size(); ++i) {
      const Eigen::MatrixXd& p = models_[i].parameters;
      double local = p(o, d);
      for (Index j = 0; j < d; ++j) local += p(o, j) * x[j];
      y[o] += scratch[i] * local;
    }
  }
}

void LocalModelNetwork::derivative(const double* x, double* jacobian, double* scratch) const {
  weights(x, scratch);
  const Index d = inputs();
  const std::size_t m = models_.size();
  double* local = scratch + m;
  for (Index o = 0; o < outputs(); ++o) {
    double* row = jacobian + o * d;
    std::fill(row, row + d, 0.0);
    double blended = 0;
    for (std::size_t i = 0; i < m; ++i) {
      const Eigen::MatrixXd& p = models_[i].parameters;
      local[i] = p(o, d);
      for (Index j = 0; j < d; ++j) local[i] += p(o, j) * x[j];
      for (Index j = 0; j < d; ++j) row[j] += scratch[i] * p(o, j);
      blended += scratch[i] * local[i];
    }
    // dmu_i/ds = mu_i (g_i - sum_j mu_j g_j) with g_i = -(s - centre_i)/width_i^2.
    for (std::size_t v = 0; v < scheduling_.size(); ++v) {
      const auto at = static_cast<Index>(v);
      for (std::size_t i = 0; i < m; ++i) {
        const double width = models_[i].width[at];
        const double g = -(x[scheduling_[v]] - models_[i].centre[at]) / (width * width);
        row[scheduling_[v]] += scratch[i] * g * (local[i] - blended);
      }
    }
  }
}

void LocalModelNetwork::write(Item& item) const {
  Eigen::VectorXd numbers(static_cast<Index>(scheduling_.size()));
  for (std::size_t i = 0; i < scheduling_.size(); ++i) numbers[static_cast<Index>(i)] = scheduling_[i] + 1;
  item.set("scheduling", numbers);
  Item list = Item::list();
  for (const LocalModel& model : models_)
    list.add(Item().set("centre", model.centre).set("width", model.width).set("parameters", model.parameters));
  item.set("local_models", std::move(list));
}

std::shared_ptr<const Approximator> read_local_model_network(const Item& item) {
  std::vector<int> scheduling;
  for (const double number : item.vector("scheduling")) {
    if (number != std::floor(number) || number < 1 || number > 1e6)
      item.at("scheduling").wrong("scheduling variables are numbers of regressors: 1, 2, ...");
    scheduling.push_back(static_cast<int>(number) - 1);
  }
  std::vector<LocalModel> models;
  for (const Item& entry : item.items("local_models")) {
    entry.only({"centre", "width", "parameters"});
    const auto s = static_cast<Index>(scheduling.size());
    LocalModel model{entry.vector("centre", s), entry.vector("width", s), {}};
    model.parameters = models.empty()
                           ? entry.matrix("parameters")
                           : entry.matrix("parameters", models[0].parameters.rows(), models[0].parameters.cols());
    if (model.parameters.rows() < 1 || model.parameters.cols() < 2)
      entry.at("parameters").wrong("a local model needs a row for each output: the slopes, then the offset");
    if (!(model.width.array() > 0).all() || !model.centre.allFinite() || !model.parameters.allFinite())
      entry.wrong("centres and parameters must be finite and widths greater than 0");
    models.push_back(std::move(model));
  }
  try {
    return std::make_shared<LocalModelNetwork>(std::move(scheduling), std::move(models));
  } catch (const IdentifyError& error) {
    item.at("local_models").wrong(error.what());
  }
}

}  // namespace plantloop::identify
