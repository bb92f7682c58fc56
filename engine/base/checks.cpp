// What is looked at beside plain mistakes, before, during and after a run.

#include "engine/base/checks.h"

#include <fmt/format.h>

namespace plantloop {

const std::vector<CheckInfo>& checks() {
  static const std::vector<CheckInfo> list{
      {"algebraic-loop", Level::note,
       "signals that need each other's value at the same instant, found by iteration; a loop that cannot be solved is "
       "an error in any case"},
      {"chatter", Level::warning, "a function whose events follow each other a hundred times in hardly any time"},
      {"columns", Level::note, "without record: more than 200 columns would be recorded"},
      {"control-status", Level::note,
       "a predictive controller that did not find its optimum, or could not reach its reference, at some samples"},
      {"mixed-rates", Level::error, "a block without rate reads signals of rates that do not fit together", true},
      {"never-enabled", Level::warning, "a conditional block or subsystem that was not active once in the run"},
      {"no-rate", Level::error, "a sampled block without a rate, which nothing around it or before it gives", true},
      {"not-a-number", Level::error,
       "a NaN or an infinity in a state, a recorded signal, an event or a condition ends the run", true},
      {"rate-mix", Level::note,
       "a sampled block or expression that reads a signal of another rate: at its hits it takes the present value; a "
       "rate_transition says with which latency"},
      {"restarts", Level::warning, "events make the solver start anew more often than in one of ten steps"},
      {"saturated", Level::warning, "a block was at a limit of its own for more than 95 % of the run"},
      {"sizes", Level::error, "signals, parameters and ports whose sizes do not fit", true},
      {"step-size", Level::warning, "the solver's steps collapsed; the fastest state is named"},
      {"unconnected", Level::error, "an input without default that nothing feeds", true},
      {"unit-clash", Level::error, "two known units that differ meet in a sum, a comparison or at a port"},
      {"units", Level::off, "a known unit meets a signal or number without one"},
      {"unknown-key", Level::error, "a key that means nothing where it stands", true},
      {"unreachable-state", Level::warning, "a state of a state machine to which no transitions lead"},
      {"unreachable-transition", Level::warning, "a transition with the condition of one that stands before it"},
      {"unused-output", Level::note, "a block whose outputs nobody reads, records, draws or expects"},
      {"zeno", Level::warning, "events followed each other without end, and zeno: says to go on"},
      {"zero-delay", Level::note, "a delay of 0 s: the output is the input at the same instant"},
  };
  return list;
}

const CheckInfo* find_check(std::string_view id) {
  for (const CheckInfo& check : checks()) {
    if (check.id == id) return &check;
  }
  return nullptr;
}

std::string_view name_of(Level level) {
  switch (level) {
    case Level::off:
      return "off";
    case Level::note:
      return "note";
    case Level::warning:
      return "warning";
    case Level::error:
      return "error";
  }
  return "";
}

std::optional<Level> level_named(std::string_view name) {
  for (const Level level : {Level::off, Level::note, Level::warning, Level::error}) {
    if (name_of(level) == name) return level;
  }
  return std::nullopt;
}

std::string checks_markdown() {
  std::string text =
      "# Checks\n\nMade from the program by `plantloop check --list`. A diagram gives a check another severity under "
      "`checks:`, for example\n`checks: {units: note, saturated: off}`; with `--strict`, or `simulation: {strict: "
      "true}`, warnings are errors.\n\n| check | severity | what is found |\n| --- | --- | --- |\n";
  for (const CheckInfo& check : checks())
    text +=
        fmt::format("| `{}` | {}{} | {} |\n", check.id, name_of(check.level), check.fixed ? ", always" : "", check.doc);
  return text;
}

}  // namespace plantloop
