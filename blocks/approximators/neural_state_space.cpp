// A neural state-space model that was identified from data, in its own sampling time.

#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "engine/base/numbers.h"
#include "identify/narx/load.h"
#include "learned/map_block.h"

namespace plantloop {
namespace {

using identify::NeuralStateSpace;

struct NeuralStateSpaceBlock final : Block {
  static constexpr auto summary = "Simulate a neural state-space model that was identified from data.";
  static constexpr auto details =
      "x(k+1) = f(x(k), u(k)),  y(k) = g(x(k), u(k)): the free run of a model file, at the sampling time that the file "
      "gives. f and g are networks beside a linear model; each input may act some samples late, before the start it "
      "has its first value. Derivatives are exact.";
  static constexpr auto example = R"(
blocks:
  u: {type: step, time: 1, before: 0, after: 1}
  # x(k+1) = 0.5 x + tanh(u), y = x
  net: {type: neural_state_space, model: models/neural_state_space.yaml, in: {u: u}}
simulation: {stop: 5}
record: [u, net.y]
expect: [{signal: net.y, at: 5, value: 1.5231883119, abs: 1e-5}]
)";

  Text model{this, "model", {.doc = "the model file, as identification writes it", .file = true}};
  Number first{this,
               "initial",
               {.init = 0, .doc = "first state, in the model's own numbers; may read signals", .initial = true}};
  Input u{this, "u", {.doc = "inputs of the model, in its order and units", .size = any_size}};
  Discrete x{this, "x", {.doc = "state of the model", .size = any_size}};
  Discrete past{this, "past_u", {.doc = "inputs of the last samples, newest first", .size = any_size}};
  Output y{this, "y", {.doc = "outputs of the model", .size = any_size}};

  std::string own_period() const override {
    const auto m = usable();
    return m ? shortest(m->Ts) : "";
  }

  void check(Checking& checking) const override {
    const std::string path = model.value();
    if (path.empty()) return;  // reported where the file is named
    const auto loaded = identify::load_model(path);
    if (!loaded->error.empty()) return checking.problem(model, loaded->error);
    if (loaded->neural) return;
    if (loaded->linear)
      return checking.problem(model, fmt::format("'{}' holds a linear model; the block linear_model runs it", path));
    checking.problem(model, fmt::format("'{}' holds a model of type '{}'; the block {} runs it", path,
                                        loaded->map->type(), loaded->dynamic ? "narx" : loaded->map->type()));
  }

  void sizes(Sizing& sizing) const override {
    const auto m = usable();
    if (!m) return;
    sizing.expect(u, shape_of(inputs(*m)));
    sizing.set(x, shape_of(static_cast<int>(m->order())));
    sizing.set(past, shape_of(std::max(1, longest(*m) * inputs(*m))));
    sizing.set(y, shape_of(m->output->outputs()));
  }

  void initial(Now now, Init init) const override {
    const auto m = usable();
    if (!m) return;
    init[x] = now[first].spread(shape_of(static_cast<int>(m->order())));
    const int width = inputs(*m), depth = longest(*m);
    if (depth == 0) {
      init[past] = 0.0;
      return;
    }
    const Array in = now[u].spread(shape_of(width));
    Array before(shape_of(width * depth));
    for (int i = 0; i < before.size(); ++i) before[i] = in[i % width];
    init[past] = before;
  }

  void outputs(Now now, Out out) const override {
    const auto m = usable();
    if (!m) return;
    const auto map = std::make_shared<MapKernel>(m->output, false);
    out[y] = array_of(now.kernel(map, arguments(now, *m, m->has_feedthrough())), 0, m->output->outputs());
  }

  void update(Now now, Next next) const override {
    const auto m = usable();
    if (!m) return;
    const auto map = std::make_shared<MapKernel>(m->transition, false);
    next[x] = array_of(now.kernel(map, arguments(now, *m, true)), 0, m->transition->outputs());
    const int width = inputs(*m);
    if (longest(*m) == 0) return;
    Array shifted = now[past];
    const Array in = now[u].spread(shape_of(width));
    for (int i = shifted.size() - 1; i >= width; --i) shifted[i] = shifted[i - width];
    for (int i = 0; i < width; ++i) shifted[i] = in[i];
    next[past] = shifted;
  }

 private:
  std::shared_ptr<const NeuralStateSpace> usable() const {
    const std::string path = model.value();
    return path.empty() ? nullptr : identify::load_model(path)->neural;
  }
  static int inputs(const NeuralStateSpace& m) { return static_cast<int>(m.inputs.size()); }
  static int longest(const NeuralStateSpace& m) { return *std::max_element(m.delay.begin(), m.delay.end()); }
  // [x; u], or x alone where the inputs are not read.
  std::vector<Value> arguments(Now now, const NeuralStateSpace& m, bool with_inputs) const {
    std::vector<Value> z;
    const Array state = now[x];
    for (int i = 0; i < state.size(); ++i) z.push_back(state[i]);
    if (!with_inputs) return z;
    const int width = inputs(m);
    const Array late = now[past];
    for (int i = 0; i < width; ++i) {
      const int delay = m.delay[static_cast<std::size_t>(i)];
      z.push_back(delay == 0 ? now[u].spread(shape_of(width))[i] : late[(delay - 1) * width + i]);
    }
    return z;
  }
};

}  // namespace

PLANTLOOP_BLOCK(neural_state_space, NeuralStateSpaceBlock)

}  // namespace plantloop
