// Evaluates the operations below a root one by one, and follows what is not finite down to where it was born.

#include "engine/run/blame.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "engine/program/resolve.h"

namespace plantloop {

namespace {

double leaf_value(const Frame& frame, const Operation& o) {
  const Program& p = *frame.program;
  switch (o.op) {
    case Op::parameter:
      return frame.arena[p.parameters[o.a]];
    case Op::time:
      return frame.arena[p.time];
    case Op::state:
      return frame.arena[p.states + p.place_of_state[o.a]];
    case Op::discrete:
      return frame.arena[p.discretes[o.a]];
    case Op::mode:
      return frame.arena[p.modes[o.a]];
    case Op::segment:
      return frame.arena[p.segments[o.a]];
    case Op::hit:
      return frame.arena[p.hits[o.a]];
    default:
      return 0;
  }
}

std::string in_words(Op op, double a, double b) {
  switch (op) {
    case Op::div:
      return fmt::format("{:g} / {:g}", a, b);
    case Op::mul:
      return fmt::format("{:g} * {:g}", a, b);
    case Op::add:
      return fmt::format("{:g} + {:g}", a, b);
    case Op::sub:
      return fmt::format("{:g} - {:g}", a, b);
    case Op::pow:
      return fmt::format("{:g} ^ {:g}", a, b);
    default:
      return arity_of(op) == 1 ? fmt::format("{}({:g})", name_of(op), a)
                               : fmt::format("{}({:g}, {:g})", name_of(op), a, b);
  }
}

// " in block 'x' (file:line:column)"
std::string place_of(const Frame& frame, std::uint32_t site) {
  const Site& s = frame.program->sites[site];
  if (s.path.empty()) return {};
  std::string text = fmt::format(" in block '{}'", s.path);
  if (s.mark.source != nullptr) text += fmt::format(" ({})", to_string(s.mark));
  return text;
}

const std::string& path_of(const Frame& frame, std::uint32_t site) { return frame.program->sites[site].path; }

struct Origin {
  std::string text;  // " ... in block 'x' (file:line:column)"
  std::string place;
};

// What is below a root, with the value of each operation by the frame's present leaves. Kernels are asked again, in a
// copy of the frame.
class Values {
 public:
  Values(const Frame& frame, std::uint32_t root)
      : frame_(frame), graph_(frame.program->resolved->graph), value_(graph_.operations.size(), 0) {
    std::vector<std::uint32_t> below, stack{root};
    std::vector<bool> seen(graph_.operations.size(), false);
    while (!stack.empty()) {
      const std::uint32_t id = stack.back();
      stack.pop_back();
      if (seen[id]) continue;
      seen[id] = true;
      below.push_back(id);
      for (const auto operand : operands(id)) stack.push_back(operand);
    }
    std::sort(below.begin(), below.end());
    for (const auto id : below) value_[id] = evaluate(id);
  }

  double operator[](std::uint32_t id) const { return value_[id]; }

  // The operations that one reads; of a `where` its condition and the side that it takes.
  std::vector<std::uint32_t> read_by(std::uint32_t id) const {
    const Operation& o = graph_.operations[id];
    if (o.op == Op::where) return {o.a, value_[o.a] != 0 ? o.b : o.c};
    return operands(id);
  }

 private:
  std::vector<std::uint32_t> operands(std::uint32_t id) const {
    const Operation& o = graph_.operations[id];
    if (is_leaf(o.op)) return {};
    if (o.op == Op::kernel) return graph_.kernels[o.a].inputs;
    if (o.op == Op::loop) return graph_.operands_of_compound(id);
    if (is_result(o.op)) return {o.a};
    const int arity = arity_of(o.op);
    if (arity == 1) return {o.a};
    if (arity == 2) return {o.a, o.b};
    return {o.a, o.b, o.c};
  }

  double evaluate(std::uint32_t id) {
    const Operation& o = graph_.operations[id];
    if (o.op == Op::constant) return graph_.constant(id);
    if (is_leaf(o.op)) return leaf_value(frame_, o);
    if (o.op == Op::loop) return 0;
    if (o.op == Op::unknown) return frame_.arena[frame_.program->loops[graph_.operations[o.a].a].unknowns + o.b];
    if (o.op == Op::kernel) {
      outputs_[id] = outputs_of(graph_.kernels[o.a]);
      return 0;
    }
    if (o.op == Op::kernel_output) return outputs_[o.a][o.b];
    const int arity = arity_of(o.op);
    return apply(o.op, value_[o.a], arity > 1 ? value_[o.b] : 0, arity > 2 ? value_[o.c] : 0);
  }

  std::vector<double> outputs_of(const KernelUse& use) {
    if (!copy_) copy_.emplace(frame_);
    const Program::KernelState& own = frame_.program->kernels[use.index];
    std::vector<double> in, out(static_cast<std::size_t>(use.kernel->outputs()));
    std::vector<double> scratch(static_cast<std::size_t>(use.kernel->scratch_size()) + 1);
    for (const auto input : use.inputs) in.push_back(value_[input]);
    KernelCall call;
    call.time = frame_.arena[frame_.program->time];
    call.in = in.data();
    call.out = out.data();
    call.state = copy_->kernel_states.data() + own.first_state;
    call.scratch = scratch.data();
    call.history = copy_->histories.data() + own.first_history;
    use.kernel->evaluate(call);
    return out;
  }

  const Frame& frame_;
  const OperationGraph& graph_;
  std::vector<double> value_;
  std::map<std::uint32_t, std::vector<double>> outputs_;  // of kernels
  std::optional<Frame> copy_;
};

// From a root that is not finite down to the operation that is not, though all it reads is; sides that are not taken
// are not looked at. Uses the frame's present values.
Origin find_origin(const Frame& frame, std::uint32_t root) {
  const OperationGraph& graph = frame.program->resolved->graph;
  const Values value(frame, root);
  if (std::isfinite(value[root])) return {};
  std::uint32_t id = root;
  std::uint32_t reader = root;
  for (bool deeper = true; deeper;) {
    deeper = false;
    for (const auto operand : value.read_by(id)) {
      if (std::isfinite(value[operand])) continue;
      reader = id;
      id = operand;
      deeper = true;
      break;
    }
  }
  // A number stands in no block; what reads it does.
  const Operation& o = graph.operations[id];
  const std::uint32_t site = graph.operations[o.op == Op::constant ? reader : id].site;
  std::string what = "a number";
  if (o.op == Op::parameter) {
    what = fmt::format("the parameter '{}'", frame.program->parameter_info[o.a].name);
  } else if (o.op == Op::kernel_output) {
    what = fmt::format("the {}", graph.kernels[graph.operations[o.a].a].kernel->name());
  } else if (!is_leaf(o.op)) {
    what = in_words(o.op, value[o.a], arity_of(o.op) > 1 ? value[o.b] : 0);
  }
  return {fmt::format("it came from {}, which is {},", what, number_in_words(value[id])) + place_of(frame, site),
          path_of(frame, site)};
}

struct Beyond {
  Origin origin;
  std::string state;  // whose derivative is not finite
};

// A step may end in nothing because no derivative exists right behind its start: looks there, along the present slopes.
Beyond origin_beyond(const Frame& frame, double t) {
  const Program& program = *frame.program;
  Frame beyond(frame);
  const auto slopes_at = [&](double time) {
    beyond.arena[program.time] = time;
    KernelFrame kernels = beyond.kernel_frame(true);
    execute(program.derivative_list, beyond.arena, &kernels);
    return std::vector<double>(beyond.arena + program.derivative_list.roots.front(),
                               beyond.arena + program.derivative_list.roots.front() + beyond.state_count());
  };
  try {
    const std::vector<double> slope = slopes_at(t);
    const std::vector<double> start(beyond.states(), beyond.states() + beyond.state_count());
    for (double h = 1e-15; h < 1e-6; h *= 10) {
      const double ahead = h * std::fmax(1.0, std::fabs(t));
      for (std::size_t i = 0; i < start.size(); ++i) beyond.states()[i] = start[i] + ahead * slope[i];
      const std::vector<double> there = slopes_at(t + ahead);
      const auto bad = std::find_if(there.begin(), there.end(), [](double v) { return !std::isfinite(v); });
      if (bad == there.end()) continue;
      const auto place = static_cast<std::size_t>(bad - there.begin());
      return {find_origin(beyond, program.resolved->derivatives[program.state_at[place]]), program.state_names[place]};
    }
  } catch (const RunError&) {  // a loop without solution there
  }
  return {};
}

}  // namespace

std::string number_in_words(double value) {
  if (std::isnan(value)) return "not a number";
  if (std::isinf(value)) return value > 0 ? "infinite" : "minus infinite";
  return fmt::format("{:g}", value);
}

RunError not_finite(const Frame& frame, std::uint32_t root, const std::string& what, double t) {
  Origin origin = find_origin(frame, root);
  if (origin.text.empty()) {
    // Everything is finite now: the value grew beyond the largest number during the step.
    const std::uint32_t site = frame.program->resolved->graph.operations[root].site;
    origin = {"it grew without bound" + place_of(frame, site), path_of(frame, site)};
  }
  return RunError(fmt::format("at time {:g} s {}\n  {}", t, what, origin.text), t, origin.place);
}

RunError solver_failed(const Frame& frame, std::uint32_t derivative, const RunError& error, const std::string& number,
                       const std::string& state) {
  Origin origin = find_origin(frame, derivative);
  std::string text = error.what();
  const std::string name = fmt::format("state '{}'", state);
  if (const std::size_t at = text.find(number + ' '); at != std::string::npos) {
    text.replace(at, number.size(), name);
  } else {
    text += "\n  " + name;
  }
  if (!origin.text.empty()) {
    const bool said = text.find("is not finite") != std::string::npos;
    text += (said ? "\n  " : "\n  its derivative is not finite: ") + origin.text;
  } else if (Beyond beyond = origin_beyond(frame, error.time()); !beyond.origin.text.empty()) {
    text +=
        fmt::format("\n  right behind it the derivative of '{}' is not finite; {}", beyond.state, beyond.origin.text);
    origin = std::move(beyond.origin);
  }
  return RunError(text, error.time(), origin.place.empty() ? state : origin.place);
}

}  // namespace plantloop
