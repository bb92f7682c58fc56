// Unknowns: states, discrete states, probes. Equations: derivatives and changes are zero, outputs are as wanted.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engine/analysis/trim_point.h"
#include "engine/program/resolve.h"

namespace plantloop {

namespace {

constexpr int most_iterations = 200;
constexpr double at_rest = 1e-12;  // of the residuals, relative to 1 + |value|

class Newton {
 public:
  Newton(LinearProgram& program, const TrimPoint& point)
      : p_(program), point_(point), size_(program.size()), n_(size_.states + size_.discretes + point.probes.size()) {
    lower_.assign(n_, -unbounded);
    upper_.assign(n_, unbounded);
    for (const TrimPoint::Bound& b : point.states) lower_[b.index] = b.lower, upper_[b.index] = b.upper;
    for (const auto& [index, value] : point.fixed) lower_[index] = upper_[index] = value;
  }

  Trim run() {
    take(clamped(unknowns()));
    Trim result;
    double damping = 1e-3;
    std::vector<double> f = residuals();
    double cost = norm(f);
    for (result.iterations = 0; result.iterations < most_iterations && largest(f) > at_rest; ++result.iterations) {
      const DenseMatrix jacobian = this->jacobian();
      const std::vector<double> x = unknowns();
      bool better = false;
      for (int attempt = 0; attempt < 30 && !better; ++attempt) {
        const std::vector<double> step =
            attempt == 0 ? newton_step(jacobian, f, x) : damped_step(jacobian, f, x, damping);
        std::vector<double> next = x;
        for (std::size_t i = 0; i < n_; ++i) next[i] += step[i];
        take(clamped(next));
        const std::vector<double> f_next = residuals();
        const double cost_next = norm(f_next);
        if (cost_next < cost) {
          better = true;
          f = f_next;
          cost = cost_next;
          damping = std::max(damping / 10, 1e-12);
        } else if (attempt > 0) {
          damping *= 10;
        }
      }
      if (!better) {
        take(x);
        f = residuals();
        break;
      }
    }
    describe(result, f);
    return result;
  }

 private:
  std::vector<double> unknowns() const {
    const Program& program = *p_.program;
    std::vector<double> x(p_.frame->states(), p_.frame->states() + size_.states);
    for (const auto slot : program.discretes) x.push_back(p_.frame->arena[slot]);
    for (const TrimPoint::Bound& b : point_.probes) x.push_back(p_.frame->arena[probe_slot(b.index)]);
    return x;
  }

  SlotIndex probe_slot(std::size_t probe) const { return p_.program->parameters[p_.probes[probe].parameter]; }

  std::vector<double> clamped(std::vector<double> x) const {
    for (std::size_t i = 0; i < n_; ++i) x[i] = std::clamp(x[i], lower_[i], upper_[i]);
    return x;
  }

  // Everything at one instant: all that is sampled is sampled now, modes as the values say.
  void take(const std::vector<double>& x) {
    const Program& program = *p_.program;
    Frame& frame = *p_.frame;
    std::copy(x.begin(), x.begin() + static_cast<std::ptrdiff_t>(size_.states), frame.states());
    for (std::size_t d = 0; d < size_.discretes; ++d) frame.arena[program.discretes[d]] = x[size_.states + d];
    for (std::size_t i = 0; i < point_.probes.size(); ++i)
      frame.arena[probe_slot(point_.probes[i].index)] = x[size_.states + size_.discretes + i];
    KernelFrame kernels = frame.kernel_frame(false);
    execute(program.parameter_list, frame.arena);
    constexpr int most_passes = 20;
    for (int pass = 0; pass < most_passes; ++pass) {
      execute(program.held_list, frame.arena, &kernels);
      if (program.modes.empty()) break;
      execute(program.mode_list, frame.arena, &kernels);
      bool changed = false;
      for (std::size_t m = 0; m < program.modes.size(); ++m) {
        const double now = frame.arena[program.mode_list.roots[m]];
        changed = changed || (now != frame.arena[program.modes[m]] && !std::isnan(now));
        frame.arena[program.modes[m]] = now;
      }
      if (!changed) break;
    }
    if (!program.derivative_list.empty()) execute(program.derivative_list, frame.arena, &kernels);
    p_.evaluate_outputs();
  }

  // Derivatives, changes of discrete states, outputs and wires beyond their bounds.
  std::vector<double> residuals() const {
    const Program& program = *p_.program;
    const Frame& frame = *p_.frame;
    std::vector<double> f;
    for (std::size_t i = 0; i < size_.states; ++i) f.push_back(frame.arena[program.derivative_list.roots[i]]);
    for (std::size_t d = 0; d < size_.discretes; ++d)
      f.push_back(frame.arena[program.nexts[d]] - frame.arena[program.discretes[d]]);
    for (const auto& [watch, wanted] : point_.outputs) f.push_back(p_.output(watch) - wanted);
    for (std::size_t i = 0; i < point_.probes.size(); ++i) f.push_back(beyond(i));
    for (double& v : f) {
      if (!std::isfinite(v)) v = 1e300;
    }
    return f;
  }

  // How far the wire of a probe is outside of its bounds.
  double beyond(std::size_t i) const {
    if (i >= point_.probe_outputs.size()) return 0;
    const double value = p_.output(point_.probe_outputs[i]);
    return value - std::clamp(value, point_.probes[i].lower, point_.probes[i].upper);
  }

  DenseMatrix jacobian() {
    const Program& program = *p_.program;
    const std::size_t watches = program.watch_list.roots.size();
    // With everything sampled now, nothing is held: the set of all rates.
    const DenseMatrix flow = p_.evaluate(program.linear.flow, size_.states + watches);
    DenseMatrix hits(size_.held + size_.discretes + watches, size_.columns());
    if (!p_.pattern.sets.empty()) hits = p_.evaluate(program.linear.hits.back(), hits.rows);
    DenseMatrix j(size_.states + size_.discretes + point_.outputs.size() + point_.probes.size(), n_);
    const auto column_of = [&](std::size_t c) {
      return c < size_.states + size_.discretes
                 ? c
                 : size_.first_probe() + point_.probes[c - size_.states - size_.discretes].index;
    };
    for (std::size_t c = 0; c < n_; ++c) {
      const std::size_t column = column_of(c);
      // What a row reads of held values goes through those values' own rows.
      const auto total = [&](const DenseMatrix& m, std::size_t row) {
        double sum = m(row, column);
        for (std::size_t h = 0; h < size_.held; ++h) {
          const double part = m(row, size_.first_held() + h);
          if (part != 0) sum += part * hits(h, column);
        }
        return sum;
      };
      std::size_t row = 0;
      for (std::size_t i = 0; i < size_.states; ++i) j(row++, c) = total(flow, i);
      for (std::size_t d = 0; d < size_.discretes; ++d)
        j(row++, c) = hits(size_.held + d, column) - (c == size_.states + d ? 1 : 0);
      for (const auto& [watch, wanted] : point_.outputs) j(row++, c) = total(flow, size_.states + watch);
      for (std::size_t i = 0; i < point_.probes.size(); ++i)
        j(row++, c) = beyond(i) != 0 ? total(flow, size_.states + point_.probe_outputs[i]) : 0;
    }
    for (double& v : j.values) {
      if (!std::isfinite(v)) v = 0;
    }
    return j;
  }

  // Unknowns at a bound that the step would cross do not take part.
  std::vector<double> step_within(const std::vector<double>& x, DenseMatrix j, const std::vector<double>& f,
                                  double damping) {
    std::vector<double> step(n_, 0.0), minus(f.size());
    std::transform(f.begin(), f.end(), minus.begin(), [](double v) { return -v; });
    for (std::size_t pass = 0; pass <= n_; ++pass) {
      if (damping > 0) {
        std::vector<double> scale(n_);
        for (std::size_t i = 0; i < n_; ++i) {
          double length = 0;
          for (std::size_t r = 0; r < j.rows; ++r) length = std::hypot(length, j(r, i));
          scale[i] = std::sqrt(damping) * std::max(length, 1e-8);
        }
        step = damped_least_squares(j, scale, minus);
      } else {
        step = least_squares(j, minus);
      }
      bool blocked = false;
      for (std::size_t i = 0; i < n_; ++i) {
        const bool out = (x[i] <= lower_[i] && step[i] < 0) || (x[i] >= upper_[i] && step[i] > 0);
        if (!out) continue;
        blocked = true;
        for (std::size_t r = 0; r < j.rows; ++r) j(r, i) = 0;
        step[i] = 0;
      }
      if (!blocked) break;
    }
    return step;
  }
  std::vector<double> newton_step(const DenseMatrix& j, const std::vector<double>& f, const std::vector<double>& x) {
    return step_within(x, j, f, 0);
  }
  std::vector<double> damped_step(const DenseMatrix& j, const std::vector<double>& f, const std::vector<double>& x,
                                  double damping) {
    return step_within(x, j, f, damping);
  }

  static double norm(const std::vector<double>& f) {
    double sum = 0;
    for (const double v : f) sum = std::hypot(sum, v);
    return sum;
  }

  double largest(const std::vector<double>& f) const {
    const std::vector<double> x = unknowns();
    double worst = 0;
    for (std::size_t i = 0; i < f.size(); ++i) {
      const double value = i < size_.states + size_.discretes ? x[i] : 0;
      worst = std::max(worst, std::fabs(f[i]) / (1 + std::fabs(value)));
    }
    return worst;
  }

  void describe(Trim& result, const std::vector<double>& f) const {
    const Program& program = *p_.program;
    const std::vector<double> x = unknowns();
    for (std::size_t i = 0; i < size_.states; ++i) result.states.push_back({program.state_names[i], x[i], f[i]});
    for (std::size_t d = 0; d < size_.discretes; ++d)
      result.states.push_back({program.discrete_names[d], x[size_.states + d], f[size_.states + d]});
    std::size_t at = size_.states + size_.discretes;
    for (const auto& [watch, wanted] : point_.outputs)
      result.outputs.push_back({p_.outputs[watch], p_.output(watch), f[at++]});
    for (std::size_t i = 0; i < point_.probes.size(); ++i) {
      const double value = i < point_.probe_outputs.size() ? p_.output(point_.probe_outputs[i]) : NAN;
      result.inputs.push_back({p_.probes[point_.probes[i].index].name, value, f[at++]});
    }
    result.largest_residual = largest(f);
    result.converged = result.largest_residual < 1e-9;
    if (result.converged) {
      result.why = "at rest";
      return;
    }
    std::size_t worst = 0;
    for (std::size_t i = 0; i < f.size(); ++i) {
      if (std::fabs(f[i]) > std::fabs(f[worst])) worst = i;
    }
    const std::size_t states = size_.states + size_.discretes;
    result.why = worst < states ? fmt::format("'{}' still changes by {:g}{}", result.states[worst].path, f[worst],
                                              worst < size_.states ? " per second" : " at each hit")
                                : fmt::format("an output or input is {:g} away from where it must be", f[worst]);
  }

  LinearProgram& p_;
  const TrimPoint& point_;
  Sensitivity size_;
  std::size_t n_;
  std::vector<double> lower_, upper_;
};

}  // namespace

Trim go_to_rest(LinearProgram& program, const TrimPoint& point) { return Newton(program, point).run(); }

std::optional<Trim> trim(const std::shared_ptr<const Model>& model, const TrimRequest& request, Report& report) {
  std::vector<std::string> inputs, outputs;
  for (const auto& [path, wanted] : request.outputs) outputs.push_back(path);
  for (const TrimRequest::Free& free : request.inputs) {
    inputs.push_back(free.path);
    outputs.push_back(free.path);  // to see the wire's value
  }
  const auto p = make_linear_program(model, request.set, inputs, {}, outputs, report);
  if (!p) return std::nullopt;
  if (p->outputs.size() != outputs.size()) {
    report.error({}, "a trim is about single numbers: name the elements of a vector, as x.1");
    return std::nullopt;
  }
  TrimPoint point;
  for (std::size_t i = 0; i < request.outputs.size(); ++i) point.outputs.emplace_back(i, request.outputs[i].second);
  for (std::size_t i = 0; i < request.inputs.size(); ++i) {
    point.probes.push_back({i, request.inputs[i].lower, request.inputs[i].upper});
    point.probe_outputs.push_back(request.outputs.size() + i);
  }
  const Program& program = *p->program;
  std::vector<std::string> states = program.state_names;
  states.insert(states.end(), program.discrete_names.begin(), program.discrete_names.end());
  const auto state_of = [&](const std::string& path) -> std::optional<std::size_t> {
    const auto at = std::find(states.begin(), states.end(), path);
    if (at != states.end()) return static_cast<std::size_t>(at - states.begin());
    report.error({}, "there is no state '{}'", path).suggest(path, states);
    return std::nullopt;
  };
  for (const auto& [path, value] : request.fixed) {
    if (const auto s = state_of(path)) point.fixed.emplace_back(*s, value);
  }
  for (const TrimRequest::Free& free : request.states) {
    if (const auto s = state_of(free.path)) point.states.push_back({*s, free.lower, free.upper});
  }
  if (report.has_errors()) return std::nullopt;
  p->go_to(request.at);
  return go_to_rest(*p, point);
}

}  // namespace plantloop
