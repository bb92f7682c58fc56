// A learned map and its derivative.

#include <fmt/format.h>

#include <algorithm>

#include "learned/map_block.h"

namespace plantloop {
namespace {

// The entries of dy/dx, row by row.
class JacobianKernel final : public Kernel {
 public:
  explicit JacobianKernel(std::shared_ptr<const identify::Approximator> map) : map_(std::move(map)) {}
  std::string name() const override { return "derivative of a learned map"; }
  bool is_same(const Kernel& other) const override {
    const auto* const jacobian = dynamic_cast<const JacobianKernel*>(&other);
    return jacobian && jacobian->map_ == map_;
  }
  int outputs() const override { return map_->outputs() * map_->inputs(); }
  int scratch_size() const override { return map_->scratch_size(); }
  void evaluate(const KernelCall& call) const override { map_->derivative(call.in, call.out, call.scratch); }

 private:
  std::shared_ptr<const identify::Approximator> map_;
};

struct LinearisedMap final : Block {
  static constexpr auto summary = "Linearise a learned map at each instant: its value and its exact derivative.";
  static constexpr auto details =
      "y = f(x), jacobian = df/dx, offset = y - jacobian x, so that near x the map is jacobian x + offset. The model "
      "may "
      "be a network, local models, radial functions or a Gaussian process; of a dynamic one x are its regressors, in "
      "their order. Fed by the present regressors it gives the linear model of the instant, from which a controller "
      "is designed while it runs (instantaneous linearisation; M. Norgaard et al., Neural Networks for Modelling and "
      "Control of Dynamic Systems, 2000).";
  static constexpr auto example = R"(
blocks:
  net: {type: linearised_map, model: models/mlp.yaml, in: {x: "[0.5, -0.6]"}, rate: 1}
  near: {type: mlp, model: models/mlp.yaml, in: {x: "[0.5001, -0.6]"}, rate: 1}
  slope: (near - net.y)/0.0001
simulation: {stop: 1}
record: [net.jacobian.1, slope]
expect: [{signal: net.jacobian.1 - slope, max_abs: 1e-3}]
)";

  Text model{this, "model", {.doc = "the model file, as identification writes it", .file = true}};
  Input x{this, "x", {.doc = "what the model was made for, in its order and units", .size = any_size}};
  Output y{this, "y", {.doc = "the outputs of the model", .size = any_size}};
  Output jacobian{this, "jacobian", {.doc = "dy/dx: a row for each output; of one output a vector", .size = any_size}};
  Output offset{this, "offset", {.doc = "y - jacobian x", .size = any_size}};

  void check(Checking& checking) const override { report_model(checking, model, ""); }

  void sizes(Sizing& sizing) const override {
    const auto loaded = model_of(model);
    if (!loaded) return;
    const int n = loaded->map->inputs(), m = loaded->map->outputs();
    sizing.expect(x, shape_of(n));
    sizing.set(y, shape_of(m));
    sizing.set(offset, shape_of(m));
    sizing.set(jacobian, m == 1 ? shape_of(n) : Shape::matrix(m, n));
  }

  void outputs(Now now, Out out) const override {
    const auto loaded = model_of(model);
    if (!loaded) return;
    const int n = loaded->map->inputs(), m = loaded->map->outputs();
    const Array in = now[x].spread(shape_of(n));
    const std::vector<Value> regressors(in.values().begin(), in.values().end());
    const std::vector<Value> slopes = now.kernel(std::make_shared<JacobianKernel>(loaded->map), regressors);
    const Array values = array_of(now.kernel(std::make_shared<MapKernel>(loaded->map, false), regressors), 0, m);
    Array table(m == 1 ? shape_of(n) : Shape::matrix(m, n)), rest(shape_of(m));
    std::copy(slopes.begin(), slopes.end(), &table[0]);
    for (int i = 0; i < m; ++i) {
      Value linear = 0;
      for (int j = 0; j < n; ++j)
        linear = linear + slopes[static_cast<std::size_t>(i * n + j)] * regressors[static_cast<std::size_t>(j)];
      rest[i] = values[i] - linear;
    }
    out[y] = values;
    out[jacobian] = table;
    out[offset] = rest;
  }
};

}  // namespace

PLANTLOOP_BLOCK(linearised_map, LinearisedMap)

}  // namespace plantloop
