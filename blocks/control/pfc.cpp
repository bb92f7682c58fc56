// Predictive functional control.

#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "engine/base/numbers.h"
#include "engine/block_algebra.h"
#include "learned/functional_control.h"
#include "learned/map_block.h"

namespace plantloop {
namespace {

struct Pfc final : Block {
  static constexpr auto summary = "Control by the prediction of a model: predictive functional control.";
  static constexpr auto details =
      "At each sample the inputs to come, u(k+j) = c1 + c2 j + ... with `basis` coefficients, are those with which the "
      "model's prediction meets the reference trajectory w - lambda^h (w - base) at the coincidence points h, in the "
      "sense of least squares; only u(k) is applied. The model is any identified one of one input and one output, its "
      "file as narx runs it. base is the measured output or, with start: reference, the reference's own state, which "
      "approaches w by lambda from sample to sample. With correction: true the model runs in parallel and the "
      "difference from the plant is added to its prediction, so that no offset remains; without, each prediction "
      "starts from the measured outputs. w is one number, or horizon + 1 of them where the set point is known in "
      "advance: now and at the coming samples. Of several constant inputs that meet one point the least in magnitude "
      "is taken; where none does, the one that comes nearest.  max_variance: the predicted variance of a measurement "
      "at the horizon, by a Gaussian process, stays below it, with a constant input.  status: 0 the prediction meets "
      "the reference, 1 a limit of the input keeps it from there, 2 the limit on the variance does, 3 no input keeps "
      "that limit, so that of the least variance is taken.";
  static constexpr auto example = R"(
blocks:
  w: {type: step, time: 1, before: 0, after: 1}
  c: {type: pfc, model: models/narx.yaml, in: {w: w, y: y}}
  y: {type: unit_delay, in: 0.8*y + 0.2*c.u + 0.05, rate: 0.1}   # the model: 0.8 y + 0.2 u
simulation: {stop: 10}
record: [w, y, c.u]
expect: [{signal: y, at: 10, value: 1, abs: 1e-3}]
)";

  Text model{this, "model", {.doc = "the model file, as identification writes it", .file = true}};
  Input w{this, "w", {.doc = "set point", .size = any_size}};
  Input y{this, "y", {.doc = "measured output", .size = scalar}};
  Count horizon{this, "horizon", {.init = 8, .doc = "samples that are predicted", .min = 1, .max = 10000}};
  Table coincidence{this,
                    "coincidence",
                    {.doc = "samples at which the prediction meets the reference, ascending; default: the horizon",
                     .structural = true,
                     .optional = true,
                     .ascending = true,
                     .min = 1}};
  Count basis{
      this,
      "basis",
      {.init = 1, .doc = "coefficients of the input's polynomial: 1 holds it, 2 ramps it", .min = 1, .max = 10}};
  Number lambda{this,
                "lambda",
                {.init = 0.9048374180359595,  // exp(-1/10)
                 .doc = "what is left of the error after a sample of the reference: exp(-Ts/T) for the time constant T",
                 .min = 0,
                 .max = 1,
                 .size = scalar}};
  Choice start{this, "start", {.of = {"measured", "reference"}, .doc = "where the reference trajectory begins"}};
  Choice correction{this,
                    "correction",
                    {.of = {"true", "false"}, .doc = "whether the model runs in parallel and its error is added"}};
  Number lower{this, "lower", {.init = -1e3, .doc = "least input", .size = scalar}};
  Number upper{this, "upper", {.init = 1e3, .doc = "greatest input", .size = scalar}};
  Number max_rate{this,
                  "max_rate",
                  {.doc = "greatest change of the input per second", .above = 0, .size = scalar, .optional = true}};
  Number max_variance{
      this,
      "max_variance",
      {.doc = "greatest predicted variance, of a Gaussian process", .above = 0, .size = scalar, .optional = true}};
  Choice propagation{this,
                     "propagation",
                     {.of = {"naive", "first_order", "moment_matching"},
                      .doc = "how a Gaussian process carries uncertainty along the horizon"}};
  Choice search_by{this,
                   "search",
                   {.of = {"automatic", "refine", "candidates"},
                    .doc = "whether the search goes on between the candidates; automatic: unless the model is a "
                           "Gaussian process, whose predictions take long"}};
  Count candidates{this,
                   "candidates",
                   {.init = 301, .doc = "inputs between the limits that are tried first", .min = 3, .max = 100000}};
  Number start_y{this,
                 "initial",
                 {.doc = "outputs of the model before the start; default: the measured one; may read signals",
                  .size = scalar,
                  .optional = true,
                  .initial = true}};
  Number initial_u{this,
                   "initial_u",
                   {.init = 0, .doc = "inputs before the start; may read signals", .size = scalar, .initial = true}};
  Discrete past_u{this, "past_u", {.doc = "inputs of the last samples, newest first", .size = any_size}};
  Discrete past_y{this, "past_y", {.doc = "outputs of the last samples, newest first", .size = any_size}};
  Discrete model_y{this, "model_y", {.doc = "outputs of the model in parallel, this sample's first", .size = any_size}};
  Discrete reference{this, "reference", {.doc = "the reference's own state", .size = scalar}};
  Output u{this, "u", {.doc = "the input of the plant", .size = scalar}};
  Output std{this,
             "std",
             {.doc = "predicted standard deviation at the last point; 0 where the model knows none", .size = scalar}};
  Output status{this, "status", {.doc = "whether the reference is met, and what keeps it from there", .size = scalar}};

  std::string own_period() const override {
    const auto loaded = model_of(model);
    return loaded && loaded->dynamic ? shortest(loaded->narx.channels.Ts) : "";
  }

  void check(Checking& checking) const override {
    if (!report_model(checking, model, "")) return;
    FunctionalControl how = search();
    how.limits_variance = checking.given(max_variance);
    if (const std::string why = FunctionalControlKernel::why_not(*model_of(model), how); !why.empty())
      return checking.problem(how.limits_variance ? static_cast<const Declared&>(max_variance) : model, why);
    check_order(checking, lower, upper, true);
    int points = 1;
    if (checking.given(coincidence)) {
      const std::vector<double> at = checking.of(coincidence);
      for (const double number : at) {
        if (number != std::floor(number))
          return checking.problem(coincidence, "the points are whole numbers of samples");
        if (number > horizon.value())
          return checking.problem(coincidence,
                                  fmt::format("the point {:g} lies beyond the horizon, {}", number, horizon.value()));
      }
      points = static_cast<int>(at.size());
    }
    if (basis.value() > points)
      checking.problem(basis, fmt::format("{} coefficients need as many coincidence points, but there {} {}",
                                          basis.value(), points == 1 ? "is" : "are", points));
  }

  void sizes(Sizing& sizing) const override {
    if (const Shape shape = sizing.of(w);
        shape.is_known() && shape.size() != 1 && shape.size() != horizon.value() + 1) {
      sizing.problem(w, fmt::format("the set point is one number, or {}: now and at the {} samples of the horizon",
                                    horizon.value() + 1, horizon.value()));
    }
    const auto kernel = make_kernel(search());
    if (!kernel) return;
    sizing.set(past_u, shape_of(kernel->past_inputs()));
    sizing.set(past_y, shape_of(kernel->past_outputs()));
    sizing.set(model_y, shape_of(kernel->past_outputs()));
  }

  void initial(Now now, Init init) const override {
    const Value measured = now[y][0];
    init[past_u] = now[initial_u];
    init[past_y] = measured;
    init[model_y] = now.given(start_y) ? now[start_y][0] : measured;
    init[reference] = measured;
  }

  void outputs(Now now, Out out) const override {
    const std::vector<Value> result = move(now);
    if (result.empty()) return;
    out[u] = result[FunctionalControlKernel::input];
    out[std] = result[FunctionalControlKernel::deviation];
    out[status] = result[FunctionalControlKernel::status];
  }

  void update(Now now, Next next) const override {
    const std::vector<Value> result = move(now);
    if (result.empty()) return;
    next[past_u] = shifted(now[past_u], result[FunctionalControlKernel::input]);
    next[past_y] = shifted(now[past_y], now[y][0]);
    next[model_y] = shifted(now[model_y], result[FunctionalControlKernel::model_output]);
    next[reference] = result[FunctionalControlKernel::reference];
  }

 private:
  // What the words and counts of the block ask for.
  FunctionalControl search() const {
    return {.coincidence = {horizon.value()},
            .basis = basis.value(),
            .from_reference = start.is("reference"),
            .correction = correction.is("true"),
            .propagation = identify::find_propagation(std::string(propagation.value())),
            .candidates = candidates.value(),
            .refines = refines()};
  }
  bool refines() const {
    if (!search_by.is("automatic")) return search_by.is("refine");
    const auto loaded = model_of(model);
    return !loaded || !loaded->map->has_variance();
  }
  std::shared_ptr<const FunctionalControlKernel> make_kernel(const FunctionalControl& how) const {
    const auto loaded = model_of(model);
    if (!loaded || !FunctionalControlKernel::why_not(*loaded, how).empty()) return nullptr;
    return std::make_shared<FunctionalControlKernel>(loaded, how);
  }
  std::vector<Value> move(Now now) const {
    FunctionalControl how = search();
    if (now.given(coincidence)) {
      const Array points = now[coincidence];
      how.coincidence.clear();
      for (int i = 0; i < points.size(); ++i) how.coincidence.push_back(static_cast<int>(points[i].number()));
    }
    const Array ahead = now[w];
    how.set_points = ahead.size();
    how.limits_variance = now.given(max_variance);
    const auto kernel = make_kernel(how);
    if (!kernel) return {};
    std::vector<Value> in;
    const auto add = [&](const Array& values) {
      for (int i = 0; i < values.size(); ++i) in.push_back(values[i]);
    };
    add(ahead);
    add(now[y]);
    add(now[lower]);
    add(now[upper]);
    add(now.given(max_rate) ? now[max_rate] * now.period() : Array(1e300));
    add(now.given(max_variance) ? now[max_variance] : Array(0.0));
    add(now[lambda]);
    add(now[reference]);
    add(now[past_u]);
    add(now[past_y]);
    add(now[model_y]);
    return now.kernel(kernel, in);
  }
  static Array shifted(const Array& past, Value newest) {
    Array result = past;
    for (int i = past.size() - 1; i > 0; --i) result[i] = past[i - 1];
    result[0] = newest;
    return result;
  }
};

}  // namespace

PLANTLOOP_BLOCK(pfc, Pfc)

}  // namespace plantloop
