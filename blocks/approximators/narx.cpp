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
using identify::NarxModel;
using identify::Regressor;

struct Narx final : Block {
  static constexpr auto summary = "Predict with a dynamic model that was identified from data, one step or freely.";
  static constexpr auto details =
      "y(k) = f(regressors), a map of any kind with regressors such as y(k-1), u(k-1..3) from the model file, which "
      "also gives the sampling time. mode one_step: the past outputs are those measured at port y; free_run: they are "
      "the model's own, and port y stays free. A noise model in the file (NARMAX, NBJ) serves one_step, where errors "
      "of "
      "past predictions are known; free_run takes them as 0. Before the start outputs are `initial` and inputs "
      "`initial_u`.  "
      "variance: of the function, where the map is a Gaussian process, else 0. In free run `propagation` says how the "
      "uncertainty of past outputs is carried along: naive ignores it, first_order linearises, moment_matching is "
      "exact in mean and variance, for sums and products of the covariances se_ard and linear; these two need single "
      "lags as regressors. Of several outputs, all fed back, they carry the covariances along too.";
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
  Discrete past_e{this, "past_e", {.doc = "errors of the last predictions, of a noise model", .size = any_size}};
  Discrete past_s{this, "past_s", {.doc = "what the map left of the last outputs, of a noise model", .size = any_size}};
  Output y{this, "y", {.doc = "predicted outputs", .size = any_size}};
  Output variance{this, "variance", {.doc = "of each, the function's without noise", .size = any_size}};
  Output covariance{this, "covariance", {.doc = "of the outputs with each other, as `variance`", .size = any_size}};

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
    const bool needs_y = reads_measured(*loaded);
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
    if (reads_measured(*loaded)) sizing.expect(measured, shape_of(count));
    sizing.set(past_u, shape_of(std::max(1, width * depth(*loaded, Past::inputs))));
    sizing.set(past_y, shape_of(std::max(1, count * depth(*loaded, Past::outputs))));
    sizing.set(past_e, shape_of(std::max(1, count * depth(*loaded, Past::errors))));
    sizing.set(past_s, shape_of(std::max(1, count * depth(*loaded, Past::rests))));
    sizing.set(y, shape_of(count));
    sizing.set(variance, shape_of(count));
    sizing.set(covariance, square_of(count));
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
    if (const NarxModel* const noisy = with_noise(*loaded)) {
      out[y] = predicted(now, *noisy, mapped(now, *loaded));
      out[variance] = 0.0;
      out[covariance] = 0.0;
      return;
    }
    if (!propagation.is("naive")) {
      for (int o = 0; o < count; ++o) x.push_back(now[initial_y][0]);
      const std::vector<Value> result = now.kernel(uncertain(*loaded), x, x);
      out[y] = array_of(result, 0, count);
      out[covariance] = square_array(result, count, count);
      out[variance] = diagonal_of(square_array(result, count, count));
      return;
    }
    const bool certain = loaded->map->has_variance();
    const std::vector<Value> result = now.kernel(std::make_shared<MapKernel>(loaded->map, certain), x);
    out[y] = array_of(result, 0, count);
    const Array own = certain ? array_of(result, count, count) : Array(shape_of(count), 0.0);
    out[variance] = own;
    out[covariance] = diagonal_matrix(own);
  }

  void update(Now now, Next next) const override {
    const auto loaded = usable();
    if (!loaded) return;
    const int width = input_count(*loaded), count = loaded->map->outputs();
    if (width > 0 && depth(*loaded, Past::inputs) > 0)
      next[past_u] = shifted(now[past_u], now[u].spread(shape_of(width)));
    if (const NarxModel* const noisy = with_noise(*loaded)) {
      const Array map = mapped(now, *loaded), y_now = now[measured].spread(shape_of(count));
      const Array prediction = predicted(now, *noisy, map);
      Array error = map, rest = map;
      for (int o = 0; o < count; ++o) {
        error[o] = y_now[o] - prediction[o];
        rest[o] = y_now[o] - map[o];
      }
      if (depth(*loaded, Past::errors) > 0) next[past_e] = shifted(now[past_e], error);
      if (depth(*loaded, Past::rests) > 0) next[past_s] = shifted(now[past_s], rest);
      if (depth(*loaded, Past::outputs) > 0) next[past_y] = shifted(now[past_y], noisy->simulated ? map : y_now);
      return;
    }
    // The kernel of an uncertain run keeps the outputs itself.
    if (depth(*loaded, Past::outputs) == 0 || !propagation.is("naive")) return;
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
  // The model with its noise model, where past errors are known; else null.
  const NarxModel* with_noise(const LoadedModel& loaded) const {
    return mode.is("one_step") ? loaded.with_noise.get() : nullptr;
  }
  const NarxModel& running(const LoadedModel& loaded) const {
    return with_noise(loaded) != nullptr ? *loaded.with_noise : loaded.narx;
  }
  bool reads_measured(const LoadedModel& loaded) const {
    return mode.is("one_step") && (loaded.with_noise || loaded.narx.regressors.uses_outputs());
  }
  enum class Past { inputs, outputs, errors, rests };
  // How many samples of them are kept.
  int depth(const LoadedModel& loaded, Past of) const {
    const NarxModel& its = running(loaded);
    const auto order = [](const std::vector<Eigen::VectorXd>& polynomials) {
      int longest = 0;
      for (const Eigen::VectorXd& each : polynomials) longest = std::max(longest, static_cast<int>(each.size()) - 1);
      return longest;
    };
    if (of == Past::rests) return order(its.noise.D);
    int longest = of == Past::errors ? order(its.noise.C) : 0;
    for (const Regressor& regressor : its.regressors.list) {
      for (const Factor& factor : regressor.factors) {
        const Past kind = factor.of_output                  ? Past::outputs
                          : its.regressors.is_error(factor) ? Past::errors
                                                            : Past::inputs;
        if (kind == of) longest = std::max(longest, factor.lag);
      }
    }
    return longest;
  }
  // The map's outputs.
  Array mapped(Now now, const LoadedModel& loaded) const {
    const auto kernel = std::make_shared<MapKernel>(running(loaded).map, false);
    return array_of(now.kernel(kernel, regressors(now, loaded)), 0, loaded.map->outputs());
  }
  // In the order of identify::filtered_noise.
  Array predicted(Now now, const NarxModel& noisy, const Array& map) const {
    Array result = map;
    if (noisy.noise.empty()) return result;
    const int count = map.size();
    const Array e = now[past_e], s = now[past_s];
    for (int o = 0; o < count; ++o) {
      const Eigen::VectorXd& C = noisy.noise.C[static_cast<std::size_t>(o)];
      const Eigen::VectorXd& D = noisy.noise.D[static_cast<std::size_t>(o)];
      Value sum = 0;
      for (int i = 1; i < C.size(); ++i) sum = sum + C[i] * e[(i - 1) * count + o];
      for (int i = 1; i < D.size(); ++i) sum = sum - D[i] * s[(i - 1) * count + o];
      result[o] = map[o] + sum;
    }
    return result;
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
    const Array u_past = now[past_u], y_past = now[past_y], e_past = now[past_e];
    const identify::RegressorSet& set = running(loaded).regressors;
    std::vector<Value> x;
    for (const Regressor& regressor : set.list) {
      Value product = 1;
      for (const Factor& factor : regressor.factors) {
        Value value = 0;
        if (factor.of_output) {
          value = y_past[(factor.lag - 1) * count + factor.channel];
        } else if (set.is_error(factor)) {
          value = e_past[(factor.lag - 1) * count + factor.channel - set.data_inputs()];
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
