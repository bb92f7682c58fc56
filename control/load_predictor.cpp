// Which predictor fits a model, and the last ones kept.

#include "control/load_predictor.h"

#include <deque>
#include <mutex>
#include <utility>

#include "identify/narx/load.h"
#include "learned/linear_predictor.h"
#include "learned/narx_predictor.h"

namespace plantloop {
namespace {

LoadedPredictor of_model(const std::shared_ptr<const identify::LoadedModel>& model) {
  LoadedPredictor loaded;
  loaded.error = !model->error.empty() ? model->error
                 : model->linear       ? why_no_predictor(*model->linear)
                                       : why_no_predictor(*model);
  if (!loaded.error.empty()) return loaded;
  if (model->linear) {
    loaded.predictor = std::make_shared<LinearPredictor>(model->linear, true);
    loaded.Ts = model->linear->Ts;
  } else {
    loaded.predictor = std::make_shared<NarxPredictor>(model, model->map->has_variance());
    loaded.Ts = model->narx.channels.Ts;
  }
  return loaded;
}

}  // namespace

LoadedPredictor load_predictor(const std::string& path) {
  static std::mutex mutex;
  static std::deque<std::pair<std::shared_ptr<const identify::LoadedModel>, LoadedPredictor>> kept;
  const auto model = identify::load_model(path);
  const std::lock_guard<std::mutex> lock(mutex);
  for (const auto& [of, loaded] : kept) {
    if (of == model) return loaded;
  }
  LoadedPredictor loaded = of_model(model);
  if (!model->error.empty()) return loaded;  // not kept by load_model either
  kept.emplace_back(model, loaded);
  if (kept.size() > 16) kept.pop_front();
  return loaded;
}

}  // namespace plantloop
