// A few model files, kept by path and content.

#include "identify/narx/load.h"

#include <deque>
#include <mutex>
#include <utility>

#include "engine/base/files.h"
#include "identify/error.h"
#include "identify/model_file/model_file.h"
#include "identify/narx/regression_narx.h"

namespace plantloop::identify {
namespace {

struct Kept {
  std::string path, bytes;
  std::shared_ptr<const LoadedModel> model;
};

LoadedModel read(const std::string& path, const std::string& bytes) {
  LoadedModel model;
  try {
    const Item item = read_model_file(bytes, path);
    const std::string type = item.text("type");
    model.dynamic = item.has("regressors");
    if (type == "linear_model") {
      model.linear = std::make_shared<StateSpaceModel>(to_state_space(polynomial_model_of(item)));
    } else if (type == "state_space_model") {
      model.linear = std::make_shared<StateSpaceModel>(state_space_of(item));
    } else if (type == "neural_state_space") {
      model.neural = std::make_shared<NeuralStateSpace>(neural_state_space_of(item));
    } else if (type == "regression_model") {
      model.narx = to_narx(regression_model_of(item));
      model.map = model.narx.map;
    } else if (model.dynamic) {
      model.narx = read_narx(item);
      if (model.narx.has_noise_model()) {
        model.with_noise = std::make_shared<NarxModel>(model.narx);
        model.narx = noise_free(model.narx);
      }
      model.map = model.narx.map;
    } else {
      model.map = read_approximator(item);
    }
  } catch (const IdentifyError& error) {
    model = {};
    model.error = error.what();
  }
  return model;
}

}  // namespace

std::shared_ptr<const LoadedModel> load_model(const std::string& path) {
  static std::mutex mutex;
  static std::deque<Kept> kept;
  const FileResult file = read_file(path);
  if (!file.ok()) {
    LoadedModel model;
    model.error = fmt::format("cannot read '{}': {}", path, file.error);
    return std::make_shared<const LoadedModel>(std::move(model));
  }
  const std::lock_guard<std::mutex> lock(mutex);
  for (const Kept& entry : kept) {
    if (entry.path == path && entry.bytes == file.value) return entry.model;
  }
  kept.push_back({path, file.value, std::make_shared<const LoadedModel>(read(path, file.value))});
  if (kept.size() > 16) kept.pop_front();
  return kept.back().model;
}

}  // namespace plantloop::identify
