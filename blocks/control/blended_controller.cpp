// Controllers designed for several operating points, blended in one of three ways.

#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "engine/base/files.h"
#include "engine/block.h"
#include "engine/block_algebra.h"
#include "identify/error.h"
#include "identify/model_file/model_file.h"
#include "identify/velocity/controller_family.h"
#include "learned/map_block.h"

namespace plantloop {
namespace {

using identify::ControllerFamily;
using identify::ControllerPoint;

struct BlendedController final : Block {
  static constexpr auto summary = "Control by a family of linear controllers, blended by weights.";
  static constexpr auto details =
      "z' = p (e - z), zd = z', q' = N (zd - q), xf' = p (x - xf); the gains are the sums of those of the file's "
      "points "
      "by the weights, which are divided by their sum.  blending velocity: u' = ki z + kp zd + kd q' - K xf', which "
      "needs no derivative of a signal; gains that change do not move u, and u stands still at a limit, so nothing "
      "winds "
      "up (book equation 6.8, figure 6.11).  parameters: u = initial + ki I + kp z + kd q - K (xf - x at the start), "
      "I' = z (book figure 6.10).  signals: each controller has an I of its own, and their outputs are blended (book "
      "equation 6.4). With anti_windup tracking each I of the last two follows what was given, u or the port track, "
      "with "
      "the time constant t_track, also those of controllers that have no weight.";
  static constexpr auto example = R"(
blocks:
  mu: {type: triangular_weights, in: plant, centres: [0, 2]}
  c: {type: blended_controller, model: models/blended_controller.yaml, in: {e: 1.5 - plant, weights: mu}}
  plant: {type: integrator, in: c - plant*(1 + plant)}
simulation: {stop: 10}
record: [plant, c]
expect: [{signal: plant, measure: final, value: 1.5, abs: 1e-3}]
)";

  Text model{
      this, "model", {.doc = "the file of type controller_family, as the script function writes it", .file = true}};
  Input e{this, "e", {.doc = "control error, set point minus measured value", .size = scalar}};
  Input mu{this, "weights", {.doc = "weight of each point, not all 0", .size = any_size}};
  Input x{
      this, "x", {.doc = "measured states, of a file whose controllers feed them back", .init = 0, .size = any_size}};
  Input track{
      this, "track", {.doc = "what the actuator did, for anti_windup tracking; default: u", .init = 0, .size = scalar}};
  Choice blending{this, "blending", {.of = {"velocity", "parameters", "signals"}, .doc = "what is blended"}};
  Number p{
      this, "p", {.init = 100, .unit = "rad/s", .doc = "pole of the filter of e and x", .above = 0, .size = scalar}};
  Number N{
      this, "N", {.init = 100, .unit = "rad/s", .doc = "pole of the derivative's filter", .above = 0, .size = scalar}};
  Number initial_value{
      this,
      "initial",
      {.init = 0, .doc = "control signal at the start; may read signals", .size = scalar, .initial = true}};
  Limits limits{this, "least value of the control signal", "greatest value of the control signal"};
  Number slowest{
      this,
      "slowest",
      {.doc = "least speed of the control signal, as a rule below 0; velocity only: behind the others stands a "
              "rate_limiter whose output is led to track",
       .max = 0,
       .size = scalar,
       .optional = true}};
  Number fastest{
      this,
      "fastest",
      {.doc = "greatest speed of the control signal; velocity only", .min = 0, .size = scalar, .optional = true}};
  Choice anti_windup{this,
                     "anti_windup",
                     {.of = {"tracking", "none"}, .doc = "of parameters and signals: whether the integrals follow u"}};
  Number t_track{
      this, "t_track", {.init = 1, .unit = "s", .doc = "time constant of the tracking", .above = 0, .size = scalar}};
  State z{this, "z", {.doc = "filtered error", .size = scalar}};
  State q{this, "q", {.doc = "filtered derivative of the error", .size = scalar}};
  State xf{this, "xf", {.doc = "filtered states", .size = any_size}};
  State I{this, "I", {.doc = "the control signal (velocity), or the integrals of the error", .size = any_size}};
  Discrete bias{this, "bias", {.doc = "control signal at the start", .size = scalar}};
  Discrete origin{this, "origin", {.doc = "states at the start", .size = any_size}};
  Output u{this, "u", {.doc = "the limited control signal", .size = scalar}};

  void check(Checking& checking) const override {
    limits.check(checking);
    std::string error;
    const auto f = family(&error);
    if (!f) {
      if (!error.empty()) checking.problem(model, error);
      return;
    }
    if (is_velocity()) return;
    for (const Number* speed : {&slowest, &fastest}) {
      if (checking.given(*speed))
        checking.problem(*speed, fmt::format("'{}' is for blending velocity; with {} put a rate_limiter behind the "
                                             "controller and lead its output to 'track'",
                                             speed->name, blending.value()));
    }
    for (const ControllerPoint& point : f->points) {
      if (point.ki == 0 && anti_windup.is("tracking"))
        checking.problem(anti_windup,
                         fmt::format("the controller at {:g} has no integral part that could follow; write "
                                     "anti_windup: none",
                                     point.at));
    }
  }

  void sizes(Sizing& sizing) const override {
    const auto f = family();
    if (!f) return;
    const int count = static_cast<int>(f->points.size()), n = states(*f);
    sizing.set(xf, shape_of(n));
    sizing.set(origin, shape_of(n));
    sizing.set(I, shape_of(blending.is("signals") ? count : 1));
    sizing.expect(x, shape_of(n));
    const Shape given = sizing.of(mu);
    if (given.is_known() && given.size() != count)
      sizing.problem(mu, fmt::format("the file has {} points, but there are {} weights", count, given.size()));
  }

  void initial(Now now, Init init) const override {
    const auto f = family();
    if (!f) return;
    const Value start = limits.clamp(now, now[initial_value])[0];
    init[bias] = start;
    init[origin] = input_states(now, *f);
    init[xf] = input_states(now, *f);
    if (is_velocity()) init[I] = start;
  }

  void outputs(Now now, Out out) const override {
    const auto f = family();
    if (!f) return;
    out[u] = is_velocity() ? now[I] : limits.clamp(now, Array(raw(now, *f)));
  }

  void derivatives(Now now, Rates rate) const override {
    const auto f = family();
    if (!f) return;
    const Value zd = now[p][0] * (now[e][0] - now[z][0]), qd = now[N][0] * (zd - now[q][0]);
    const Array xd = now[p][0] * (input_states(now, *f) - now[xf]);
    rate[z] = zd;
    rate[q] = qd;
    rate[xf] = xd;
    if (is_velocity()) {
      Array speed(answer(blended(now, *f), {now[z][0], zd, qd, xd}));
      if (now.given(slowest)) speed = max(speed, now[slowest]);
      if (now.given(fastest)) speed = min(speed, now[fastest]);
      rate[I] = limits.stand_still(now, now[I], speed);
      return;
    }
    const bool tracks =
        anti_windup.is("tracking") && (blending.is("signals") || now.connected(track) || limits.given(now));
    Array change(shape_of(now[I].size()));
    const Value given = now.connected(track) ? now[track][0] : limits.clamp(now, Array(raw(now, *f)))[0];
    for (int i = 0; i < change.size(); ++i) {
      const Gains g = blending.is("signals") ? gains_of(f->points[static_cast<std::size_t>(i)]) : blended(now, *f);
      change[i] = now[z][0];
      if (tracks) change[i] = change[i] + (given - local(now, g, now[I][i])) / (now[t_track][0] * g.ki);
    }
    rate[I] = change;
  }

  void jumps(Now now, Jumps jump) const override {
    if (is_velocity() && family()) limits.stop_at_limits(now, jump, I);
  }

 private:
  struct Gains {
    Value kp, ki, kd;
    std::vector<Value> K;
  };
  // What the gains are multiplied by: the error's integral, the error, its derivative, and the states.
  struct Parts {
    Value integral, error, derivative;
    Array states;
  };

  bool is_velocity() const { return blending.is("velocity"); }
  static int states(const ControllerFamily& f) { return std::max(1, static_cast<int>(f.states.size())); }

  std::shared_ptr<const ControllerFamily> family(std::string* error = nullptr) const {
    const std::string path = model.value();
    if (path.empty()) return nullptr;  // reported where the file is named
    const FileResult file = read_file(path);
    std::string why = file.ok() ? "" : fmt::format("cannot read '{}': {}", path, file.error);
    if (file.ok()) {
      try {
        return std::make_shared<const ControllerFamily>(
            identify::controller_family_of(identify::read_model_file(file.value, path)));
      } catch (const identify::IdentifyError& wrong) {
        why = wrong.what();
      }
    }
    if (error != nullptr) *error = why;
    return nullptr;
  }

  Array input_states(Now now, const ControllerFamily& f) const {
    return f.states.empty() ? Array(0.0) : now[x].spread(shape_of(states(f)));
  }
  static Gains gains_of(const ControllerPoint& point) {
    Gains g{point.kp, point.ki, point.kd, {}};
    for (Eigen::Index j = 0; j < point.K.size(); ++j) g.K.emplace_back(point.K[j]);
    return g;
  }
  std::vector<Value> weights(Now now, const ControllerFamily& f) const {
    std::vector<Value> shares;
    const Array given = now[mu];
    for (int i = 0; i < static_cast<int>(f.points.size()); ++i) shares.push_back(given.at(i) / sum(given));
    return shares;
  }
  Gains blended(Now now, const ControllerFamily& f) const {
    const std::vector<Value> share = weights(now, f);
    Gains sum{0, 0, 0, std::vector<Value>(f.states.size(), Value(0))};
    for (std::size_t i = 0; i < f.points.size(); ++i) {
      const Gains g = gains_of(f.points[i]);
      sum.kp = sum.kp + share[i] * g.kp;
      sum.ki = sum.ki + share[i] * g.ki;
      sum.kd = sum.kd + share[i] * g.kd;
      for (std::size_t j = 0; j < g.K.size(); ++j) sum.K[j] = sum.K[j] + share[i] * g.K[j];
    }
    return sum;
  }
  static Value answer(const Gains& g, const Parts& parts) {
    Value u = g.ki * parts.integral + g.kp * parts.error + g.kd * parts.derivative;
    for (std::size_t j = 0; j < g.K.size(); ++j) u = u - g.K[j] * parts.states[static_cast<int>(j)];
    return u;
  }
  // The control signal of one controller with its integral, before the limits.
  Value local(Now now, const Gains& g, Value integral) const {
    return now[bias][0] + answer(g, {integral, now[z][0], now[q][0], now[xf] - now[origin]});
  }
  Value raw(Now now, const ControllerFamily& f) const {
    if (!blending.is("signals")) return local(now, blended(now, f), now[I][0]);
    const std::vector<Value> share = weights(now, f);
    Value whole = 0;
    for (std::size_t i = 0; i < f.points.size(); ++i)
      whole = whole + share[i] * local(now, gains_of(f.points[i]), now[I][static_cast<int>(i)]);
    return whole;
  }
};

}  // namespace

PLANTLOOP_BLOCK(blended_controller, BlendedController)

}  // namespace plantloop
