// What a command is: a file command_<name>.cpp that adds its options to the parser and says what to do.

#pragma once

#include <CLI/CLI.hpp>
#include <atomic>
#include <functional>
#include <string>

#include "engine/base/report.h"

namespace plantloop::app {

// Exit statuses, as `plantloop --help` tells them.
inline constexpr int done = 0;
inline constexpr int run_failed = 1;   // the run, test or comparison failed, or a limit was reached
inline constexpr int input_wrong = 2;  // what the user wrote is wrong
inline constexpr int our_fault = 70;

// Made by command_<name>.cpp: adds the subcommand, and returns what it does once its options are read.
using Action = std::function<int()>;
#define PLANTLOOP_COMMAND(name) plantloop::app::Action plantloop_command_##name(CLI::App& parser)

// Findings to standard error, in colour on a terminal. Returns whether there were errors.
bool print(const Report& report);
// One line to standard error: "plantloop: message".
void complain(const std::string& message);
// A result to standard output; false (after complaining) when nobody reads it or the disk is full.
bool write_out(const std::string& text);

bool is_terminal(int descriptor);
// Set by Ctrl-C and by a request to end.
extern std::atomic<bool> interrupted;

}  // namespace plantloop::app
