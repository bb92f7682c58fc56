// A diagram's lists run in the caller's room: the arena is copied there, and what is stepped stands in it.

#include "control/diagram_predictor.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <memory>

#include "engine/base/error.h"
#include "engine/program/affine.h"
#include "engine/program/resolve.h"
#include "engine/program/solve_loop.h"

namespace plantloop {

// What is found wrong
// --------------------------------------------------------------------------------------------------

std::shared_ptr<const DiagramPredictor> DiagramPredictor::make(const DiagramUse& use, std::string& error) {
  const auto wrong = [&](const Report& report) {
    for (const Finding& finding : report.findings()) {
      if (finding.severity == Severity::error)
        return fmt::format("the diagram '{}' is wrong: {}", use.path, finding.message);
    }
    return fmt::format("the diagram '{}' is wrong", use.path);
  };
  Report report;
  const std::shared_ptr<const Model> model = read_model(use.path, report);
  if (!model || report.has_errors()) return error = wrong(report), nullptr;
  auto predictor = std::shared_ptr<DiagramPredictor>(new DiagramPredictor);
  predictor->use_ = use;
  for (const auto& source : model->sources) predictor->sources_.emplace_back(source->name, source->text);
  std::vector<std::string> watched = use.outputs;
  watched.insert(watched.end(), use.inputs.begin(), use.inputs.end());
  predictor->linear_ = make_linear_program(model, {}, use.inputs, {}, watched, report);
  if (!predictor->linear_ || report.has_errors()) return error = wrong(report), nullptr;
  try {
    predictor->linear_->go_to(std::nullopt);
    return predictor->look_at(error) ? predictor : nullptr;
  } catch (const RunError& failed) {
    error = fmt::format("the diagram '{}' has no start: {}", use.path, failed.what());
    return nullptr;
  }
}

bool DiagramPredictor::look_at(std::string& error) {
  LinearProgram& linear = *linear_;
  program_ = linear.program.get();
  const auto no = [&](const std::string& why) {
    error = fmt::format("the diagram '{}' cannot be predicted with: {}", use_.path, why);
    return false;
  };
  if (linear.probes.size() != use_.inputs.size() || linear.outputs.size() != use_.inputs.size() + use_.outputs.size())
    return no("inputs and outputs must be single numbers; name the elements of a vector, as in x.2");
  for (const Program::KernelState& kernel : program_->kernels) {
    if (kernel.kernel->state_size() > 0 || kernel.kernel->histories() > 0)
      return no(fmt::format("block '{}' remembers more than states, as delays do", program_->sites[kernel.site].path));
  }
  if (!program_->linear.missing.empty())
    return no(fmt::format("the derivative of block '{}' is not known", program_->linear.missing.front()));
  for (const Program::Jump& jump : program_->jumps) {
    if (!jump.of_kernel) return no(fmt::format("'{}' changes states at events", jump.name));
  }
  const std::size_t continuous = program_->state_names.size(), sampled = program_->discretes.size();
  if (continuous > 0 && program_->rates.size() > 1) return no("it has continuous and sampled parts");
  if (program_->rates.size() > 2) return no("it has more than one rate");
  if (continuous + sampled == 0) return no("it has no states");
  names_ = continuous > 0 ? program_->state_names : program_->discrete_names;
  states_ = static_cast<int>(names_.size());
  if (sampled > 0) period_ = linear.pattern.period;
  partials_ = sampled > 0 ? &program_->linear.hits.front() : &program_->linear.flow;
  if (!sort_entries(*partials_, sampled > 0 ? program_->linear.held_masks.size() : 0, error)) return false;

  is_affine_ = find_affine();

  linear.evaluate_outputs();
  for (std::size_t i = 0; i < use_.inputs.size(); ++i) base_.push_back(linear.output(use_.outputs.size() + i));
  // A hit at the start has updated sampled states already.
  for (std::size_t i = 0; i < names_.size(); ++i)
    start_.push_back(linear.frame->arena[period_ > 0 ? program_->initial_list.roots[continuous + i]
                                                     : state_slot(static_cast<int>(i))]);
  return true;
}

// Whether states and outputs at the next sample are affine in states and inputs: so are those of all samples then.
bool DiagramPredictor::find_affine() const {
  if (!program_->modes.empty()) return false;
  const Resolved& resolved = *program_->resolved;
  std::vector<std::uint32_t> roots = period_ > 0 ? resolved.nexts : resolved.derivatives;
  roots.insert(roots.end(), resolved.watches.begin(),
               resolved.watches.begin() + static_cast<std::ptrdiff_t>(use_.outputs.size()));
  return are_affine(resolved.graph, roots, [&](const Operation& o) {
    if (o.op == Op::state || o.op == Op::discrete) return true;
    return o.op == Op::parameter && std::any_of(linear_->probes.begin(), linear_->probes.end(),
                                                [&](const auto& probe) { return probe.parameter == o.a; });
  });
}

// Puts the partial derivatives in their places, and says what may not depend on what. Rows before `first_row` are held
// values.
bool DiagramPredictor::sort_entries(const Program::PartialList& partials, std::size_t first_row, std::string& error) {
  const Sensitivity size = linear_->size();
  const auto no = [&](const std::string& why) {
    error = fmt::format("the diagram '{}' cannot be predicted with: {}", use_.path, why);
    return false;
  };
  const auto states = static_cast<std::uint32_t>(states_);
  for (std::size_t k = 0; k < partials.row.size(); ++k) {
    if (partials.row[k] < first_row) continue;
    const std::uint32_t row = partials.row[k] - static_cast<std::uint32_t>(first_row), column = partials.column[k];
    const SlotIndex slot = partials.list.roots[k];
    const bool by_state = column < size.first_probe();
    const bool by_input = !by_state && column < size.first_held();
    if (row >= states + use_.outputs.size()) {
      if (by_state)
        return no(fmt::format("the input '{}' depends on its states", use_.inputs[row - states - use_.outputs.size()]));
      continue;
    }
    if (!by_state && !by_input) {
      return no(column == size.columns() - 1 ? "it depends on the time, which stands still in a prediction"
                                             : "it holds values between events");
    }
    if (row < states) {
      if (by_state) by_states_.push_back({row, column, slot});
      if (by_input) by_inputs_.push_back({row, column - static_cast<std::uint32_t>(size.first_probe()), slot});
    } else if (by_state) {
      outputs_by_states_.push_back({row - states, column, slot});
    } else {
      return no(fmt::format("the output '{}' depends at once on the input, so it is no prediction",
                            use_.outputs[row - states]));
    }
  }
  if (by_inputs_.empty()) return no("its states do not depend on the input");
  return true;
}

// Running
// --------------------------------------------------------------------------------------------------------------

struct DiagramPredictor::Work {
  double *arena, *kernels, *scratch, *loop_values, *loops_before, *loop_room, *x, *stage, *f, *sum, *X, *stage_slopes,
      *F, *sum_slopes, *first;
  KernelFrame frame;
  std::size_t size;
};

namespace {

std::size_t padded(std::size_t count) { return count + 8; }

}  // namespace

DiagramPredictor::Work DiagramPredictor::begin(double* room, int variables) const {
  const Frame& from = *linear_->frame;
  const auto n = static_cast<std::size_t>(states_), v = static_cast<std::size_t>(variables);
  Room parts(room);
  Work w{};
  w.first = parts.take(2 * n);  // where the last prediction began
  w.arena = parts.take(padded(program_->arena.size()));
  w.kernels = parts.take(from.kernel_states.size());
  w.scratch = parts.take(from.scratch.size());
  w.loop_values = parts.take(from.loop_values.size());
  w.loops_before = parts.take(from.loop_values.size());
  w.loop_room = parts.take(from.loop_room.size());
  w.x = parts.take(n);
  w.stage = parts.take(n);
  w.f = parts.take(n);
  w.sum = parts.take(n);
  w.X = parts.take(n * v);
  w.stage_slopes = parts.take(n * v);
  w.F = parts.take(n * v);
  w.sum_slopes = parts.take(n * v);
  w.size = parts.taken();
  if (room == nullptr) return w;
  void* begin = w.arena;
  std::size_t space = padded(program_->arena.size()) * sizeof(double);
  w.arena = static_cast<double*>(std::align(64, program_->arena.size() * sizeof(double), begin, space));
  std::copy_n(from.arena, program_->arena.size(), w.arena);
  std::copy(from.kernel_states.begin(), from.kernel_states.end(), w.kernels);
  std::copy(from.loop_values.begin(), from.loop_values.end(), w.loop_values);
  std::copy(from.loop_room.begin(), from.loop_room.end(), w.loop_room);
  w.frame.program = program_;
  w.frame.states = w.kernels;
  w.frame.scratch = w.scratch;
  w.frame.loop_values = w.loop_values;
  w.frame.loop_room = w.loop_room;
  w.frame.left = true;
  return w;
}

std::size_t DiagramPredictor::room(int, int variables) const { return begin(nullptr, variables).size; }

SlotIndex DiagramPredictor::state_slot(int i) const {
  return period_ > 0 ? program_->discretes[static_cast<std::size_t>(i)] : program_->states + static_cast<SlotIndex>(i);
}

// What is hoisted out of the run, since it depends on parameters only, depends on the inputs here.
void DiagramPredictor::set_inputs(Work& w, const double* u) const {
  for (std::size_t i = 0; i < base_.size(); ++i)
    w.arena[program_->parameters[linear_->probes[i].parameter]] = u[i] - base_[i];
  execute(program_->parameter_list, w.arena, &w.frame);
  if (program_->loops.empty()) return;
  // What loops kept of their equations is of other parameters, but their last values are good to begin with.
  const std::size_t count = linear_->frame->loop_values.size();
  std::copy_n(w.loop_values, count, w.loops_before);
  reset_loops(*program_, w.arena, w.frame);
  std::copy_n(w.loops_before, count, w.loop_values);
}

void DiagramPredictor::follow_modes(Work& w) const {
  if (program_->modes.empty()) return;
  constexpr int most = 10;  // modes that depend on modes
  bool changed = true;
  for (int pass = 0; changed && pass < most; ++pass) {
    changed = false;
    execute(program_->held_list, w.arena, &w.frame, event_bit);
    execute(program_->mode_list, w.arena, &w.frame);
    for (std::size_t m = 0; m < program_->modes.size(); ++m) {
      const double now = w.arena[program_->mode_list.roots[m]];
      double& mode = w.arena[program_->modes[m]];
      changed = changed || mode != now;
      mode = now;
    }
  }
}

// x' of a continuous diagram, x of the next sample of a sampled one.
void DiagramPredictor::derivatives(Work& w, const double* x, double* f) const {
  for (int i = 0; i < states_; ++i) w.arena[state_slot(i)] = x[i];
  if (period_ > 0) {
    execute(program_->held_list, w.arena, &w.frame, rate_bit(1));
    for (int i = 0; i < states_; ++i) f[i] = w.arena[program_->nexts[static_cast<std::size_t>(i)]];
    return;
  }
  follow_modes(w);
  execute(program_->derivative_list, w.arena, &w.frame);
  std::copy_n(w.arena + program_->derivative_list.roots.front(), states_, f);
}

void DiagramPredictor::look(Work& w, const double* x, double* y) const {
  assert(w.arena != nullptr);
  for (int i = 0; i < states_; ++i) w.arena[state_slot(i)] = x[i];
  if (period_ > 0) execute(program_->held_list, w.arena, &w.frame, rate_bit(1));
  if (period_ == 0) follow_modes(w);
  execute(program_->watch_list, w.arena, &w.frame);
  for (int o = 0; o < outputs(); ++o) y[o] = w.arena[program_->watch_list.roots[static_cast<std::size_t>(o)]];
  accept_loops(*program_, w.arena, w.frame);
}

void DiagramPredictor::step(Work& w, const double* u, double* x) const {
  set_inputs(w, u);
  if (period_ > 0) {
    derivatives(w, x, w.f);
    std::copy_n(w.f, states_, x);
    return;
  }
  const double h = use_.Ts / use_.substeps;
  for (int k = 0; k < use_.substeps; ++k) {
    derivatives(w, x, w.f);
    std::copy_n(w.f, states_, w.sum);
    for (const double weight : {2.0, 2.0, 1.0}) {
      const double ahead = weight == 1.0 ? h : 0.5 * h;
      for (int i = 0; i < states_; ++i) w.stage[i] = x[i] + ahead * w.f[i];
      derivatives(w, w.stage, w.f);
      for (int i = 0; i < states_; ++i) w.sum[i] += weight * w.f[i];
    }
    for (int i = 0; i < states_; ++i) x[i] += h / 6 * w.sum[i];
  }
}

void DiagramPredictor::add_slopes(const Work& w, const std::vector<Entry>& entries, const double* by, int variables,
                                  double* to) const {
  for (const Entry& e : entries) {
    const double slope = w.arena[e.slot];
    if (slope == 0) continue;
    const double* const from = by + e.column * static_cast<std::uint32_t>(variables);
    double* const row = to + e.row * static_cast<std::uint32_t>(variables);
    for (int v = 0; v < variables; ++v) row[v] += slope * from[v];
  }
}

// The same step, and the derivative of the very steps that are taken: X of x by the variables.
void DiagramPredictor::step_with_slopes(Work& w, const double* u, const double* by_u, int variables, double* x,
                                        double* X) const {
  set_inputs(w, u);
  const int all = states_ * variables;
  const auto slopes = [&](const double* at, const double* at_slopes) {
    derivatives(w, at, w.f);
    if (!partials_->list.empty()) execute(partials_->list, w.arena, &w.frame);
    std::fill_n(w.F, all, 0.0);
    add_slopes(w, by_states_, at_slopes, variables, w.F);
    add_slopes(w, by_inputs_, by_u, variables, w.F);
  };
  if (period_ > 0) {
    slopes(x, X);
    std::copy_n(w.f, states_, x);
    std::copy_n(w.F, all, X);
    return;
  }
  const double h = use_.Ts / use_.substeps;
  for (int k = 0; k < use_.substeps; ++k) {
    slopes(x, X);
    std::copy_n(w.f, states_, w.sum);
    std::copy_n(w.F, all, w.sum_slopes);
    for (const double weight : {2.0, 2.0, 1.0}) {
      const double ahead = weight == 1.0 ? h : 0.5 * h;
      for (int i = 0; i < states_; ++i) w.stage[i] = x[i] + ahead * w.f[i];
      for (int i = 0; i < all; ++i) w.stage_slopes[i] = X[i] + ahead * w.F[i];
      slopes(w.stage, w.stage_slopes);
      for (int i = 0; i < states_; ++i) w.sum[i] += weight * w.f[i];
      for (int i = 0; i < all; ++i) w.sum_slopes[i] += weight * w.F[i];
    }
    for (int i = 0; i < states_; ++i) x[i] += h / 6 * w.sum[i];
    for (int i = 0; i < all; ++i) X[i] += h / 6 * w.sum_slopes[i];
  }
}

// A point at which an equation has no solution is one that no prediction reaches.
void DiagramPredictor::predict(const double* state, const double* u, int horizon, bool with_extras, double* signals,
                               double* room) const {
  Work w = begin(room, 0);
  std::copy_n(state, 2 * states_, w.first);
  std::copy_n(state, states_, w.x);
  try {
    for (int j = 0; j < horizon; ++j) {
      double* const to = signals + j * this->signals();
      step(w, u + j * inputs(), w.x);
      for (int i = 0; i < states_; ++i) w.x[i] += w.first[states_ + i];
      look(w, w.x, to);
      if (with_extras) std::copy_n(w.x, states_, to + outputs());
    }
  } catch (const RunError&) {
    std::fill_n(signals, horizon * this->signals(), std::numeric_limits<double>::quiet_NaN());
  }
}

void DiagramPredictor::sensitivities(const double* u, int horizon, bool with_extras, const double* by_variables,
                                     int variables, double* result, double* room) const {
  Work w = begin(room, variables);
  std::copy_n(w.first, states_, w.x);
  std::fill_n(w.X, states_ * variables, 0.0);
  for (int j = 0; j < horizon; ++j) {
    double* const rows = result + j * signals() * variables;
    step_with_slopes(w, u + j * inputs(), by_variables + j * inputs() * variables, variables, w.x, w.X);
    for (int i = 0; i < states_; ++i) w.x[i] += w.first[states_ + i];
    derivatives(w, w.x, w.f);
    if (!partials_->list.empty()) execute(partials_->list, w.arena, &w.frame);
    std::fill_n(rows, outputs() * variables, 0.0);
    add_slopes(w, outputs_by_states_, w.X, variables, rows);
    if (with_extras) std::copy_n(w.X, states_ * variables, rows + outputs() * variables);
    accept_loops(*program_, w.arena, w.frame);
  }
}

void DiagramPredictor::output(const double* state, double* y, double* room) const {
  Work w = begin(room, 0);
  look(w, state, y);
}

void DiagramPredictor::advance(const double* state, const double* u, double* next, double* room) const {
  Work w = begin(room, 0);
  std::copy_n(state, states_, next);
  step(w, u, next);
}

void DiagramPredictor::start(const double*, const double*, double* state) const {
  std::copy(start_.begin(), start_.end(), state);
}

}  // namespace plantloop
