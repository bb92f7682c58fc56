// Names to probes and watches, rates to a pattern of hits, and the operating point by a run.

#include "engine/analysis/linear_program.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <numeric>

namespace plantloop {

namespace {

// A signal of the diagram, or one of its elements: suffix ".2".
struct Wire {
  std::uint32_t net = 0;
  std::string suffix;
  bool means(const std::string& whole, const std::string& element) const {
    if (!suffix.empty()) return element == whole + suffix;
    return element == whole || (element.rfind(whole + ".", 0) == 0 &&
                                element.find_first_not_of("0123456789.", whole.size()) == std::string::npos);
  }
};

std::optional<std::uint32_t> net_of(const Graph& graph, const std::string& path) {
  const Named named = find_named(graph, path);
  if (named.kind == Named::Kind::net) return named.index;
  if (named.kind == Named::Kind::block && graph.blocks[named.index].outputs > 0)
    return graph.blocks[named.index].first_output;
  if (named.kind == Named::Kind::scope && !graph.scopes[named.index].type->outputs.empty())
    return graph.scopes[named.index].first_output;
  return std::nullopt;
}

// Nothing after reporting.
std::optional<Wire> find_wire(const Graph& graph, const std::string& path, const char* what, Report& report) {
  std::string whole = path;
  for (int cut = 0; cut < 3; ++cut) {
    if (const auto net = net_of(graph, whole)) {
      const std::string suffix = path.substr(whole.size());
      const Shape& shape = graph.nets[*net].shape;
      if (suffix.empty() || !shape.is_scalar()) return Wire{*net, suffix};
    }
    const std::size_t dot = whole.rfind('.');
    if (dot == std::string::npos || whole.find_first_not_of("0123456789", dot + 1) != std::string::npos) break;
    whole.resize(dot);
  }
  std::vector<std::string> names;
  for (const GraphNet& net : graph.nets) names.push_back(path_of(graph, net));
  const std::string near = nearest(path, names);
  Finding& finding = report.error({}, "{} '{}' is no signal of the diagram", what, path);
  if (!near.empty()) finding.hint(fmt::format("did you mean '{}'?", near));
  return std::nullopt;
}

// The elements of a wire.
std::vector<const RecordedSignal*> signals_of(const Graph& graph, const Record& record, const Wire& wire) {
  const std::string whole = path_of(graph, graph.nets[wire.net]);
  std::vector<const RecordedSignal*> found;
  // The block that drives an output of the same name is there, too.
  const auto is_new = [&](const std::string& name) {
    return std::none_of(found.begin(), found.end(), [&](const RecordedSignal* s) { return s->name == name; });
  };
  for (const RecordedSignal& signal : record.signals) {
    if (wire.means(whole, signal.name) && is_new(signal.name)) found.push_back(&signal);
  }
  return found;
}

HitPattern pattern_of(const Program& program, Report& report) {
  HitPattern pattern;
  if (program.rates.size() < 2) return pattern;
  Rational base = program.rates[1].period;
  const auto with = [&](const Rational& r) {
    if (r.is_zero()) return;
    if (const auto g = gcd(base, r)) base = *g;
  };
  for (std::size_t r = 1; r < program.rates.size(); ++r) with(program.rates[r].period), with(program.rates[r].offset);
  std::int64_t whole = 1;
  std::vector<std::int64_t> period(program.rates.size(), 1), offset(program.rates.size(), 0);
  constexpr std::int64_t most_ticks = 1'000'000;
  for (std::size_t r = 1; r < program.rates.size(); ++r) {
    period[r] = divide(program.rates[r].period, base)->num();
    offset[r] = divide(program.rates[r].offset, base)->num() % period[r];
    whole = std::lcm(whole, period[r]);
    if (whole > most_ticks) {
      report
          .error({}, "the periods of the rates have a common multiple of more than {} of their common parts of {} s",
                 most_ticks, base.to_double())
          .hint("with 'hold' the sampled values stand still and the continuous part is linearised alone");
      return pattern;
    }
  }
  std::map<std::int64_t, Mask> instants;
  for (std::size_t r = 1; r < program.rates.size(); ++r) {
    for (std::int64_t k = offset[r]; k < whole; k += period[r]) instants[k] |= rate_bit(static_cast<RateIndex>(r));
  }
  pattern.period = base.at(whole);
  for (auto it = instants.begin(); it != instants.end(); ++it) {
    const auto known = std::find(pattern.sets.begin(), pattern.sets.end(), it->second);
    pattern.set_at.push_back(static_cast<std::size_t>(known - pattern.sets.begin()));
    if (known == pattern.sets.end()) pattern.sets.push_back(it->second);
    const auto next = std::next(it);
    pattern.after.push_back(
        base.at((next == instants.end() ? instants.begin()->first + whole : next->first) - it->first));
  }
  return pattern;
}

}  // namespace

std::vector<const RecordedSignal*> signals_at(const Graph& graph, const Record& record, const std::string& path,
                                              const char* what, Report& report) {
  const auto wire = find_wire(graph, path, what, report);
  return wire ? signals_of(graph, record, *wire) : std::vector<const RecordedSignal*>{};
}

Sensitivity LinearProgram::size() const {
  return {program->state_names.size(), program->discretes.size(), probes.size(), program->linear.held_masks.size()};
}

void LinearProgram::go_to(std::optional<double> time) {
  SimulationOptions o = options;
  o.only_start = !time || *time <= o.start;
  if (time && !o.only_start) o.stop = *time;
  if (o.stop <= o.start) o.stop = o.start + 1;
  Recording recording;
  std::vector<RecordedColumn> columns(program->watch_list.roots.size());
  simulate(*frame, o, columns, recording);
}

DenseMatrix LinearProgram::evaluate(const Program::PartialList& partials, std::size_t rows) const {
  DenseMatrix m(rows, size().columns());
  if (partials.row.empty()) return m;
  KernelFrame kernels = frame->kernel_frame(false);
  execute(partials.list, frame->arena, &kernels);
  for (std::size_t k = 0; k < partials.row.size(); ++k)
    m(partials.row[k], partials.column[k]) += frame->arena[partials.list.roots[k]];
  return m;
}

void LinearProgram::evaluate_outputs() {
  if (program->watch_list.empty()) return;
  KernelFrame kernels = frame->kernel_frame(false);
  execute(program->watch_list, frame->arena, &kernels);
}

double LinearProgram::output(std::size_t index) { return frame->arena[program->watch_list.roots[index]]; }

std::unique_ptr<LinearProgram> make_linear_program(const std::shared_ptr<const Model>& model, const Overrides& set,
                                                   const std::vector<std::string>& inputs,
                                                   const std::vector<std::string>& open,
                                                   const std::vector<std::string>& outputs, Report& report) {
  if (model->is_library) {
    report.error({}, "{} is a library: it has types, but no blocks to linearise", model->path);
    return nullptr;
  }
  auto p = std::make_unique<LinearProgram>();
  p->graph = elaborate(model, set, report);
  if (!p->graph || report.has_errors()) return nullptr;
  const Graph& graph = *p->graph;
  p->options = read_settings(*model, graph, report);

  std::vector<Wire> input_wires, open_wires, output_wires;
  const auto find_all = [&](const std::vector<std::string>& paths, const char* what, std::vector<Wire>& wires) {
    for (const std::string& path : paths) {
      if (const auto wire = find_wire(graph, path, what, report)) wires.push_back(*wire);
    }
  };
  find_all(inputs, "the input", input_wires);
  find_all(open, "the opened wire", open_wires);
  find_all(outputs, "the output", output_wires);
  if (report.has_errors()) return nullptr;

  std::vector<Probe> probes;
  const auto add_probe = [&](std::uint32_t net, bool opened) {
    for (Probe& known : probes) {
      if (known.net == net) return void(known.open = known.open || opened);
    }
    probes.push_back({net, opened});
  };
  for (const Wire& wire : input_wires) add_probe(wire.net, false);
  for (const Wire& wire : open_wires) add_probe(wire.net, true);
  std::vector<RecordedProbe> probed;
  p->recorded = record(graph, probes, &probed);
  const auto name_of = [&](const Wire& wire) { return path_of(graph, graph.nets[wire.net]); };

  CompileOptions compiling;
  compiling.linear = true;
  for (const Wire& wire : output_wires) {
    for (const RecordedSignal* signal : signals_of(graph, p->recorded.record, wire)) {
      compiling.watches.push_back(signal->value);
      p->outputs.push_back(signal->name);
    }
  }
  for (const Wire& wire : open_wires) {
    for (const RecordedProbe& probe : probed) {
      if (!wire.means(name_of(wire), probe.name)) continue;
      compiling.linear_open.push_back(static_cast<std::uint32_t>(compiling.watches.size()));
      compiling.watches.push_back(probe.driver);
    }
  }
  for (const Wire& wire : input_wires) {
    for (const RecordedProbe& probe : probed) {
      if (!wire.means(name_of(wire), probe.name)) continue;
      p->probes.push_back(probe);
      compiling.linear_by.push_back(probe.parameter);
    }
  }
  // The pattern needs the rates only, and compiling needs the pattern.
  Program rates_only;
  rates_only.rates = p->recorded.record.rates;
  p->pattern = pattern_of(rates_only, report);
  if (p->pattern.period > 0) {  // the last set is that of all rates, which a rest needs
    Mask all = 0;
    for (const Mask bits : p->pattern.sets) all |= bits;
    p->pattern.sets.push_back(all);
  }
  compiling.linear_hits = p->pattern.sets;
  if (report.has_errors()) return nullptr;
  p->program = compile(p->recorded.record, compiling, report);
  if (!p->program || report.has_errors()) return nullptr;
  p->frame = std::make_unique<Frame>(p->program);
  return p;
}

}  // namespace plantloop
