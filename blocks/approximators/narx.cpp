// A learned dynamic model: a map with the past that it needs.

#include <fmt/format.h>
#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "engine/base/numbers.h"
#include "identify/error.h"
#include "identify/gp/gp_map.h"
#include "learned/map_block.h"
#include "learned/uncertain_kernel.h"

namespace plantloop {
namespace {

using identify::Factor;
using identify::LoadedModel;
using identify::Regressor;

struct Narx final : Block {
  static constexpr auto summary = "Predict with a dynamic model that was identified from data, one step or freely.";
  static constexpr auto details =
      "y(k) = f(regressors), a map of any kind with regressors such as y(k-1), u(k-1..3) from the model file, which "
      "also gives the sampling time. mode one_step: the past outputs are those measured at port y; free_run: they are "
      "the model's own, and port y stays free. Before the start outputs are `initial` and inputs `initial_u`.  "
      "variance: of the function, where the map is a Gaussian process, else 0. In free run `propagation` says how the "
      "uncertainty of past outputs is carried along: naive ignores it, first_order linearises, moment_matching is "
      "exact in mean and variance, for the covariances se_ard, linear and their sum; these two need one output and "
      "single lags as regressors.";
  static constexpr auto example = R"(
blocks:
  u: {type: step, time: 1, before: 0, after: 1.2}
  model: {type: narx, mode: free_run, model: models/narx.yaml, in: {u: u}}   # y(k) = 0.8 y(k-1) + 0.2 u(k-1)
simulation: {stop: 20}
record: [u, model.y]
expect: [{signal: model.y, at: 20, value: 1.2, abs: 1e-3}]
)";

  Text model{this, "model", {.doc = "the model file, as identification writes it", .file = true}};
  Choice mode{this, "mode", {.of = {"free_run", "one_step"}, .doc = "where past outputs come from"}};
  Choice propagation{this,
                     "propagation",
                     {.of = {"naive", "first_order", "moment_matching"},
                      .doc = "how a Gaussian process in free run carries uncertainty along"}};
  Number initial_y{this,
                   "initial",
                   {.init = 0, .doc = "outputs before the start; may read signals", .size = scalar, .initial = true}};
  Number initial_u{this,
                   "initial_u",
                   {.init = 0, .doc = "inputs before the start; may read signals", .size = scalar, .initial = true}};
  Input u{this, "u", {.doc = "inputs of the model, in its order and units", .size = any_size}};
  Input measured{this, "y", {.doc = "measured outputs; of one_step", .init = 0, .size = any_size}};
  Discrete past_u{this, "past_u", {.doc = "inputs of the last samples, newest first", .size = any_size}};
  Discrete past_y{this, "past_y", {.doc = "outputs of the last samples, newest first", .size = any_size}};
  Output y{this, "y", {.doc = "predicted outputs", .size = any_size}};
  Output variance{this, "variance", {.doc = "of each, the function's without noise", .size = any_size}};

  std::string own_period() const override {
    const auto loaded = usable();
    return loaded ? shortest(loaded->narx.channels.Ts) : "";
  }

  void check(Checking& checking) const override {
    if (!report_model(checking, model, "")) return;
    const auto loaded = model_of(model);
    if (!loaded->dynamic)
      return checking.problem(model, fmt::format("the model '{}' has no regressors; the block {} runs it",
                                                 model.value(), loaded->map->type()));
    const Now now;
    const bool needs_y = mode.is("one_step") && loaded->narx.regressors.uses_outputs();
    if (needs_y && !now.connected(measured))
      checking.problem(measured, "mode one_step predicts from measured outputs, so port y needs a wire");
    if (!needs_y && now.connected(measured))
      checking.problem(measured, mode.is("one_step") ? "the model has no regressors of outputs, so port y stays free"
                                                     : "mode free_run feeds the model's own outputs back, so port y "
                                                       "stays free");
    if (propagation.is("naive")) return;
    if (mode.is("one_step"))
      return checking.problem(propagation, "mode one_step has certain regressors, so there is nothing to carry along");
    try {
      uncertain(*loaded);
    } catch (const identify::IdentifyError& error) {
      checking.problem(propagation, error.what());
    }
  }

  void sizes(Sizing& sizing) const override {
    const auto loaded = usable();
    if (!loaded) return;
    const int width = input_count(*loaded), count = loaded->map->outputs();
    if (width > 0) sizing.expect(u, shape_of(width));
    if (mode.is("one_step") && loaded->narx.regressors.uses_outputs()) sizing.expect(measured, shape_of(count));
    sizing.set(past_u, shape_of(std::max(1, width * depth(*loaded, false))));
    sizing.set(past_y, shape_of(std::max(1, count * depth(*loaded, true))));
    sizing.set(y, shape_of(count));
    sizing.set(variance, shape_of(count));
  }

  void initial(Now now, Init init) const override {
    init[past_u] = now[initial_u];
    init[past_y] = now[initial_y];
  }

  void outputs(Now now, Out out) const override {
    const auto loaded = usable();
    if (!loaded) return;
    const int count = loaded->map->outputs();
    std::vector<Value> x = regressors(now, *loaded);
    if (!propagation.is("naive")) {
      x.push_back(now[initial_y][0]);
      const std::vector<Value> result = now.kernel(uncertain(*loaded), x, x);
      out[y] = array_of(result, 0, 1);
      out[variance] = array_of(result, 1, 1);
      return;
    }
    const bool certain = loaded->map->has_variance();
    const std::vector<Value> result = now.kernel(std::make_shared<MapKernel>(loaded->map, certain), x);
    out[y] = array_of(result, 0, count);
    if (certain) {
      out[variance] = array_of(result, count, count);
    } else {
      out[variance] = 0.0;
    }
  }

  void update(Now now, Next next) const override {
    const auto loaded = usable();
    if (!loaded) return;
    const int width = input_count(*loaded), count = loaded->map->outputs();
    if (width > 0 && depth(*loaded, false) > 0) next[past_u] = shifted(now[past_u], now[u].spread(shape_of(width)));
    // The kernel of an uncertain run keeps the outputs itself.
    if (depth(*loaded, true) == 0 || !propagation.is("naive")) return;
    if (mode.is("one_step")) {
      next[past_y] = shifted(now[past_y], now[measured].spread(shape_of(count)));
    } else {
      const auto kernel =
          std::make_shared<MapKernel>(loaded->map, loaded->map->has_variance());  // the one of outputs()
      next[past_y] = shifted(now[past_y], array_of(now.kernel(kernel, regressors(now, *loaded)), 0, count));
    }
  }

 private:
  std::shared_ptr<const LoadedModel> usable() const {
    const auto loaded = model_of(model);
    return loaded && loaded->dynamic ? loaded : nullptr;
  }
  static int input_count(const LoadedModel& loaded) { return static_cast<int>(loaded.narx.regressors.inputs.size()); }
  // How many samples of outputs or inputs are kept.
  static int depth(const LoadedModel& loaded, bool of_outputs) {
    int longest = 0;
    for (const Regressor& regressor : loaded.narx.regressors.list) {
      for (const Factor& factor : regressor.factors) {
        if (factor.of_output == of_outputs) longest = std::max(longest, factor.lag);
      }
    }
    return longest;
  }
  static Array shifted(const Array& past, const Array& newest) {
    Array result = past;
    for (int i = past.size() - 1; i >= newest.size(); --i) result[i] = past[i - newest.size()];
    for (int i = 0; i < newest.size(); ++i) result[i] = newest[i];
    return result;
  }
  // As identification makes them: products in the order of the factors.
  std::vector<Value> regressors(Now now, const LoadedModel& loaded) const {
    const int width = input_count(loaded), count = loaded.map->outputs();
    const Array u_past = now[past_u], y_past = now[past_y];
    std::vector<Value> x;
    for (const Regressor& regressor : loaded.narx.regressors.list) {
      Value product = 1;
      for (const Factor& factor : regressor.factors) {
        Value value = 0;
        if (factor.of_output) {
          value = y_past[(factor.lag - 1) * count + factor.channel];
        } else if (factor.lag == 0) {
          value = now[u].spread(shape_of(width))[factor.channel];
        } else {
          value = u_past[(factor.lag - 1) * width + factor.channel];
        }
        Value power = 1;
        for (int i = 0; i < factor.power; ++i) power = power * value;
        product = product * power;
      }
      x.push_back(product);
    }
    return x;
  }
  // Throws IdentifyError when the model cannot.
  std::shared_ptr<const Kernel> uncertain(const LoadedModel& loaded) const {
    const auto map = std::dynamic_pointer_cast<const identify::GpMap>(loaded.map);
    if (!map) identify::fail("only a Gaussian process knows how uncertain it is, this is '{}'", loaded.map->type());
    return std::make_shared<UncertainKernel>(map, loaded.narx.regressors,
                                             identify::find_propagation(std::string(propagation.value())), true);
  }
};

}  // namespace

PLANTLOOP_BLOCK(narx, Narx)

}  // namespace plantloop
