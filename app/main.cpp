// The program: reads the command line and runs one command.

#include <fmt/format.h>

#include <csignal>
#include <cstdio>
#include <exception>
#include <iostream>
#include <map>
#include <new>
#include <string>
#include <vector>

#include "app/commands.h"
#include "app/version.h"
#include "engine/base/error.h"
#include "engine/base/report.h"

namespace {

using namespace plantloop::app;

void on_signal(int) {
  // The first one asks for an orderly end, the second one does not ask.
  if (interrupted.exchange(true)) std::_Exit(130);
}

// Complains when there is no command of that name.
bool is_command(const std::string& word) {
  std::vector<std::string> names;
  for (const auto& [name, make] : commands()) {
    if (name == word) return true;
    names.emplace_back(name);
  }
  const std::string near = plantloop::nearest(word, names);
  complain(fmt::format("there is no command '{}'{}; there are {}", word,
                       near.empty() ? "" : fmt::format(", did you mean '{}'?", near), fmt::join(names, ", ")));
  return false;
}

int run(int argc, char** argv) {
  CLI::App parser("Plantloop: block diagrams in YAML, simulated, scripted and drawn.", "plantloop");
  parser.set_version_flag("--version", "plantloop " PLANTLOOP_VERSION);
  parser.require_subcommand(1);
  parser.footer(
      "Exit status: 0 done; 1 the run, test or comparison failed or a limit was reached; 2 the input is wrong; 70 our "
      "own fault.\n"
      "\n"
      "Begin with:\n"
      "  plantloop new loop && plantloop run loop.yaml --figures out");
  std::map<CLI::App*, Action> actions;
  for (const auto& [name, make] : commands()) {
    CLI::App* sub = parser.add_subcommand(name);
    actions[sub] = make(*sub);
  }
  if (argc == 1) {
    std::cerr << parser.help();
    return input_wrong;
  }
  if (argc > 1 && argv[1][0] != '-' && !is_command(argv[1])) return input_wrong;
  try {
    parser.parse(argc, argv);
  } catch (const CLI::Success& e) {
    return parser.exit(e);
  } catch (const CLI::ConversionError& e) {
    // CLI11 says "Could not convert: --stop = x".
    const std::string text = e.what();
    const std::size_t colon = text.find(": ");
    std::string option = colon == std::string::npos ? text : text.substr(colon + 2);
    if (const std::size_t equals = option.find(" = "); equals != std::string::npos) option.replace(equals, 3, " ");
    complain(fmt::format("{}: a number is expected", option));
    return input_wrong;
  } catch (const CLI::ParseError& e) {
    parser.exit(e, std::cout, std::cerr);
    return input_wrong;
  }
  for (const auto& [sub, action] : actions) {
    if (sub->parsed()) return action();
  }
  return input_wrong;
}

}  // namespace

int main(int argc, char** argv) {
  std::signal(SIGINT, on_signal);
  std::signal(SIGTERM, on_signal);
  std::signal(SIGPIPE, SIG_IGN);
  try {
    return run(argc, argv);
  } catch (const std::bad_alloc&) {
    complain("out of memory");
    return run_failed;
  } catch (const plantloop::RunError& e) {
    complain(e.what());
    return run_failed;
  } catch (const std::exception& e) {
    complain(fmt::format("internal error: {}\nPlease report this with the files that led to it.", e.what()));
    return our_fault;
  }
}
