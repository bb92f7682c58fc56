// One linear model in velocity form.

#include <fmt/format.h>

#include "learned/velocity_block.h"

namespace plantloop {
namespace {

struct VelocityModel final : VelocityBlock {
  static constexpr auto summary = "Simulate one velocity-based linearisation of a nonlinear system.";
  static constexpr auto details =
      "ud = N (u - uf), uf' = ud;  w' = A w + B ud,  y' = C w + D ud, with the matrices of one point of the file. It "
      "follows the system near that point, also where that is no rest, and from any output at the start.  Of a file "
      "with a "
      "sampling time Ts, w(t) = A w(t - Ts) + B ud(t - Ts): between samples y moves from one to the next, and just "
      "before "
      "k Ts it is what the sampled system is at (k - 1) Ts.";
  static constexpr auto example = R"(
blocks:
  u: {type: step, time: 1, before: 0, after: 2}
  plant: {type: velocity_model, model: models/velocity_model.yaml, in: u, point: 2, initial: 5}
simulation: {stop: 10}
record: [u, plant]
expect: [{signal: plant, measure: final, value: 7, abs: 1e-3}]   # what the input adds, from where it was
)";

  Count point{this, "point", {.init = 1, .doc = "which point of the file, from 1", .min = 1}};
  Output y{this, "y", {.doc = "outputs of the model", .size = any_size}};
  Output filtered{this, "uf", {.doc = "the filtered inputs", .size = any_size}};

  void check(Checking& checking) const override {
    const auto f = checked(checking);
    if (f && point.value() > static_cast<int>(f->points.size()))
      checking.problem(point,
                       fmt::format("the file has {} points, there is no number {}", f->points.size(), point.value()));
  }
  void sizes(Sizing& sizing) const override { set_sizes(sizing, y, filtered); }
  void outputs(Now now, Out out) const override {
    out[y] = now[integral];
    out[filtered] = now[uf];
  }

 protected:
  Weights weights(Now, const identify::VelocityFamily& f) const override {
    std::vector<Value> one(f.points.size(), Value(0));
    if (point.value() <= static_cast<int>(one.size())) one[static_cast<std::size_t>(point.value() - 1)] = 1;
    return {one, one};
  }
};

}  // namespace

PLANTLOOP_BLOCK(velocity_model, VelocityModel)

}  // namespace plantloop
