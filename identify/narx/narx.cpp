// Prediction and free run of a learned map, and its file.

#include "identify/narx/narx.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "identify/data/matching.h"
#include "identify/data/undetermined.h"
#include "identify/error.h"
#include "identify/model_file/model_file.h"
#include "identify/narx/noise_prediction.h"

namespace plantloop::identify {

using Eigen::VectorXd;

namespace {

Predictor predictor(const NarxModel& model, const DataSet& data) {
  check_data(model, data);
  return [map = model.map, scratch = std::vector<double>(static_cast<std::size_t>(model.map->scratch_size()))](
             const VectorXd& x) mutable {
    VectorXd y(map->outputs());
    map->evaluate(x.data(), y.data(), scratch.data());
    return y;
  };
}

// A map some of whose inputs are 0 for ever.
class PartlyZero final : public Approximator {
 public:
  PartlyZero(std::shared_ptr<const Approximator> map, std::vector<int> kept)
      : map_(std::move(map)), kept_(std::move(kept)) {}

  std::string type() const override { return map_->type(); }
  int inputs() const override { return static_cast<int>(kept_.size()); }
  int outputs() const override { return map_->outputs(); }
  int scratch_size() const override { return map_->scratch_size() + map_->inputs() * (1 + map_->outputs()); }
  void evaluate(const double* x, double* y, double* scratch) const override {
    map_->evaluate(spread(x, scratch), y, scratch + map_->inputs());
  }
  void derivative(const double* x, double* jacobian, double* scratch) const override {
    const double* const all = spread(x, scratch);
    double* const whole = scratch + map_->inputs();
    map_->derivative(all, whole, whole + map_->inputs() * map_->outputs());
    for (int o = 0; o < map_->outputs(); ++o) {
      for (const int i : kept_) *jacobian++ = whole[o * map_->inputs() + i];
    }
  }
  bool is_affine() const override { return map_->is_affine(); }
  // A part of a model, which is written whole.
  void write(Item& item) const override { map_->write(item); }

 private:
  const double* spread(const double* x, double* all) const {
    std::fill_n(all, map_->inputs(), 0.0);
    for (const int i : kept_) all[i] = *x++;
    return all;
  }
  std::shared_ptr<const Approximator> map_;
  std::vector<int> kept_;
};

void write_noise(const NarxModel& model, Item& item) {
  if (model.noise.empty()) return;
  Item c = Item::list(), d = Item::list();
  for (const VectorXd& each : model.noise.C) c.add(each);
  for (const VectorXd& each : model.noise.D) d.add(each);
  Item noise;
  noise.set("C", std::move(c)).set("D", std::move(d));
  if (model.noise.covariance.size() > 0) noise.set("covariance", model.noise.covariance);
  item.set("noise", std::move(noise));
}

void read_noise(const Item& item, NarxModel& model) {
  const std::string structure = item.has("structure") ? item.text("structure") : structure_name(model);
  model.simulated = structure == "NBJ";
  if (item.has("noise")) {
    const Item& section = item.at("noise");
    section.only({"C", "D", "covariance"});
    for (const auto& [key, list] : {std::pair("C", &model.noise.C), std::pair("D", &model.noise.D)}) {
      for (const Item& each : section.items(key)) {
        const VectorXd polynomial = Item().set(key, each).vector(key);
        if (polynomial.size() == 0 || polynomial[0] != 1 || !polynomial.allFinite())
          section.at(key).wrong("a polynomial of the noise is a list of numbers that begins with 1");
        list->push_back(polynomial);
      }
      if (list->size() != model.regressors.outputs.size())
        section.at(key).wrong(
            fmt::format("there are {} polynomials for {} outputs", list->size(), model.regressors.outputs.size()));
    }
  }
  if (item.has("noise") && item.at("noise").has("covariance")) {
    Eigen::Index count = 0;
    for (const auto* list : {&model.noise.C, &model.noise.D}) {
      for (const VectorXd& polynomial : *list) count += polynomial.size() - 1;
    }
    model.noise.covariance = item.at("noise").matrix("covariance", count, count);
  }
  if (model.simulated && (model.noise.empty() || model.regressors.errors > 0))
    item.at("structure").wrong("NBJ needs 'noise', and has no prediction errors among its regressors");
  if (noise_free(model).regressors.list.empty())
    item.at("regressors").wrong("there must be a regressor that is no prediction error");
  if (structure != structure_name(model))
    item.at("structure").wrong(fmt::format("this model is '{}', not '{}'", structure_name(model), structure));
}

}  // namespace

std::string structure_name(const NarxModel& model) {
  if (model.simulated) return "NBJ";
  if (model.has_noise_model()) return "NARMAX";
  return model.regressors.uses_outputs() ? "NARX" : "NFIR";
}

NarxModel noise_free(const NarxModel& model) {
  NarxModel result = model;
  result.noise = {};
  result.simulated = false;
  RegressorSet& set = result.regressors;
  if (set.errors == 0) return result;
  std::vector<int> kept;
  set.list.clear();
  for (std::size_t i = 0; i < model.regressors.list.size(); ++i) {
    const std::vector<Factor>& factors = model.regressors.list[i].factors;
    if (std::any_of(factors.begin(), factors.end(), [&](const Factor& f) { return model.regressors.is_error(f); }))
      continue;
    kept.push_back(static_cast<int>(i));
    set.list.push_back(model.regressors.list[i]);
  }
  set.inputs.resize(static_cast<std::size_t>(set.data_inputs()));
  set.errors = 0;
  result.map = std::make_shared<PartlyZero>(model.map, std::move(kept));
  return result;
}

NarxModel make_narx(std::shared_ptr<const Approximator> map, RegressorSet regressors, const DataSet& data,
                    FitReport fit) {
  if (map->inputs() != regressors.size())
    fail("the map has {} inputs, but there are {} regressors", map->inputs(), regressors.size());
  if (map->outputs() != static_cast<int>(regressors.outputs.size()))
    fail("the map has {} outputs, but the model {}", map->outputs(), regressors.outputs.size());
  NarxModel model;
  model.map = std::move(map);
  model.regressors = std::move(regressors);
  model.fit = std::move(fit);
  if (!data.experiments.empty()) model.data = data_item(data);
  if (!data.experiments.empty()) {
    for (std::string& warning : undetermined(data)) model.fit.warnings.push_back(std::move(warning));
    model.fit.data = hash(data);
  }
  model.channels.Ts = data.Ts;
  model.channels.inputs = data.inputs;
  model.channels.outputs = data.outputs;
  return model;
}

void check_data(const NarxModel& model, const DataSet& data) {
  check_signals(model.channels.inputs, model.channels.outputs, model.channels.Ts, data);
}

Outputs one_step(const NarxModel& model, const DataSet& data) { return k_step(model, data, 1); }
Outputs k_step(const NarxModel& model, const DataSet& data, int steps) {
  check_data(model, data);
  if (model.has_noise_model()) return predict_with_noise(model, data, steps);
  return k_step(model.regressors, data, predictor(model, data), steps);
}
Outputs free_run(const NarxModel& model, const DataSet& data) {
  if (model.has_noise_model()) return free_run(noise_free(model), data);
  return free_run(model.regressors, data, predictor(model, data));
}

std::string to_yaml(const NarxModel& model) {
  Item item;
  Item data = model.data;
  if (data.keys().empty()) data = channels_item(model.channels.Ts, model.channels.inputs, model.channels.outputs);
  if (model.has_noise_model()) item.set("structure", structure_name(model));
  item.set("data", data).set("regressors", to_text(model.regressors));
  write_noise(model, item);
  model.map->write(item);
  if (!model.fit.method.empty()) item.set("fit", to_item(model.fit));
  return to_yaml(model.map->type(), item);
}

NarxModel read_narx(const Item& item) {
  NarxModel model;
  model.map = read_approximator(item);
  model.data = item.at("data");
  model.channels = channels_of(model.data);
  std::vector<std::string> inputs, outputs;
  for (const Channel& channel : model.channels.inputs) inputs.push_back(channel.name);
  for (const Channel& channel : model.channels.outputs) outputs.push_back(channel.name);
  try {
    model.regressors = parse_regressors(item.text("regressors"), inputs, outputs);
  } catch (const IdentifyError& error) {
    item.at("regressors").wrong(error.what());
  }
  if (model.map->inputs() != model.regressors.size())
    item.at("regressors")
        .wrong(fmt::format("there are {} regressors, but the map has {} inputs", model.regressors.size(),
                           model.map->inputs()));
  if (model.map->outputs() != static_cast<int>(outputs.size()))
    model.data.at("outputs").wrong(
        fmt::format("there are {} outputs, but the map has {}", outputs.size(), model.map->outputs()));
  read_noise(item, model);
  if (!(model.channels.Ts > 0)) model.data.at("Ts").wrong("the sampling time must be greater than 0 s");
  if (item.has("fit")) model.fit = fit_report_of(item.at("fit"));
  return model;
}

}  // namespace plantloop::identify
