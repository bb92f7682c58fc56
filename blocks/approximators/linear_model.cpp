// A linear model that was identified from data, in its own sampling time.

#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "engine/base/numbers.h"
#include "identify/narx/load.h"
#include "learned/map_block.h"

namespace plantloop {
namespace {

using identify::StateSpaceModel;

struct LinearModel final : Block {
  static constexpr auto summary = "Simulate a linear model that was identified from data.";
  static constexpr auto details =
      "x(k+1) = A x(k) + B (u(k) - u0),  y(k) = y0 + C x(k) + D (u(k) - u0): the free run of a model file of "
      "polynomials (FIR, ARX, ARMAX, OE, BJ; their noise is left out) or of matrices, around the operating point u0, "
      "y0 and at the sampling time that the file gives. An estimated constant is part of y0. Polynomials are run in "
      "their observer companion form.";
  static constexpr auto example = R"(
blocks:
  u: {type: step, time: 1, before: 0, after: 1.2}
  model: {type: linear_model, model: models/linear_model.yaml, in: {u: u}}   # y(k) = 0.8 y(k-1) + 0.2 u(k-1)
simulation: {stop: 10}
record: [u, model]
expect: [{signal: model, at: 10, value: 1.2, abs: 1e-3}]
)";

  Text model{this, "model", {.doc = "the model file, as identification writes it", .file = true}};
  Choice start{
      this,
      "start",
      {.of = {"operating_point", "rest"},
       .doc = "the first state: that of the operating point, or the one in which the first input leaves it at rest"}};
  Input u{this, "u", {.doc = "inputs of the model, in its order and units", .size = any_size}};
  Discrete x{this, "x", {.doc = "state of the model", .size = any_size}};
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
    if (loaded->neural)
      return checking.problem(
          model, fmt::format("'{}' holds a neural state-space model; the block neural_state_space runs it", path));
    if (!loaded->linear)
      return checking.problem(
          model, fmt::format("'{}' holds a model of type '{}', which is not linear; {} runs it", path,
                             loaded->map->type(), loaded->dynamic ? "the block narx" : "a block of that type"));
    if (start.is("rest") && !identify::states_at_rest(*loaded->linear).allFinite())
      checking.problem(start, "the model integrates, so no state is at rest; start at its operating_point");
  }

  void sizes(Sizing& sizing) const override {
    const auto m = usable();
    if (!m) return;
    if (m->B.cols() > 0) sizing.expect(u, shape_of(static_cast<int>(m->B.cols())));
    sizing.set(x, shape_of(order(*m)));
    sizing.set(y, shape_of(static_cast<int>(m->C.rows())));
  }

  void initial(Now now, Init init) const override {
    const auto m = usable();
    if (!m) return;
    if (start.is("operating_point") || m->A.rows() == 0) {
      init[x] = 0.0;
    } else {
      init[x] = affine(now, *m, Eigen::MatrixXd(m->A.rows(), 0), identify::states_at_rest(*m));
    }
  }

  void outputs(Now now, Out out) const override {
    const auto m = usable();
    if (!m) return;
    Array result = affine(now, *m, m->C, m->D);
    for (int i = 0; i < result.size(); ++i) result[i] = m->y0[i] + result[i];
    out[y] = result;
  }

  void update(Now now, Next next) const override {
    const auto m = usable();
    if (m && m->A.rows() > 0) next[x] = affine(now, *m, m->A, m->B);
  }

 private:
  std::shared_ptr<const StateSpaceModel> usable() const {
    const std::string path = model.value();
    return path.empty() ? nullptr : identify::load_model(path)->linear;
  }
  // A model without poles (FIR of one coefficient) has a state that is not used.
  static int order(const StateSpaceModel& m) { return std::max(1, static_cast<int>(m.A.rows())); }
  // P x + Q (u - u0), without the terms that are 0.
  Array affine(Now now, const StateSpaceModel& m, const Eigen::MatrixXd& P, const Eigen::MatrixXd& Q) const {
    Array state;
    if (P.cols() > 0) state = now[x];
    const bool driven = Q.cols() > 0 && !Q.isZero(0);
    Array in;
    if (driven) in = now[u].spread(shape_of(static_cast<int>(Q.cols())));
    Array result(shape_of(static_cast<int>(Q.rows())));
    for (int i = 0; i < result.size(); ++i) {
      Value sum = 0;
      for (int j = 0; j < P.cols(); ++j) {
        if (P(i, j) != 0) sum = sum + P(i, j) * state[j];
      }
      for (int j = 0; driven && j < Q.cols(); ++j) {
        if (Q(i, j) != 0) sum = sum + Q(i, j) * (in[j] - m.u0[j]);
      }
      result[i] = sum;
    }
    return result;
  }
};

}  // namespace

PLANTLOOP_BLOCK(linear_model, LinearModel)

}  // namespace plantloop
