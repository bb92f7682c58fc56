// Prediction and free run of a learned map, and its file.

#include "identify/narx/narx.h"

#include <utility>
#include <vector>

#include "identify/data/undetermined.h"
#include "identify/error.h"
#include "identify/model_file/model_file.h"

namespace plantloop::identify {

using Eigen::VectorXd;

namespace {

void check_channels(const NarxModel& model, const DataSet& data) {
  if (data.inputs.size() != model.regressors.inputs.size() || data.outputs.size() != model.regressors.outputs.size())
    fail("the model has {} inputs and {} outputs, the data {} and {}", model.regressors.inputs.size(),
         model.regressors.outputs.size(), data.inputs.size(), data.outputs.size());
}

Predictor predictor(const NarxModel& model, const DataSet& data) {
  check_channels(model, data);
  return [map = model.map, scratch = std::vector<double>(static_cast<std::size_t>(model.map->scratch_size()))](
             const VectorXd& x) mutable {
    VectorXd y(map->outputs());
    map->evaluate(x.data(), y.data(), scratch.data());
    return y;
  };
}

}  // namespace

NarxModel make_narx(std::shared_ptr<const Approximator> map, RegressorSet regressors, const DataSet& data,
                    FitReport fit) {
  if (map->inputs() != regressors.size())
    fail("the map has {} inputs, but there are {} regressors", map->inputs(), regressors.size());
  if (map->outputs() != static_cast<int>(regressors.outputs.size()))
    fail("the map has {} outputs, but the model {}", map->outputs(), regressors.outputs.size());
  NarxModel model{
      std::move(map), std::move(regressors), {}, data.experiments.empty() ? Item() : data_item(data), std::move(fit)};
  if (!data.experiments.empty()) {
    for (std::string& warning : undetermined(data)) model.fit.warnings.push_back(std::move(warning));
  }
  model.channels.Ts = data.Ts;
  model.channels.inputs = data.inputs;
  model.channels.outputs = data.outputs;
  return model;
}

Outputs one_step(const NarxModel& model, const DataSet& data) {
  return one_step(model.regressors, data, predictor(model, data));
}
Outputs k_step(const NarxModel& model, const DataSet& data, int steps) {
  return k_step(model.regressors, data, predictor(model, data), steps);
}
Outputs free_run(const NarxModel& model, const DataSet& data) {
  return free_run(model.regressors, data, predictor(model, data));
}

std::string to_yaml(const NarxModel& model) {
  Item item;
  Item data = model.data;
  if (data.keys().empty()) {
    data.set("Ts", model.channels.Ts);
    for (const auto& [key, channels] :
         {std::pair("inputs", &model.channels.inputs), std::pair("outputs", &model.channels.outputs)}) {
      Item list = Item::list();
      for (const Channel& channel : *channels) {
        Item entry = Item().set("name", channel.name);
        if (!channel.unit.empty()) entry.set("unit", channel.unit);
        list.add(entry);
      }
      data.set(key, list);
    }
  }
  item.set("data", data).set("regressors", to_text(model.regressors));
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
  if (!(model.channels.Ts > 0)) model.data.at("Ts").wrong("the sampling time must be greater than 0 s");
  if (item.has("fit")) model.fit = fit_report_of(item.at("fit"));
  return model;
}

}  // namespace plantloop::identify
