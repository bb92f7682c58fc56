// Text to recording: the arrows of the engine, one after the other, with compiled structures kept.

#include "engine/run/diagram.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <mutex>

#include "engine/base/numbers.h"
#include "engine/graph/check_units.h"
#include "engine/graph/unused.h"
#include "engine/program/resolve.h"
#include "engine/run/check_expect.h"
#include "engine/run/checkpoint.h"
#include "engine/run/expect.h"

namespace plantloop {

namespace {

double seconds() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

const SolverInfo* find_solver(std::string_view name) {
  for (const SolverInfo& info : solvers()) {
    if (info.name == name) return &info;
  }
  return nullptr;
}

}  // namespace

std::shared_ptr<Diagram> Diagram::load(const std::string& path, Report& report, const PlotWords& plots) {
  const double start = seconds();
  auto diagram = std::shared_ptr<Diagram>(new Diagram);
  diagram->model_ = read_model(path, report, plots);
  diagram->read_time_ = seconds() - start;
  return diagram->model_ ? diagram : nullptr;
}

std::shared_ptr<Diagram> Diagram::from_text(const std::string& text, const std::string& path, Report& report,
                                            const PlotWords& plots) {
  const double start = seconds();
  auto diagram = std::shared_ptr<Diagram>(new Diagram);
  diagram->model_ = read_model_text(text, path, report, plots);
  diagram->read_time_ = seconds() - start;
  return diagram->model_ ? diagram : nullptr;
}

namespace {

// The absolute tolerance where none is given: who asks for more digits wants them near zero, too.
double atol_for(double rtol) { return std::min(1e-9, 1e-3 * rtol); }

// The settings of `simulation:`, with what is wrong about them.
class Settings {
 public:
  Settings(const Model& model, const Graph& graph, Report& report)
      : decl_(model.simulation), graph_(graph), report_(report) {}

  SimulationOptions read() {
    SimulationOptions o;
    take(decl_.start, "start", o.start);
    take(decl_.stop, "stop", o.stop);
    if (decl_.stop && !(o.stop > o.start)) {
      report_.error(decl_.stop->mark, "the simulation stops at {} s, which is not after its start at {} s", o.stop,
                    o.start);
    }
    positive(decl_.step, "step", o.step);
    positive(decl_.rtol, "rtol", o.rtol);
    if (!positive(decl_.atol, "atol", o.atol)) o.atol = atol_for(o.rtol);
    positive(decl_.max_step, "max_step", o.max_step);
    positive(decl_.output_interval, "output_interval", o.output_interval);
    positive(decl_.event_tol, "event_tol", o.event_tol);
    double count = 0;
    if (positive(decl_.max_steps, "max_steps", count)) o.max_steps = static_cast<std::int64_t>(count);
    if (positive(decl_.max_rows, "max_rows", count)) o.max_rows = static_cast<std::int64_t>(count);
    o.solver = decl_.solver;
    o.zeno = decl_.zeno;
    return o;
  }

 private:
  bool take(const ExpressionPtr& expression, const char* name, double& into) {
    if (!expression) return false;
    const auto value = evaluate_scalar(graph_, *expression, name, report_);
    if (!value) return false;
    if (!std::isfinite(*value)) {
      report_.error(expression->mark, "'{}' is {}: it must be a finite number", name, *value);
      return false;
    }
    into = *value;
    return true;
  }
  bool positive(const ExpressionPtr& expression, const char* name, double& into) {
    double value = 0;
    if (!take(expression, name, value)) return false;
    if (!(value > 0)) {
      report_.error(expression->mark, "'{}' is {}: it must be greater than 0", name, value);
      return false;
    }
    into = value;
    return true;
  }

  const SimulationDecl& decl_;
  const Graph& graph_;
  Report& report_;
};

// What other tools call a solver, and what it is here.
std::string_view familiar_solver(std::string_view name) {
  constexpr std::pair<std::string_view, std::string_view> pairs[] = {{"ode45", "dopri5"},
                                                                     {"RK45", "dopri5"},
                                                                     {"ode23", "bogacki_shampine"},
                                                                     {"RK23", "bogacki_shampine"},
                                                                     {"ode4", "rk4"},
                                                                     {"ode2", "heun"},
                                                                     {"ode1", "euler"},
                                                                     {"ode15s", "bdf"},
                                                                     {"ode23t", "bdf"},
                                                                     {"ode23s", "bdf"},
                                                                     {"ode113", "adams"},
                                                                     {"BDF", "bdf"},
                                                                     {"LSODA", "adams, or bdf when it is stiff"},
                                                                     {"Radau", "bdf"},
                                                                     {"DOP853", "dopri5"},
                                                                     {"stiff", "bdf"},
                                                                     {"cvode", "adams, or bdf when it is stiff"}};
  for (const auto& [other, ours] : pairs) {
    if (other == name) return ours;
  }
  return {};
}

// The solver of that name; null after reporting that there is none.
const SolverInfo* find_solver(const std::string& name, const Mark& mark, Report& report) {
  if (const SolverInfo* info = find_solver(name)) return info;
  std::vector<std::string> names;
  for (const SolverInfo& s : solvers()) names.emplace_back(s.name);
  Finding& finding = report.error(mark, "there is no solver '{}'", name);
  if (const std::string_view ours = familiar_solver(name); !ours.empty()) finding.hint(fmt::format("take {}", ours));
  finding.suggest(name, names);
  return nullptr;
}

// A solver and a step that do not go together; `mark` is where the solver is named.
void check_solver(const SimulationOptions& options, const Mark& mark, Report& report) {
  const SolverInfo* info = find_solver(options.solver, mark, report);
  if (info == nullptr) return;
  if (options.step > 0 && !info->fixed) {
    report.error(mark, "solver '{}' chooses its own steps: leave 'step' out, or take rk4", options.solver);
  } else if (options.step <= 0 && !info->adaptive) {
    report.error(mark, "solver '{}' needs a step", options.solver).hint("for example step: 0.001");
  }
}

}  // namespace

SimulationOptions read_settings(const Model& model, const Graph& graph, Report& report) {
  return Settings(model, graph, report).read();
}

std::shared_ptr<const CompiledDiagram> Diagram::build(const Overrides& set, const std::string& unroll_method,
                                                      double unroll_step, Report& report) const {
  const double start = seconds();
  const std::size_t errors = report.error_count();
  auto compiled = std::make_shared<CompiledDiagram>();
  if (model_->is_library) return nullptr;
  compiled->graph = elaborate(model_, set, report);
  if (!compiled->graph || report.error_count() > errors) return nullptr;
  compiled->options = read_settings(*model_, *compiled->graph, report);
  compiled->recorded = plantloop::record(*compiled->graph);
  check_expect(*compiled->graph, compiled->recorded.record, compiled->options, report);
  check_units(*compiled->graph, compiled->recorded, report);
  CompileOptions options;
  for (const ShownColumn& column : compiled->recorded.columns) options.watches.push_back(column.value);
  for (const auto& [expression, bound] : compiled->graph->numbers) {
    const auto value = compiled->recorded.numbers.find(expression);
    if (value == compiled->recorded.numbers.end()) continue;
    compiled->numbers.emplace_back(expression, options.numbers.size());
    options.numbers.push_back(value->second);
  }
  compiled->first_bound = options.numbers.size();
  for (const RecordedBound& bound : compiled->recorded.bounds) options.numbers.push_back(bound.value);
  options.loops_are_errors = model_->simulation.loops == "error";
  options.dae = (unroll_method.empty() ? compiled->options.solver : unroll_method) == "ida";
  options.unroll_method = unroll_method;
  options.unroll_step = unroll_step;
  if (unroll_method.empty() && compiled->options.step > 0) {
    options.unroll_method = compiled->options.solver;
    options.unroll_step = compiled->options.step;
  }
  compiled->program = compile(compiled->recorded.record, options, report);
  compiled->compile_time = seconds() - start;
  if (!compiled->program || report.error_count() > errors) return nullptr;
  return compiled;
}

namespace {

// A plain number, as sweeps set them.
std::optional<double> plain_number(const std::string& text) { return parse_number(text); }

// Which settings ask for a program of their own: the names of those that are plain numbers, name and text of the
// others.
std::string structure_of(const Overrides& set, const std::vector<bool>& by_value) {
  std::vector<std::string> parts;
  for (std::size_t i = 0; i < set.size(); ++i) parts.push_back(set[i].path + (by_value[i] ? "=" : "=" + set[i].text));
  std::sort(parts.begin(), parts.end());
  std::string key;
  for (const auto& part : parts) key += part + "\n";
  return key;
}

}  // namespace

std::shared_ptr<const CompiledDiagram> Diagram::compiled(const Overrides& set, const std::string& unroll_method,
                                                         double unroll_step, Report& report) {
  // Runs on several threads share what was compiled; one at a time compiles.
  static std::mutex compiling;
  const std::lock_guard lock(compiling);
  const std::string method = fmt::format("{} {:a}\n", unroll_method, unroll_step);
  std::vector<bool> by_value(set.size());
  for (std::size_t i = 0; i < set.size(); ++i) by_value[i] = plain_number(set[i].text).has_value();
  // Numbers first count as values; those that turn out to shape the structure are then part of the key.
  for (int attempt = 0; attempt < 2; ++attempt) {
    const std::string key = method + structure_of(set, by_value);
    const auto known = cache_.find(key);
    if (known == cache_.end()) {
      auto built = build(set, unroll_method, unroll_step, report);
      if (built) cache_.emplace(key, built);
      return built;
    }
    const CompiledDiagram& candidate = *known->second;
    bool fits = true;
    for (std::size_t i = 0; i < set.size(); ++i) {
      if (!by_value[i]) continue;
      const auto& parameters = candidate.recorded.record.parameters;
      const auto parameter =
          std::find_if(parameters.begin(), parameters.end(), [&](const auto& p) { return p.name == set[i].path; });
      const bool found = parameter != parameters.end();
      const ParameterUse use = found ? candidate.recorded.uses[static_cast<std::size_t>(parameter - parameters.begin())]
                                     : ParameterUse::structural;
      const double value = *plain_number(set[i].text);
      if (use == ParameterUse::structural ||
          (use == ParameterUse::zero_structural && (value == 0) != (parameter->value == 0))) {
        by_value[i] = false;
        fits = false;
      }
    }
    if (fits) return known->second;
  }
  return build(set, unroll_method, unroll_step, report);
}

void Diagram::check(const Overrides& set, Report& report) {
  if (model_->is_library) return;
  const auto built = build(set, {}, 0, report);
  if (built) {
    check_solver(built->options, model_->simulation.solver_mark, report);
    check_unused(*built->graph, report);
  } else {
    find_solver(model_->simulation.solver, model_->simulation.solver_mark, report);
  }
}

namespace {

// The settings of the file with those of the request instead.
SimulationOptions settings_of(const RunRequest& request, const SimulationDecl& decl, SimulationOptions options) {
  if (decl.stop) options.span = options.stop - options.start;
  if (request.solver) options.solver = *request.solver;
  if (request.start) options.start = *request.start;
  if (request.stop) options.stop = *request.stop;
  if (request.step) options.step = *request.step;
  if (request.solver && !request.step) {
    const SolverInfo* info = find_solver(*request.solver);
    if (info != nullptr && !info->fixed) options.step = 0;
  }
  if (request.rtol) options.rtol = *request.rtol;
  if (request.rtol && !decl.atol) options.atol = atol_for(options.rtol);
  if (request.atol) options.atol = *request.atol;
  if (request.max_step) options.max_step = *request.max_step;
  if (request.max_memory) options.max_memory = *request.max_memory;
  if (request.output_interval) options.output_interval = *request.output_interval;
  return options;
}

// Gives tunable numbers their values and checks all bounds.
void set_parameters(const CompiledDiagram& built, const Overrides& set, Frame& frame, Report& report) {
  for (const Override& o : set) {
    const auto value = plain_number(o.text);
    if (!value) continue;
    const auto& parameters = built.recorded.record.parameters;
    for (std::size_t p = 0; p < parameters.size(); ++p) {
      if (parameters[p].name == o.path) frame.set_parameter(p, *value);
    }
  }
  execute(built.program->parameter_list, frame.arena);
  for (std::size_t b = 0; b < built.recorded.bounds.size(); ++b) {
    const RecordedBound& bound = built.recorded.bounds[b];
    const double value = frame.arena[built.program->numbers[built.first_bound + b]];
    if (!(value >= bound.min))
      report.error(bound.mark, "'{}' is {}: it must be at least {}", bound.name, value, bound.min);
    else if (!(value <= bound.max))
      report.error(bound.mark, "'{}' is {}: it must be at most {}", bound.name, value, bound.max);
    else if (!(value > bound.above) && bound.above != -unbounded)
      report.error(bound.mark, "'{}' is {}: it must be greater than {}", bound.name, value, bound.above);
  }
}

// Goes on from the checkpoint's time, counting from the first run's start.
void check_checkpoint(const Checkpoint& from, const Program& program, const RunRequest& request,
                      SimulationOptions& options, Report& report) {
  options.start = from.start;
  if (!(options.stop > from.time))
    report.error({}, "the run stops at {} s, which is not after the checkpoint's time, {} s", options.stop, from.time);
  if (from.structure == structure_of(program) || request.partial) return;
  Finding& finding = report.error({}, "the checkpoint is of another diagram, or of this one before it changed");
  const std::vector<std::string> missing = missing_in(from, program), extra = extra_in(from, program);
  if (!missing.empty()) finding.hint(fmt::format("it does not have: {}", fmt::join(missing, ", ")));
  if (!extra.empty()) finding.hint(fmt::format("only it has: {}", fmt::join(extra, ", ")));
  finding.hint("with 'partial' the values of equal paths are taken, and all else starts anew");
}

void check_save_points(const RunRequest& request, double begin, SimulationOptions& options, Report& report) {
  options.save_times = request.save_at;
  if (request.save_at_end) options.save_times.push_back(options.stop);
  for (const double t : options.save_times) {
    if (!(t >= begin && t <= options.stop))
      report.error({}, "the save point {} s lies outside of the run, which goes from {} s to {} s", t, begin,
                   options.stop);
  }
}

std::map<const Expression*, double> numbers_of(const CompiledDiagram& built, const Frame& frame) {
  std::map<const Expression*, double> numbers;
  for (const auto& [expression, index] : built.numbers)
    numbers[expression] = frame.arena[built.program->numbers[index]];
  return numbers;
}

}  // namespace

std::optional<PreparedRun> Diagram::prepare(const RunRequest& request, Report& report) {
  if (model_->is_library) {
    report.error({}, "{} is a library: it has types, but no blocks to run", model_->path);
    return std::nullopt;
  }
  const std::size_t errors = report.error_count();
  const std::string unroll_method = request.solver.value_or("");
  const double unroll_step = request.step.value_or(0);
  const std::string method = unroll_step > 0 && unroll_method.empty() ? model_->simulation.solver : unroll_method;
  PreparedRun prepared;
  prepared.compiled = compiled(request.set, method, unroll_step, report);
  if (!prepared.compiled || report.error_count() > errors) return std::nullopt;
  prepared.options = settings_of(request, model_->simulation, prepared.compiled->options);
  const SimulationOptions& options = prepared.options;
  check_solver(options, request.solver ? Mark{} : model_->simulation.solver_mark, report);
  if (!(options.stop > options.start))
    report.error({}, "the run stops at {} s, which is not after its start at {} s", options.stop, options.start);
  if (!(options.rtol > 0) || !(options.atol > 0))
    report.error({}, "rtol and atol must be greater than 0, they are {} and {}", options.rtol, options.atol);
  if (report.error_count() > errors) return std::nullopt;
  prepared.frame = std::make_unique<Frame>(prepared.compiled->program);
  set_parameters(*prepared.compiled, request.set, *prepared.frame, report);
  if (report.error_count() > errors) return std::nullopt;
  for (const ShownColumn& column : prepared.compiled->recorded.columns)
    prepared.columns.push_back({column.name, column.unit, column.rate, !column.written, column.names});
  return prepared;
}

namespace {

bool has_limits(const BlockType& type) {
  const auto& names = type.block->settable;
  return std::any_of(names.begin(), names.end(), [](std::string_view n) { return n == "lower" || n == "upper"; });
}

// Blocks with limits that did hardly anything but keep to them.
void check_limits(const CompiledDiagram& built, const RunStatistics& statistics, Report& report) {
  std::map<std::string_view, double> share;  // by block
  for (const LimitShare& limit : statistics.limits) share[built.program->sites[limit.site].path] += limit.share;
  constexpr double most = 0.95;
  for (const GraphBlock& block : built.graph->blocks) {
    if (!block.type || !has_limits(*block.type)) continue;
    const auto found = share.find(block.path);
    const int elements = std::max(1, built.graph->nets[block.first_output].shape.size());
    if (found == share.end() || found->second / elements <= most) continue;
    report.check("saturated", block.declaration->mark, "'{}' was at a limit for {:.0f} % of the run", block.path,
                 100 * found->second / elements);
  }
}

// What was noticed during a run, whether it came to its end or not.
void tell_findings(const CompiledDiagram& built, const RunStatistics& statistics, Report& report) {
  for (const std::string& text : statistics.warnings) report.check("zeno", {}, "{}", text);
  for (const RunFinding& found : statistics.findings)
    report.check(found.check, built.program->sites[found.site].mark, "{}", found.text);
  check_limits(built, statistics, report);
}

}  // namespace

std::optional<DiagramRun> Diagram::run(const RunRequest& request, Report& report, const RunControl& control,
                                       DiagramRun* partial) {
  const double start = seconds();
  const std::size_t errors = report.error_count();
  std::optional<PreparedRun> prepared = prepare(request, report);
  if (!prepared) return std::nullopt;
  const CompiledDiagram& built = *prepared->compiled;
  Frame& frame = *prepared->frame;
  DiagramRun run;
  run.options = prepared->options;
  SimulationOptions& options = run.options;
  run.numbers = numbers_of(built, frame);
  run.shown = built.recorded.shown;

  for (const ExpectDecl& entry : model_->expect) {
    if (entry.at && run.numbers.contains(entry.at.get())) options.sample_times.push_back(run.numbers[entry.at.get()]);
  }
  const Baselines baselines = read_baselines(*model_);
  for (const auto& [entry, baseline] : baselines) {
    if (!baseline.error.empty()) continue;
    const auto& times = baseline.table.columns[baseline.time_column];
    options.sample_times.insert(options.sample_times.end(), times.begin(), times.end());
  }
  if (control.from) check_checkpoint(*control.from, *built.program, request, options, report);
  check_save_points(request, control.from ? control.from->time : options.start, options, report);
  if (report.error_count() > errors) return std::nullopt;
  run.recording.provenance["diagram"] = model_->path;
  if (!model_->title.empty()) run.recording.provenance["title"] = model_->title;
  run.recording.provenance["solver"] = options.solver;
  for (const Override& o : request.set) run.recording.provenance["set " + o.path] = o.text;
  const double simulating = seconds();
  run.timing.compile = simulating - start;
  RunControl watched = control;
  watched.until_failure = &run.statistics;
  try {
    run.statistics = simulate(frame, options, prepared->columns, run.recording, watched);
  } catch (...) {
    run.timing.simulate = seconds() - simulating;
    tell_findings(built, run.statistics, report);
    if (partial != nullptr) *partial = std::move(run);
    throw;
  }
  run.timing.simulate = seconds() - simulating;
  tell_findings(built, run.statistics, report);
  run.verdicts = judge(*model_, run, baselines);
  return run;
}

std::optional<DiagramRun> Diagram::replay(Recording recording, const Overrides& set, Report& report) {
  std::optional<PreparedRun> prepared = prepare({.set = set}, report);
  if (!prepared) return std::nullopt;
  const CompiledDiagram& built = *prepared->compiled;
  DiagramRun run;
  run.options = prepared->options;
  run.numbers = numbers_of(built, *prepared->frame);
  run.recording = std::move(recording);
  if (run.recording.rows() > 0) run.options.stop = run.recording.time().back();
  for (const auto& [expression, range] : built.recorded.shown) {
    // The columns of one expression stand side by side in both.
    const int first = range.count > 0 ? run.recording.find(built.recorded.columns[range.first].name) : -1;
    bool found = first >= 0 && static_cast<std::size_t>(first) + range.count <= run.recording.columns.size();
    for (std::uint32_t i = 0; found && i < range.count; ++i) {
      found = run.recording.columns[static_cast<std::size_t>(first) + i].name ==
              built.recorded.columns[range.first + i].name;
    }
    if (found) run.shown[expression] = {static_cast<std::uint32_t>(first), range.count};
  }
  run.verdicts = judge(*model_, run, read_baselines(*model_));
  return run;
}

}  // namespace plantloop
