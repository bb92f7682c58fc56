// plantloop trim: a point at which a diagram rests.

#include <fmt/format.h>

#include <cmath>
#include <memory>

#include "app/command.h"
#include "app/request.h"
#include "engine/analysis/linearise.h"
#include "engine/base/error.h"
#include "engine/base/numbers.h"

namespace plantloop::app {

namespace {

struct TrimOptions {
  std::string file;
  std::vector<std::string> set, inputs, outputs, fixed, bounds;
  double at = NAN;
};

// "path=number"; false after complaining.
bool read_assignment(const std::string& text, const char* option, std::pair<std::string, double>& into) {
  const std::size_t equals = text.find('=');
  const auto value = equals == std::string::npos ? std::nullopt : parse_number(text.substr(equals + 1));
  if (value && equals > 0) {
    into = {text.substr(0, equals), *value};
    return true;
  }
  complain(fmt::format("{} {}: it must be path=number, as in {} y=1.5", option, text, option));
  return false;
}

// "path=lower:upper"; false after complaining.
bool read_bound(const std::string& text, TrimRequest::Free& into) {
  const std::size_t equals = text.find('='), colon = text.find(':');
  if (equals != std::string::npos && equals > 0 && colon != std::string::npos && colon > equals) {
    const auto lower = parse_number(text.substr(equals + 1, colon - equals - 1));
    const auto upper = parse_number(text.substr(colon + 1));
    if (lower && upper && *lower <= *upper) {
      into = {text.substr(0, equals), *lower, *upper};
      return true;
    }
  }
  complain(fmt::format("--bound {}: it must be path=lower:upper, as in --bound u=0:10", text));
  return false;
}

bool read(const TrimOptions& o, TrimRequest& request) {
  if (!read_overrides(o.set, request.set)) return false;
  for (const std::string& path : o.inputs) request.inputs.push_back({path});
  for (const std::string& text : o.outputs) {
    if (!read_assignment(text, "--output", request.outputs.emplace_back())) return false;
  }
  for (const std::string& text : o.fixed) {
    if (!read_assignment(text, "--fix", request.fixed.emplace_back())) return false;
  }
  for (const std::string& text : o.bounds) {
    TrimRequest::Free bound;
    if (!read_bound(text, bound)) return false;
    bool of_input = false;
    for (TrimRequest::Free& input : request.inputs) {
      if (input.path == bound.path) input = bound, of_input = true;
    }
    if (!of_input) request.states.push_back(bound);
  }
  if (!std::isnan(o.at)) request.at = o.at;
  return true;
}

std::string text_of(const Trim& t) {
  std::string text = fmt::format("{} after {} iterations; the largest residual is {:.3g}\n",
                                 t.converged ? "at rest" : "NOT at rest", t.iterations, t.largest_residual);
  if (!t.converged) text += "  " + t.why + "\n";
  const auto list = [&](const char* title, const std::vector<Trim::Entry>& entries, const char* residual) {
    if (entries.empty()) return;
    text += fmt::format("{}:\n", title);
    std::size_t width = 0;
    for (const Trim::Entry& e : entries) width = std::max(width, e.path.size());
    for (const Trim::Entry& e : entries)
      text += fmt::format("  {:<{}}  {:.15g}  ({} {:.3g})\n", e.path, width, e.value, residual, e.residual);
  };
  list("states", t.states, "changes by");
  list("inputs", t.inputs, "outside of its bounds by");
  list("outputs", t.outputs, "away by");
  return text;
}

int run(const TrimOptions& o) {
  TrimRequest request;
  if (!read(o, request)) return input_wrong;
  Report report;
  const auto diagram = load_diagram(o.file, report);
  if (!diagram) return input_wrong;
  std::optional<Trim> found;
  try {
    found = trim(diagram->model_pointer(), request, report);
  } catch (const RunError& e) {
    print(report);
    complain(e.what());
    return run_failed;
  }
  print(report);
  if (!found) return input_wrong;
  if (!write_out(text_of(*found))) return run_failed;
  return found->converged ? done : run_failed;
}

}  // namespace

}  // namespace plantloop::app

PLANTLOOP_COMMAND(trim) {
  using namespace plantloop::app;
  const auto o = std::make_shared<TrimOptions>();
  parser.description(
      "Find a rest: all derivatives zero, sampled states repeating themselves, outputs as wanted. Begins at the "
      "initial values; with fewer conditions than unknowns the nearest rest is found.");
  parser.add_option("DIAGRAM", o->file, "the diagram")->required();
  const auto many = [&](const char* name, std::vector<std::string>& into, const char* help, const char* type) {
    parser.add_option(name, into, help)->allow_extra_args(false)->type_name(type);
  };
  many("--input", o->inputs, "a signal that may be moved", "PATH");
  many("--output", o->outputs, "a signal and the value that it must have", "PATH=NUMBER");
  many("--fix", o->fixed, "a state and the value that it keeps", "PATH=NUMBER");
  many("--bound", o->bounds, "bounds of a state or of a signal that may be moved", "PATH=LOWER:UPPER");
  add_set_option(parser, o->set);
  parser.add_option("--at", o->at, "begin at this time of a run, in s");
  parser.footer(
      "Exit status 1 when no rest is found; what is left of each equation is told.\n\n"
      "Examples:\n"
      "  plantloop trim pendulum.yaml\n"
      "  plantloop trim tank.yaml --input inflow --output level=2 --bound inflow=0:10");
  return [o] { return run(*o); };
}
