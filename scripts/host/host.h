// Runs experiments written in Lua, in a sandbox: what `plantloop script` calls.
//
//   ScriptOptions options;
//   options.seconds = 60;
//   int status = run_script("scripts/book/pendulum.lua", {"fast"}, options);

#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <iostream>
#include <string>
#include <string_view>
#include <vector>

namespace plantloop {

// What a script may use before it is stopped; 0: no limit. It cannot change them.
struct ScriptOptions {
  double time_limit = 3600;                         // s of wall clock
  std::int64_t max_instructions = 100'000'000'000;  // of the Lua machine, and of our functions in the same measure
  std::size_t max_memory = std::size_t{2} << 30;    // bytes, of values, vectors and runs together
  const std::atomic<bool>* cancel = nullptr;        // set from anywhere: the script ends

  std::ostream* output = &std::cout;    // of `print`
  std::ostream* messages = &std::cerr;  // errors, and the notes and warnings of diagrams
  bool colour = false;                  // of findings
  // Of the simulation that runs now: the diagram's path and the part of the simulated time that is done. Of a fit the
  // path is empty. Before something is printed it is called with 1: what shows progress makes room.
  std::function<void(const std::string& diagram, double fraction)> progress;
};

// Exit statuses of a script.
inline constexpr int script_done = 0;
inline constexpr int script_failed = 1;       // an error of the script or of a run, or a limit was reached
inline constexpr int script_input_wrong = 2;  // the script cannot be read or is no Lua, or a diagram is wrong

// Runs the script and returns its exit status; never throws for what a script does. Paths that the script reads are
// relative to its own folder and lie inside its project, what it writes lies below the working directory.
int run_script(const std::string& path, const std::vector<std::string>& arguments, const ScriptOptions& options = {});

// The same for a text in memory; `path` names it in messages and anchors its relative paths.
int run_script_text(std::string_view text, const std::string& path, const std::vector<std::string>& arguments,
                    const ScriptOptions& options = {});

// The functions that scripts may call, as `---@meta` declarations for editors.
std::string lua_stubs();
// The same as a page of documentation, docs/lua.md.
std::string lua_reference();

}  // namespace plantloop
