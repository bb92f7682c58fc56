// Model predictive control, linear and nonlinear.

#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "control/load_predictor.h"
#include "control/predictive_control.h"
#include "engine/base/numbers.h"
#include "engine/block_algebra.h"
#include "learned/map_block.h"

namespace plantloop {
namespace {

using ControlKernel = PredictiveControlKernel;

struct Nmpc final : Block {
  static constexpr auto summary = "Control by optimisation over a horizon: model predictive control.";
  static constexpr auto details =
      "At each sample the moves, inputs of which each is held for a block of samples, minimise\n"
      "  J = sum_{j=N1..N2} alpha (r(k+j) - y(k+j))^2 + sum_{moves} beta (change of u)^2\n"
      "over the prediction of the model, with N1 = `minimum_horizon`, N2 = `horizon`, alpha = `output_weight` and beta "
      "= "
      "`move_weight`; only u(k) is applied. The model is a model file (any identified dynamic model, polynomials, "
      "matrices) or a diagram without events and delays, whose signals `input` and `output` name: continuous, stepped "
      "by rk4 in `substeps` of a sample, or sampled with the controller's period. r is the set point, or with lambda "
      "the trajectory w - lambda^j (w - base) as in pfc. With "
      "correction: true the difference of plant and model at the sample is added to the prediction; where the state is "
      "measured, what it "
      "misses of the model's last prediction is added to the state at each sample to come. So no offset remains. "
      "Limits of inputs and of their rate are kept always. Limits of outputs (y_lower, y_upper), states of "
      "matrices and diagrams (x_lower, x_upper) and the variance of a Gaussian process hold at all samples of the "
      "horizon that an "
      "input can still reach; when no input keeps them they are exceeded as little as possible. With limits: soft they "
      "may be exceeded by s, for slack_weight (s + s^2) of each signal's greatest s. A linear model makes a quadratic "
      "program, which is solved exactly; others are solved by Gauss and Newton's method with exact derivatives (SQP) "
      "from the last moves on, and anew where a constant input of `candidates` between the limits is better. When "
      "max_iterations are used up, or max_time, the best moves so far are taken. Without max_time a run repeats to the "
      "last bit on any machine.  status: 0 optimum found, 1 optimum with a soft limit exceeded, 2 iterations or time "
      "used up, "
      "3 no input keeps the limits, 4 the model gives no finite prediction, and the last moves go on.";
  static constexpr auto example = R"(
blocks:
  w: {type: step, time: 1, before: 0, after: 1}
  c:
    type: nmpc
    model: models/linear_model.yaml
    in: {w: w, y: y}
    horizon: 10
    control_horizon: 3
    move_weight: 0.1
    upper: 1.5
  y: {type: unit_delay, in: 0.8*y + 0.2*c.u + 0.05, rate: 0.1}   # the model: 0.8 y + 0.2 u
simulation: {stop: 10}
record: [w, y, c.u]
expect:
  - {signal: y, at: 10, value: 1, abs: 1e-3}
  - {signal: c.u, max: 1.5}
)";

  Text model{this, "model", {.doc = "the model: a file as identification writes it, or a diagram", .file = true}};
  Text input{this,
             "input",
             {.doc = "of a diagram: the signals that are the model's inputs, one or more: u1, u2", .optional = true}};
  Text output{this, "output", {.doc = "of a diagram: the signals that are the model's outputs", .optional = true}};
  Count substeps{this,
                 "substeps",
                 {.init = 4, .doc = "of a continuous diagram: steps of rk4 in a sample", .min = 1, .max = 100000}};
  Input w{this,
          "w",
          {.doc = "set points of the outputs; (horizon + 1) x outputs when known in advance: now and at the "
                  "coming samples",
           .size = any_size}};
  Input y{this, "y", {.doc = "measured outputs", .size = any_size}};
  Input x{this,
          "x",
          {.doc = "measured or estimated state of a model of matrices or of a diagram, in the order of linearise; "
                  "without, the "
                  "model runs in parallel",
           .init = 0,
           .size = any_size}};
  Count minimum_horizon{
      this, "minimum_horizon", {.init = 1, .doc = "N1: the first sample that the cost sees", .min = 1, .max = 10000}};
  Count horizon{this, "horizon", {.init = 8, .doc = "N2: samples that are predicted", .min = 1, .max = 10000}};
  Count control_horizon{this,
                        "control_horizon",
                        {.init = 1, .doc = "Nu: values of the input; the last one is held", .min = 1, .max = 1000}};
  Table blocking{
      this,
      "blocking",
      {.doc =
           "move blocking: samples for which each move is held, the last one to the end; instead of control_horizon, "
           "which are held for one sample each",
       .structural = true,
       .optional = true,
       .min = 1}};
  Table output_weight{this,
                      "output_weight",
                      {.init = "1",
                       .doc = "alpha: one number, one of each output, or of one output one of each sample N1..N2",
                       .min = 0}};
  Table move_weight{
      this,
      "move_weight",
      {.init = "0", .doc = "beta: one number, one of each input, or of one input one of each move", .min = 0}};
  Number lambda{this,
                "lambda",
                {.init = 0,
                 .doc = "what is left of the error after a sample of the reference trajectory; 0: it is the set point",
                 .min = 0,
                 .max = 1,
                 .size = scalar}};
  Choice start{this, "start", {.of = {"measured", "reference"}, .doc = "where the reference trajectory begins"}};
  Choice correction{this,
                    "correction",
                    {.of = {"true", "false"}, .doc = "whether the error of the model is added to what it predicts"}};
  Table lower{this, "lower", {.doc = "least inputs", .optional = true}};
  Table upper{this, "upper", {.doc = "greatest inputs", .optional = true}};
  Table max_rate{this, "max_rate", {.doc = "greatest change of the inputs per second", .optional = true, .above = 0}};
  Table y_lower{this, "y_lower", {.doc = "least outputs", .optional = true}};
  Table y_upper{this, "y_upper", {.doc = "greatest outputs", .optional = true}};
  Table x_lower{this, "x_lower", {.doc = "least states, of matrices or a diagram", .optional = true}};
  Table x_upper{this, "x_upper", {.doc = "greatest states, of matrices or a diagram", .optional = true}};
  Table max_variance{
      this,
      "max_variance",
      {.doc = "greatest predicted variance of a measurement, of a Gaussian process", .optional = true, .above = 0}};
  Choice limits{this, "limits", {.of = {"hard", "soft"}, .doc = "of outputs, states and variances"}};
  Number slack_weight{
      this, "slack_weight", {.init = 1e4, .doc = "cost of exceeding a soft limit", .above = 0, .size = scalar}};
  Count candidates{
      this, "candidates", {.init = 11, .doc = "constant inputs that are tried at each sample", .min = 0, .max = 10000}};
  Count max_iterations{this, "max_iterations", {.init = 50, .doc = "at one sample", .min = 1, .max = 10000}};
  Number max_time{this,
                  "max_time",
                  {.init = 0,
                   .unit = "s",
                   .doc = "by the clock, for the search at one sample; 0: no limit. Results then depend on the machine",
                   .min = 0,
                   .structural = true,
                   .size = scalar}};
  Table start_of_model{
      this,
      "initial",
      {.doc = "what the model begins with: outputs before the start (default: the measured ones), of "
              "matrices the state (default: 0), of a diagram its state (default: its own); may read signals",
       .optional = true,
       .initial = true}};
  Table initial_u{
      this, "initial_u", {.init = "0", .doc = "inputs before the start; may read signals", .initial = true}};
  Discrete past_u{this, "past_u", {.doc = "inputs of the last sample", .size = any_size}};
  Discrete plan{this, "plan", {.doc = "moves of the last sample", .size = any_size}};
  Discrete state{this, "state", {.doc = "state of the model in parallel", .size = any_size}};
  Discrete reference{this, "reference", {.doc = "the reference's own state", .size = any_size}};
  Output u{this, "u", {.doc = "the inputs of the plant", .size = any_size}};
  Output std{this,
             "std",
             {.doc = "predicted standard deviations at the horizon; 0 where the model knows none", .size = any_size}};
  Output status{this, "status", {.doc = "how the search ended, see above", .size = scalar}};
  Output cost{this, "cost", {.doc = "J of the moves", .size = scalar}};
  Output excess{
      this, "excess", {.doc = "by how much a predicted signal exceeds its limit, the greatest one", .size = scalar}};
  Output iterations{this, "iterations", {.doc = "quadratic programs that were solved", .size = scalar}};

  std::string own_period() const override {
    const LoadedPredictor loaded = predictor();
    return loaded.Ts > 0 ? shortest(loaded.Ts) : "";
  }

  void check(Checking& checking) const override {
    if (model.value().empty()) return;  // reported where the file is named
    const LoadedPredictor loaded = predictor();
    if (!loaded.predictor) return checking.problem(model, loaded.error);
    if (!loaded.is_diagram && (!input.value().empty() || !output.value().empty()))
      return checking.problem(input.value().empty() ? output : input,
                              "only a diagram has signals to choose from; a model file has its own inputs and outputs");
    const Predictor& p = *loaded.predictor;
    if (minimum_horizon.value() > horizon.value())
      return checking.problem(minimum_horizon,
                              fmt::format("the cost begins at sample {}, behind the horizon of {} samples",
                                          minimum_horizon.value(), horizon.value()));
    const int count = check_moves(checking);
    if (count == 0) return;
    const auto fits = [&](const Table& table, int one, const char* each, int many, const char* other) {
      const int size = checking.given(table) || !table.spec.optional ? checking.shape(table).size() : 1;
      if (size == 1 || size == one || (one == 1 && size == many)) return true;
      std::string wanted = one > 1 ? fmt::format("one number or {}, one for each {}", one, each) : "one number";
      if (one == 1 && many > 1) wanted += fmt::format(" or {}, one for each {}", many, other);
      checking.problem(table, fmt::format("expected {}, got {} numbers", wanted, size));
      return false;
    };
    bool ok = fits(output_weight, p.outputs(), "output", horizon.value() - minimum_horizon.value() + 1,
                   "sample from N1 to N2");
    ok = fits(move_weight, p.inputs(), "input", count, "move") && ok;
    for (const Table* table : {&lower, &upper, &max_rate, &initial_u})
      ok = fits(*table, p.inputs(), "input", 1, "") && ok;
    for (const Table* table : {&y_lower, &y_upper}) ok = fits(*table, p.outputs(), "output", 1, "") && ok;
    for (const Table* table : {&x_lower, &x_upper}) {
      if (!checking.given(*table)) continue;
      if (p.has_variances() || p.extras() == 0) {
        checking.problem(*table,
                         "the model is made of past outputs and has no state to limit; y_lower and y_upper "
                         "limit the outputs");
        ok = false;
      } else {
        ok = fits(*table, p.state_size(), "state", 1, "") && ok;
      }
    }
    ok = fits(start_of_model, p.is_made_of_outputs() ? p.outputs() : p.state_size(),
              p.is_made_of_outputs() ? "output" : "state", 1, "") &&
         ok;
    if (checking.given(max_variance)) {
      if (!p.has_variances()) {
        checking.problem(max_variance, "only a Gaussian process knows how uncertain it is");
        ok = false;
      } else {
        ok = fits(max_variance, p.outputs(), "output", 1, "") && ok;
      }
    }
    if (!ok) return;
    check_pair(checking, lower, upper);
    check_pair(checking, y_lower, y_upper);
    check_pair(checking, x_lower, x_upper);
  }

  void sizes(Sizing& sizing) const override {
    const LoadedPredictor loaded = predictor();
    if (!loaded.predictor) return;
    const Predictor& p = *loaded.predictor;
    const Shape set_points = sizing.of(w);
    if (set_points.is_known() && set_points.size() != 1 && set_points.size() != p.outputs() &&
        set_points.size() != (horizon.value() + 1) * p.outputs()) {
      sizing.problem(w, fmt::format("the set point has {} {}, or {}: now and at the {} samples of the horizon",
                                    p.outputs(), p.outputs() == 1 ? "number" : "numbers, one for each output",
                                    (horizon.value() + 1) * p.outputs(), horizon.value()));
    }
    sizing.expect(y, shape_of(p.outputs()));
    const Shape measured = sizing.of(x);
    if (measured.is_known() && measured.size() > 1) {
      if (p.is_made_of_outputs()) {
        sizing.problem(x, "the model is made of past outputs and inputs, which the block keeps: leave x out");
      } else {
        sizing.expect(x, shape_of(p.state_size()));
      }
    }
    const int count = move_count(sizing.numbers(blocking));
    sizing.set(u, shape_of(p.inputs()));
    sizing.set(std, shape_of(p.outputs()));
    sizing.set(past_u, shape_of(p.inputs()));
    sizing.set(plan, shape_of(count * p.inputs()));
    sizing.set(state, shape_of(std::max(1, p.state_size())));
    sizing.set(reference, shape_of(p.outputs()));
  }

  void initial(Now now, Init init) const override {
    const LoadedPredictor loaded = predictor();
    if (!loaded.predictor) return;
    const Predictor& p = *loaded.predictor;
    const std::vector<Value> before = expanded(now[initial_u], p.inputs());
    const std::vector<Value> measured = expanded(now[y], p.outputs());
    init[past_u] = array_of(before, 0, p.inputs());
    init[reference] = array_of(measured, 0, p.outputs());
    std::vector<Value> all;
    for (int i = 0; i < moves_of(now) * p.inputs(); ++i)
      all.push_back(before[static_cast<std::size_t>(i % p.inputs())]);
    init[plan] = array_of(all, 0, static_cast<int>(all.size()));

    std::vector<double> from(static_cast<std::size_t>(p.state_size()));
    std::vector<Value> start_values;
    if (now.connected(x) && !p.is_made_of_outputs()) {
      start_values = expanded(now[x], p.state_size());
    } else if (p.is_made_of_outputs()) {
      // Where each number of the state comes from: the predictor is given places instead of values.
      std::vector<Value> sources = before;
      const std::vector<Value> outputs =
          now.given(start_of_model) ? expanded(now[start_of_model], p.outputs()) : measured;
      sources.insert(sources.end(), outputs.begin(), outputs.end());
      std::vector<double> places(sources.size());
      for (std::size_t i = 0; i < places.size(); ++i) places[i] = static_cast<double>(i);
      p.start(places.data(), places.data() + p.inputs(), from.data());
      for (const double place : from) start_values.push_back(sources[static_cast<std::size_t>(place)]);
    } else if (now.given(start_of_model)) {
      start_values = expanded(now[start_of_model], p.state_size());
    } else {
      p.start(nullptr, nullptr, from.data());
      for (const double number : from) start_values.emplace_back(number);
    }
    init[state] = array_of(start_values, 0, p.state_size());
  }

  void outputs(Now now, Out out) const override {
    const Solved s = solve(now);
    if (!s.kernel) return;
    const Predictor& p = s.kernel->predictor();
    out[u] = array_of(s.values, 0, p.inputs());
    out[std] = array_of(s.values, s.kernel->at_deviation(), p.outputs());
    out[status] = s[ControlKernel::status];
    out[cost] = s[ControlKernel::cost];
    out[excess] = s[ControlKernel::excess];
    out[iterations] = s[ControlKernel::iterations];
  }

  void update(Now now, Next next) const override {
    const Solved s = solve(now);
    if (!s.kernel) return;
    const Predictor& p = s.kernel->predictor();
    next[past_u] = array_of(s.values, 0, p.inputs());
    next[plan] = array_of(s.values, s.kernel->at_moves(), s.kernel->variables());
    next[reference] = array_of(s.values, s.kernel->at_reference(), p.outputs());
    next[state] = array_of(s.values, s.kernel->at_state(), p.state_size());
  }

 private:
  struct Solved {
    std::shared_ptr<const ControlKernel> kernel;
    std::vector<Value> values;
    Value operator[](ControlKernel::Result result) const {
      return values[static_cast<std::size_t>(kernel->at(result))];
    }
  };

  // Ts: of the controller, in s; 0 while it is not known.
  LoadedPredictor predictor(double Ts = 0) const {
    const std::string path = model.value();
    if (path.empty()) return {};
    return load_predictor({.path = path,
                           .inputs = names_in(input.value()),
                           .outputs = names_in(output.value()),
                           .substeps = substeps.value(),
                           .Ts = Ts});
  }
  static std::vector<std::string> names_in(const std::string& text) {
    std::vector<std::string> names(1);
    for (const char c : text) {
      if (c == ',') {
        names.emplace_back();
      } else if (c != ' ') {
        names.back() += c;
      }
    }
    if (names.back().empty()) names.pop_back();
    return names;
  }

  // The number of moves, 0 after reporting what is wrong about them.
  int check_moves(Checking& checking) const {
    if (!checking.given(blocking)) {
      if (control_horizon.value() <= horizon.value()) return control_horizon.value();
      checking.problem(control_horizon, fmt::format("{} moves do not fit into the horizon of {} samples",
                                                    control_horizon.value(), horizon.value()));
      return 0;
    }
    double sum = 0;
    const std::vector<double> lengths = checking.of(blocking);
    for (const double length : lengths) {
      if (length != std::floor(length)) {
        checking.problem(blocking, "a move is held for a whole number of samples");
        return 0;
      }
      if (sum >= horizon.value()) {
        checking.problem(blocking, fmt::format("a move begins at sample {:g}, behind the horizon of {} samples", sum,
                                               horizon.value()));
        return 0;
      }
      sum += length;
    }
    return static_cast<int>(lengths.size());
  }
  static void check_pair(Checking& checking, const Table& low, const Table& high) {
    if (!checking.given(low) || !checking.given(high)) return;
    const std::vector<double> a = checking.of(low), b = checking.of(high);
    for (std::size_t i = 0; i < std::max(a.size(), b.size()); ++i) {
      const double least = a[std::min(i, a.size() - 1)], greatest = b[std::min(i, b.size() - 1)];
      if (least > greatest)
        return checking.problem(high,
                                fmt::format("{} is {:g}, less than {}, {:g}", high.name, greatest, low.name, least));
    }
  }
  int move_count(const std::vector<double>& lengths) const {
    return lengths.empty() ? control_horizon.value() : static_cast<int>(lengths.size());
  }
  int moves_of(Now now) const { return now.given(blocking) ? now[blocking].size() : control_horizon.value(); }

  // One number spreads.
  static std::vector<Value> expanded(const Array& values, int count) {
    std::vector<Value> result;
    for (int i = 0; i < count; ++i) result.push_back(values[values.size() == 1 ? 0 : i]);
    return result;
  }
  // By time and channel: one number, one for each channel, or one for each time.
  static std::vector<Value> weights(const Array& values, int times, int channels) {
    std::vector<Value> result;
    for (int t = 0; t < times; ++t) {
      for (int c = 0; c < channels; ++c) result.push_back(values[values.size() == 1 ? 0 : channels > 1 ? c : t]);
    }
    return result;
  }

  PredictiveControl how(Now now) const {
    PredictiveControl result;
    result.first = minimum_horizon.value();
    result.horizon = horizon.value();
    result.blocks.assign(static_cast<std::size_t>(moves_of(now)), 1);
    if (now.given(blocking)) {
      const Array lengths = now[blocking];
      for (int i = 0; i < lengths.size(); ++i)
        result.blocks[static_cast<std::size_t>(i)] = static_cast<int>(lengths[i].number());
    }
    result.from_reference = start.is("reference");
    result.correction = correction.is("true");
    result.measures_state = now.connected(x);
    result.search.soft = limits.is("soft");
    result.search.candidates = candidates.value();
    result.search.max_iterations = max_iterations.value();
    result.search.max_time = now[max_time][0].number();
    return result;
  }

  Solved solve(Now now) const {
    Solved solved;
    const LoadedPredictor loaded = predictor(now.period().is_known() ? now.period().number() : std::nan(""));
    if (!loaded.predictor) return solved;
    const Predictor& p = *loaded.predictor;
    PredictiveControl options = how(now);
    const Array ahead = now[w];
    options.knows_set_points = ahead.size() > p.outputs();
    std::vector<Value> in;
    const auto add = [&](const std::vector<Value>& values) { in.insert(in.end(), values.begin(), values.end()); };
    const auto limit = [&](const Table& table, int count, double none) {
      add(expanded(now.given(table) ? now[table] : Array(none), count));
    };
    add(expanded(ahead, options.knows_set_points ? ahead.size() : p.outputs()));
    add(expanded(now[y], p.outputs()));
    if (options.measures_state) add(expanded(now[x], p.state_size()));
    limit(lower, p.inputs(), -1e300);
    limit(upper, p.inputs(), 1e300);
    add(expanded(now.given(max_rate) ? now[max_rate] * now.period() : Array(1e300), p.inputs()));
    add(weights(now[output_weight], options.horizon - options.first + 1, p.outputs()));
    add(weights(now[move_weight], static_cast<int>(options.blocks.size()), p.inputs()));
    limit(y_lower, p.outputs(), -1e300);
    if (p.has_variances()) {
      add(expanded(Array(-1e300), p.extras()));
    } else {
      limit(x_lower, p.extras(), -1e300);
    }
    limit(y_upper, p.outputs(), 1e300);
    limit(p.has_variances() ? max_variance : x_upper, p.extras(), 1e300);
    add(expanded(now[slack_weight], 1));
    add(expanded(now[lambda], 1));
    add(expanded(now[reference], p.outputs()));
    add(expanded(now[past_u], p.inputs()));
    add(expanded(now[plan], static_cast<int>(options.blocks.size()) * p.inputs()));
    add(expanded(now[state], p.state_size()));
    solved.kernel = std::make_shared<ControlKernel>(loaded.predictor, options);
    solved.values = now.kernel(solved.kernel, in);
    return solved;
  }
};

}  // namespace

PLANTLOOP_BLOCK(nmpc, Nmpc)

}  // namespace plantloop
