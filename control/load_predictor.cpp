// Which predictor fits a file, and the last ones kept.

#include "control/load_predictor.h"

#include <fmt/format.h>

#include <algorithm>
#include <deque>
#include <mutex>
#include <optional>
#include <utility>

#include "control/diagram_predictor.h"
#include "engine/base/files.h"
#include "identify/narx/load.h"
#include "learned/linear_predictor.h"
#include "learned/narx_predictor.h"

namespace plantloop {
namespace {

// The last ones, each with what it was made of.
template <typename Key>
class Kept {
 public:
  template <typename Matches>
  std::optional<LoadedPredictor> find(const Matches& matches) {
    const std::lock_guard<std::mutex> lock(mutex_);
    for (const auto& [key, loaded] : entries_) {
      if (matches(key, loaded)) return loaded;
    }
    return std::nullopt;
  }
  void keep(Key key, const LoadedPredictor& loaded) {
    const std::lock_guard<std::mutex> lock(mutex_);
    entries_.emplace_back(std::move(key), loaded);
    if (entries_.size() > 16) entries_.pop_front();
  }

 private:
  std::mutex mutex_;
  std::deque<std::pair<Key, LoadedPredictor>> entries_;
};

LoadedPredictor of_model(const std::string& path) {
  static Kept<std::shared_ptr<const identify::LoadedModel>> kept;
  const auto model = identify::load_model(path);
  if (const auto found = kept.find([&](const auto& of, const auto&) { return of == model; })) return *found;
  LoadedPredictor loaded;
  loaded.error = !model->error.empty() ? model->error
                 : model->neural       ? fmt::format(
                                             "'{}' holds a neural state-space model; make a diagram with the block "
                                                   "neural_state_space the model, and say which signals are its input "
                                                   "and output",
                                             path)
                 : model->linear ? why_no_predictor(*model->linear)
                                 : why_no_predictor(*model);
  if (!loaded.error.empty()) return loaded;
  if (model->linear) {
    loaded.predictor = std::make_shared<LinearPredictor>(model->linear, true);
    loaded.Ts = model->linear->Ts;
  } else {
    loaded.predictor = std::make_shared<NarxPredictor>(model, model->map->has_variance());
    loaded.Ts = model->narx.channels.Ts;
  }
  kept.keep(model, loaded);
  return loaded;
}

bool is_unchanged(const DiagramPredictor& predictor) {
  return std::all_of(predictor.sources().begin(), predictor.sources().end(), [](const auto& source) {
    const FileResult now = read_file(source.first);
    return now.ok() && now.value == source.second;
  });
}

// The diagrams that are being made on this thread: a controller in the model of a controller makes another one.
thread_local std::vector<std::string> in_making;

LoadedPredictor of_diagram(const ModelUse& use) {
  static Kept<ModelUse> kept;
  const auto same = [&](const ModelUse& of, const LoadedPredictor& loaded) {
    return of == use && is_unchanged(static_cast<const DiagramPredictor&>(*loaded.predictor));
  };
  if (const auto found = kept.find(same)) return *found;
  LoadedPredictor loaded;
  loaded.is_diagram = true;
  if (use.inputs.empty() || use.outputs.empty()) {
    loaded.error = fmt::format("'{}' is a diagram: say which of its signals are input and output", use.path);
  } else if (std::find(in_making.begin(), in_making.end(), use.path) != in_making.end()) {
    loaded.error = fmt::format("the diagram '{}' is its own model", use.path);
  } else {
    in_making.push_back(use.path);
    const auto predictor = DiagramPredictor::make(
        {.path = use.path, .inputs = use.inputs, .outputs = use.outputs, .substeps = use.substeps, .Ts = use.Ts},
        loaded.error);
    in_making.pop_back();
    loaded.predictor = predictor;
    if (predictor) loaded.Ts = predictor->own_period();
    if (predictor) kept.keep(use, loaded);
  }
  return loaded;
}

// A diagram says so in a line of its own.
bool is_diagram(const std::string& path) {
  const FileResult file = read_file(path);
  return file.ok() && (file.value.rfind("plantloop:", 0) == 0 || file.value.find("\nplantloop:") != std::string::npos);
}

}  // namespace

LoadedPredictor load_predictor(const ModelUse& use) {
  return is_diagram(use.path) ? of_diagram(use) : of_model(use.path);
}

}  // namespace plantloop
