// Newton's method with the natural monotonicity test: Deuflhard, Newton Methods for Nonlinear Problems, section 3.3. A
// step is damped until the simplified correction after it is shorter than the one before, which does not depend on how
// the equations are scaled. Iteration goes on to rounding, not to a tolerance: a derivative that is noisy in its tenth
// digit costs an integrator more steps than the last iteration costs here.

#include "engine/program/solve_loop.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "engine/program/slots_read.h"

namespace plantloop {

namespace {

constexpr int most_iterations = 60;
constexpr double last_step = 1e-9;  // relative; the error after such a step is its square
constexpr double least_damping = 1e-10;
constexpr double off_by_rounding = 1e-10;  // of the terms of an equation that have an unknown
// As a relative change of what the equations are given: some hundred roundings.
constexpr double off_by_rounding_of_data = 1e-13;
constexpr int most_mode_passes = 20;
constexpr double same_value = 1e-12;  // of an unknown by two branches

constexpr const char* remedies =
    "\n  a state breaks the loop: the lag or integrator that is there in the plant, or, in sampled parts, a unit_delay"
    "\n  or an algebraic_constraint states the equation, with bounds and an initial_guess near its solution"
    "\n  a delay of one step in a continuous loop is no remedy: the result would depend on the step";

// Finite; without bounds any number.
double clipped(double value, double lower, double upper) { return std::min(std::max(value, lower), upper); }

class Search {
 public:
  Search(const Program::Loop& loop, double* arena, KernelFrame& frame)
      : loop_(loop),
        arena_(arena),
        frame_(frame),
        n_(loop.size()),
        u_(arena + loop.unknowns, n_),
        accepted_(frame.loop_values + loop.first_value, n_) {
    double* room = frame.loop_room + loop.first_room;
    has_factors_ = room++;
    const auto take = [&](std::size_t count) {
      const std::span<double> part(room, count);
      room += count;
      return part;
    };
    factors_ = take(n_ * n_);
    rows_ = take(n_);
    residual_ = take(n_);
    step_ = take(n_);
    correction_ = take(n_);
    before_ = take(n_);
    nearest_ = take(n_);
    nearest_residual_ = take(n_);
    last_ = take(n_);
  }

  static std::size_t room(std::size_t n) { return 1 + n * n + 8 * n; }

  void run() {
    begin_at(accepted_);
    if (loop_.modes.empty()) return solve();
    take_modes();
    for (int pass = 1; pass < most_mode_passes; ++pass) {
      solve();
      if (!take_modes()) return;
      // Where two branches meet, rounding may go from one to the other for ever: both give the same values.
      if (pass > 1 && is_as_before()) return;
      std::copy(u_.begin(), u_.end(), last_.begin());
    }
    solve();
    std::vector<std::size_t> changed;
    if (take_modes(&changed)) fail_to_settle(changed);
  }

 private:
  bool is_as_before() const {
    for (std::size_t i = 0; i < n_; ++i) {
      if (!(std::fabs(u_[i] - last_[i]) <= same_value * std::max(1.0, std::fabs(u_[i])))) return false;
    }
    return true;
  }

  void solve() {
    if (loop_.affine ? solve_affine() : newton()) return;
    if (!loop_.affine && !frame_.left && look_elsewhere()) return;
    fail();
  }

  // The modes by the present values (S11); whether one changed.
  bool take_modes(std::vector<std::size_t>* which = nullptr) {
    execute(loop_.mode_list, arena_, &frame_);
    bool any = false;
    for (std::size_t m = 0; m < loop_.modes.size(); ++m) {
      const double now = arena_[loop_.mode_list.roots[m]];
      if (now == arena_[loop_.modes[m]] || std::isnan(now)) continue;
      arena_[loop_.modes[m]] = now;
      any = true;
      if (which != nullptr) which->push_back(m);
    }
    return any;
  }

  [[noreturn]] void fail_to_settle(const std::vector<std::size_t>& changed) {
    const double time = arena_[frame_.program->time];
    std::string names;
    for (const std::size_t m : changed) {
      const std::string name = "'" + frame_.program->sites[loop_.mode_sites[m]].path + "'";
      if (names.find(name) == std::string::npos) names += (names.empty() ? "" : ", ") + name;
    }
    throw LoopError(fmt::format("at time {:g} s the algebraic loop {} does not settle: solved {} times, and the branch "
                                "that is taken in {} changes each time{}",
                                time, loop_.path, most_mode_passes, names, remedies),
                    time, frame_.program->sites[loop_.site].path);
  }

  double lower(std::size_t i) const { return loop_.lower[i] == no_bound ? -infinity : arena_[loop_.lower[i]]; }
  double upper(std::size_t i) const { return loop_.upper[i] == no_bound ? infinity : arena_[loop_.upper[i]]; }

  void begin_at(std::span<const double> values) {
    for (std::size_t i = 0; i < n_; ++i) u_[i] = clipped(values[i], lower(i), upper(i));
  }

  // The residuals at u_, into residual_; whether all are finite.
  bool evaluate() {
    execute(loop_.residual_list, arena_, &frame_);
    bool finite = true;
    for (std::size_t i = 0; i < n_; ++i) {
      residual_[i] = arena_[loop_.residual_list.roots[i]];
      finite = finite && std::isfinite(residual_[i]);
    }
    return finite;
  }

  // The factors of the Jacobian at u_; false where it is singular or not finite.
  bool factorise() {
    if (loop_.constant && *has_factors_ == 1) return true;
    std::fill(factors_.begin(), factors_.end(), 0.0);
    if (loop_.exact) {
      if (!loop_.jacobian_list.roots.empty()) execute(loop_.jacobian_list, arena_, &frame_);
      for (std::size_t e = 0; e < loop_.row.size(); ++e)
        factors_[loop_.row[e] * n_ + loop_.column[e]] = arena_[loop_.jacobian_list.roots[e]];
    } else {
      difference();
    }
    const bool done = eliminate();
    *has_factors_ = done ? 1 : 0;
    return done;
  }

  // Columns by forward differences: a kernel without derivative takes part. residual_ is that at u_.
  void difference() {
    std::copy(residual_.begin(), residual_.end(), correction_.begin());
    for (std::size_t j = 0; j < n_; ++j) {
      const double value = u_[j];
      double h = 1.5e-8 * std::max(std::fabs(value), 1e-3);
      if (value + h > upper(j)) h = -h;
      u_[j] = value + h;
      evaluate();
      for (std::size_t i = 0; i < n_; ++i) factors_[i * n_ + j] = (residual_[i] - correction_[i]) / h;
      u_[j] = value;
    }
    std::copy(correction_.begin(), correction_.end(), residual_.begin());
  }

  // Gauss's elimination with row pivots, in place.
  bool eliminate() {
    for (std::size_t i = 0; i < n_; ++i) rows_[i] = static_cast<double>(i);
    for (std::size_t k = 0; k < n_; ++k) {
      std::size_t best = k;
      for (std::size_t i = k + 1; i < n_; ++i) {
        if (std::fabs(factors_[i * n_ + k]) > std::fabs(factors_[best * n_ + k])) best = i;
      }
      const double pivot = factors_[best * n_ + k];
      if (pivot == 0 || !std::isfinite(pivot)) return false;
      if (best != k) {
        std::swap_ranges(factors_.begin() + row(k), factors_.begin() + row(k + 1), factors_.begin() + row(best));
        std::swap(rows_[k], rows_[best]);
      }
      for (std::size_t i = k + 1; i < n_; ++i) {
        const double factor = factors_[i * n_ + k] /= pivot;
        if (factor == 0) continue;
        for (std::size_t j = k + 1; j < n_; ++j) factors_[i * n_ + j] -= factor * factors_[k * n_ + j];
      }
    }
    return true;
  }
  std::ptrdiff_t row(std::size_t i) const { return static_cast<std::ptrdiff_t>(i * n_); }

  // x = -J^-1 residual_
  void correct(std::span<double> x) const {
    for (std::size_t i = 0; i < n_; ++i) {
      double sum = -residual_[static_cast<std::size_t>(rows_[i])];
      for (std::size_t j = 0; j < i; ++j) sum -= factors_[i * n_ + j] * x[j];
      x[i] = sum;
    }
    for (std::size_t i = n_; i-- > 0;) {
      for (std::size_t j = i + 1; j < n_; ++j) x[i] -= factors_[i * n_ + j] * x[j];
      x[i] /= factors_[i * n_ + i];
    }
  }

  bool solve_affine() {
    if (!evaluate() || !factorise()) return false;
    correct(step_);
    bool finite = true;
    for (std::size_t i = 0; i < n_; ++i) {
      u_[i] += step_[i];
      finite = finite && std::isfinite(u_[i]) && u_[i] >= lower(i) && u_[i] <= upper(i);
    }
    return finite;
  }

  bool newton() {
    if (!evaluate()) return false;
    for (int iteration = 0; iteration < most_iterations; ++iteration) {
      remember_nearest();
      if (std::all_of(residual_.begin(), residual_.end(), [](double r) { return r == 0; })) return true;
      if (!factorise()) return false;
      correct(step_);
      if (std::any_of(step_.begin(), step_.end(), [](double s) { return !std::isfinite(s); })) return false;
      if (is_last_step()) return take_last_step();
      std::copy(u_.begin(), u_.end(), before_.begin());
      if (!damped_step()) {
        std::copy(before_.begin(), before_.end(), u_.begin());
        return evaluate() && is_rounding();
      }
    }
    return is_rounding();
  }

  bool is_last_step() const {
    for (std::size_t i = 0; i < n_; ++i) {
      if (std::fabs(step_[i]) > last_step * std::fabs(u_[i])) return false;
    }
    return true;
  }

  // At a bound the step may point outwards: then the equations have no solution inside.
  bool take_last_step() {
    for (std::size_t i = 0; i < n_; ++i) {
      const double to = u_[i] + step_[i];
      u_[i] = clipped(to, lower(i), upper(i));
    }
    return true;
  }

  bool damped_step() {
    const double length = size(step_);
    for (double damping = 1; damping > least_damping; damping *= 0.5) {
      bool moved = false;
      for (std::size_t i = 0; i < n_; ++i) {
        u_[i] = clipped(before_[i] + damping * step_[i], lower(i), upper(i));
        moved = moved || u_[i] != before_[i];
      }
      if (!moved) return false;
      if (!evaluate()) continue;
      correct(correction_);
      if (size(correction_) <= (1 - 0.25 * damping) * length) return true;
      // Steps that do not help: before trying ever shorter ones, see whether there is anything left to solve.
      if (damping == 0.25) {
        std::copy(before_.begin(), before_.end(), u_.begin());
        if (!evaluate() || is_rounding()) return false;
      }
    }
    return false;
  }

  // A correction in units of the unknowns or of the step, whichever is larger.
  double size(std::span<const double> x) const {
    double most = 0;
    for (std::size_t i = 0; i < n_; ++i) {
      const double unit = std::max(std::fabs(before_[i]), std::fabs(step_[i]));
      const double one = x[i] == 0 ? 0 : std::fabs(x[i]) / unit;
      if (!(one <= most)) most = one;
    }
    return most;
  }

  // Nothing is left of the residuals but the rounding of their terms.
  bool is_rounding() {
    for (std::size_t i = 0; i < n_; ++i) {
      double terms = 0;
      for (std::size_t e = 0; e < loop_.row.size(); ++e) {
        if (loop_.row[e] != i) continue;
        terms += std::fabs(arena_[loop_.jacobian_list.roots[e]] * u_[loop_.column[e]]);
      }
      if (!(std::fabs(residual_[i]) <= off_by_rounding * terms)) return is_rounding_of_data();
    }
    return true;
  }

  // The equations hold exactly when what they are given is changed in its last digits: the terms with an unknown may be
  // small beside the others, as where a voltage passes through zero.
  bool is_rounding_of_data() {
    const std::vector<double> left_over(residual_.begin(), residual_.end());
    std::vector<double> terms(n_, 0.0), far(n_);
    constexpr double change = 1e-7;  // relative
    const auto changed = [&](std::uint32_t slot, double by) {
      const double value = arena_[slot];
      arena_[slot] = value * (1 + by);
      const bool finite = evaluate();
      arena_[slot] = value;
      return finite;
    };
    for (const std::uint32_t slot : slots_read(loop_.residual_list)) {
      if (slot >= loop_.unknowns && slot < loop_.unknowns + n_) continue;
      if (!changed(slot, change)) continue;
      std::copy(residual_.begin(), residual_.end(), far.begin());
      if (!changed(slot, 0.5 * change)) continue;
      for (std::size_t i = 0; i < n_; ++i) {
        const double whole = std::fabs(far[i] - left_over[i]), half = std::fabs(residual_[i] - left_over[i]);
        if (half <= 0.75 * whole) terms[i] += whole / change;  // what a condition switches is no term
      }
    }
    if (!evaluate()) return false;
    for (std::size_t i = 0; i < n_; ++i) {
      if (!(std::fabs(left_over[i]) <= off_by_rounding_of_data * terms[i])) return false;
    }
    return true;
  }

  // For the message: where the equations were nearest to hold.
  void remember_nearest() {
    double norm = 0;
    for (const double r : residual_) norm = std::max(norm, std::fabs(r));
    if (!(norm < nearest_norm_)) return;
    nearest_norm_ = norm;
    std::copy(u_.begin(), u_.end(), nearest_.begin());
    std::copy(residual_.begin(), residual_.end(), nearest_residual_.begin());
  }

  // After an event the solution may be far from the last one.
  bool look_elsewhere() {
    for (std::size_t i = 0; i < n_; ++i) u_[i] = loop_.guess[i] == no_bound ? 0 : arena_[loop_.guess[i]];
    if (newton()) return true;
    if (n_ == 1 && search_between()) return true;
    for (const double start : {1.0, -1.0, 0.1, -0.1, 10.0, -10.0, 100.0, -100.0}) {
      for (std::size_t i = 0; i < n_; ++i) u_[i] = clipped(start, lower(i), upper(i));
      if (newton()) return true;
    }
    return false;
  }

  // One unknown: the change of sign nearest to the start, between the bounds or, without, ever further away; then by
  // halves, and by Newton's method from there.
  bool search_between() {
    const double start =
        clipped(loop_.guess[0] == no_bound ? accepted_[0] : arena_[loop_.guess[0]], lower(0), upper(0));
    constexpr int parts = 64;
    double from_up = start, from_down = start;
    double at_up = residual_at(start), at_down = at_up;
    for (int i = 1; i <= parts; ++i) {
      const double reach = std::isfinite(lower(0)) && std::isfinite(upper(0))
                               ? (upper(0) - lower(0)) * i / parts
                               : 1e-3 * std::max(1.0, std::fabs(start)) * std::exp2(0.5 * i);
      for (const bool up : {true, false}) {
        const double to = up ? std::min(start + reach, upper(0)) : std::max(start - reach, lower(0));
        double& from = up ? from_up : from_down;
        double& at_from = up ? at_up : at_down;
        if (to == from) continue;
        const double at_to = residual_at(to);
        if (std::isfinite(at_from) && std::isfinite(at_to) && (at_from < 0) != (at_to < 0)) {
          if (halve(from, to, at_from)) return true;
        }
        from = to;
        at_from = at_to;
      }
    }
    return false;
  }

  double residual_at(double value) {
    u_[0] = value;
    evaluate();
    return residual_[0];
  }

  bool halve(double a, double b, double at_a) {
    for (int i = 0; i < 60; ++i) {
      const double middle = a + 0.5 * (b - a);
      const double value = residual_at(middle);
      if (std::isfinite(value) && (value < 0) == (at_a < 0)) {
        a = middle;
      } else {
        b = middle;
      }
    }
    u_[0] = a + 0.5 * (b - a);
    return newton();
  }

  [[noreturn]] void fail() {
    const double time = arena_[frame_.program->time];
    std::string text =
        fmt::format("at time {:g} s no values are found that satisfy the algebraic loop {}", time, loop_.path);
    if (loop_.affine || !std::isfinite(nearest_norm_)) {
      std::string names;
      for (const std::string& name : loop_.names) names += (names.empty() ? "'" : ", '") + name + "'";
      text += loop_.affine
                  ? fmt::format("\n  its equations are linear and hold for many values of {}, or for none", names)
                  : fmt::format("\n  its equations are not finite where the search for {} begins", names);
    } else {
      constexpr std::size_t most_shown = 3;
      for (std::size_t i = 0; i < std::min(n_, most_shown); ++i) {
        text += fmt::format("\n  the nearest try: '{}' = {:g}, where its equation is off by {:g}", loop_.names[i],
                            nearest_[i], nearest_residual_[i]);
      }
    }
    text += remedies;
    const std::string& place = frame_.program->sites[loop_.site].path;
    throw LoopError(text, time, place);
  }

  static constexpr double infinity = std::numeric_limits<double>::infinity();
  static constexpr SlotIndex no_bound = 0xffffffff;

  const Program::Loop& loop_;
  double* arena_;
  KernelFrame& frame_;
  std::size_t n_;
  std::span<double> u_, accepted_;
  double* has_factors_ = nullptr;  // 1: those of the present parameters stand in factors_
  std::span<double> factors_, rows_, residual_, step_, correction_, before_, nearest_, nearest_residual_, last_;
  double nearest_norm_ = infinity;
};

}  // namespace

std::size_t loop_room(std::size_t n) { return Search::room(n); }

void reset_loops(const Program& program, double* arena, KernelFrame& frame) {
  for (const Program::Loop& loop : program.loops) {
    frame.loop_room[loop.first_room] = 0;
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const bool given = i < loop.guess.size() && loop.guess[i] != 0xffffffff;
      frame.loop_values[loop.first_value + i] = given ? arena[loop.guess[i]] : 0;
    }
  }
  for (const Program::Pivot& pivot : program.pivots) {
    if (arena[pivot.slot] != 0 && std::isfinite(arena[pivot.slot])) continue;
    throw LoopError(fmt::format("the equations of the algebraic loop {} hold for many values, or for none: with these "
                                "parameters all that goes round in it cancels",
                                pivot.path),
                    std::numeric_limits<double>::quiet_NaN(), program.sites[pivot.site].path);
  }
}

void solve_loop(const Program::Loop& loop, double* arena, KernelFrame& frame) { Search(loop, arena, frame).run(); }

void accept_loops(const Program& program, const double* arena, KernelFrame& frame) {
  for (const Program::Loop& loop : program.loops) {
    if (loop.initial) continue;
    std::copy_n(arena + loop.unknowns, loop.size(), frame.loop_values + loop.first_value);
  }
}

}  // namespace plantloop
