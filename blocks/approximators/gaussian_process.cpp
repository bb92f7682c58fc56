// A Gaussian process from a model file.

#include <memory>
#include <vector>

#include "identify/error.h"
#include "identify/gp/gp_map.h"
#include "learned/map_block.h"
#include "learned/uncertain_kernel.h"

namespace plantloop {
namespace {

struct GaussianProcess final : MapBlock {
  GaussianProcess() : MapBlock("gaussian_process") {}
  static constexpr auto summary = "Run a Gaussian process that was identified from data, with its variance.";
  static constexpr auto details =
      "y = k(x)' K^-1 (t - m) + m(x),  variance = k(x, x) - k(x)' K^-1 k(x): that of the function itself; a "
      "measurement adds the noise v0 of the model file. Sparse models (fitc, vfe) have their inducing inputs in place "
      "of the data. Derivatives of both are exact. A model with regressors of the past runs in the block narx.  "
      "Where x is itself uncertain, x ~ N(x, x_covariance), `propagation` says what becomes of it: first_order "
      "linearises, moment_matching is exact in mean and variance, for sums and products of the covariances se_ard and "
      "linear; then `covariance` also says how the outputs depend on each other.";
  static constexpr auto example = R"(
blocks:
  gp: {type: gaussian_process, model: models/gaussian_process.yaml, in: {x: 0.5}}
  deviation: sqrt(gp.variance)
simulation: {stop: 1}
record: [gp.y, deviation]
expect:
  - {signal: gp.y, at: 1, value: -0.3612, abs: 1e-4}
  - {signal: deviation, at: 1, value: 0.0557, abs: 1e-4}
)";

  Choice propagation{
      this,
      "propagation",
      {.of = {"naive", "first_order", "moment_matching"}, .doc = "how the uncertainty of x is carried along"}};
  Input x_covariance{this, "x_covariance", {.doc = "of x, a matrix", .init = 0, .size = any_size}};
  Output variance{this, "variance", {.doc = "of each output, the function's without noise", .size = any_size}};
  Output covariance{this, "covariance", {.doc = "of the outputs with each other, as `variance`", .size = any_size}};

  void check(Checking& checking) const override {
    if (!report_model(checking, model, type)) return;
    const bool connected = Now().connected(x_covariance);
    if (propagation.is("naive")) {
      if (connected)
        checking.problem(propagation, "naive leaves the covariance of x out; first_order and moment_matching use it");
      return;
    }
    if (!connected)
      return checking.problem(x_covariance,
                              "first_order and moment_matching need the covariance of x, so port "
                              "x_covariance needs a wire");
    try {
      uncertain();
    } catch (const identify::IdentifyError& error) {
      checking.problem(propagation, error.what());
    }
  }

  void sizes(Sizing& sizing) const override {
    MapBlock::sizes(sizing);
    const auto loaded = model_of(model);
    if (!loaded) return;
    sizing.set(variance, shape_of(loaded->map->outputs()));
    sizing.set(covariance, square_of(loaded->map->outputs()));
    if (!propagation.is("naive")) sizing.expect(x_covariance, square_of(loaded->map->inputs()));
  }
  void outputs(Now now, Out out) const override {
    const auto loaded = model_of(model);
    if (!loaded) return;
    const int count = loaded->map->outputs();
    const Array in = now[x].spread(shape_of(loaded->map->inputs()));
    std::vector<Value> values;
    for (int i = 0; i < in.size(); ++i) values.push_back(in[i]);
    if (propagation.is("naive")) {
      const std::vector<Value> result = now.kernel(std::make_shared<MapKernel>(loaded->map, true), values);
      out[y] = array_of(result, 0, count);
      out[variance] = array_of(result, count, count);
      out[covariance] = diagonal_matrix(array_of(result, count, count));
      return;
    }
    const Array of_x = now[x_covariance].spread(square_of(in.size()));
    for (int i = 0; i < of_x.size(); ++i) values.push_back(of_x[i]);
    const std::vector<Value> result = now.kernel(uncertain(), values);
    out[y] = array_of(result, 0, count);
    out[covariance] = square_array(result, count, count);
    out[variance] = diagonal_of(square_array(result, count, count));
  }

 private:
  // Throws IdentifyError when the model cannot.
  std::shared_ptr<const Kernel> uncertain() const {
    const auto map = std::dynamic_pointer_cast<const identify::GpMap>(model_of(model)->map);
    return std::make_shared<UncertainMapKernel>(map, identify::find_propagation(std::string(propagation.value())));
  }
};

}  // namespace

PLANTLOOP_BLOCK(gaussian_process, GaussianProcess)

}  // namespace plantloop
