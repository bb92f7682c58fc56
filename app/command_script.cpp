// plantloop script: runs an experiment written in Lua.

#include <unistd.h>

#include <algorithm>
#include <memory>

#include "app/command.h"
#include "app/progress.h"
#include "scripts/host/host.h"

PLANTLOOP_COMMAND(script) {
  using namespace plantloop;
  using namespace plantloop::app;
  struct Options {
    std::string file;
    std::vector<std::string> arguments;
    double max_time = 0, max_memory = 0, max_instructions = 0;
  };
  const auto o = std::make_shared<Options>();
  parser.description("Run an experiment written in Lua. Options stand before it; what follows it is its own.");
  parser.add_option("--max-time", o->max_time, "stop the script after this many seconds; 3600 if not told")
      ->check(CLI::PositiveNumber);
  parser.add_option("--max-memory", o->max_memory, "stop it when it needs more than this many MB")
      ->check(CLI::PositiveNumber);
  parser.add_option("--max-instructions", o->max_instructions, "stop it after this many instructions of Lua")
      ->check(CLI::PositiveNumber);
  parser.add_option("EXPERIMENT", o->file, "the script")->required();
  parser.add_option("arguments", o->arguments, "the script finds them in the table `arg`");
  parser.prefix_command(false)->positionals_at_end(true);
  parser.footer("Example:\n  plantloop script scripts/book/pendulum.lua");
  return [o] {
    ScriptOptions options;
    if (o->max_time > 0) options.time_limit = o->max_time;
    if (o->max_memory > 0) options.max_memory = static_cast<std::size_t>(o->max_memory * 1048576);
    if (o->max_instructions > 0)
      options.max_instructions = static_cast<std::int64_t>(std::min(o->max_instructions, 1e18));
    options.cancel = &interrupted;
    options.colour = is_terminal(STDERR_FILENO);
    Progress progress(true);
    options.progress = [&progress](const std::string&, double fraction) {
      if (fraction < 1) {
        progress(fraction);
      } else {
        progress.restart();
      }
    };
    return run_script(o->file, o->arguments, options);
  };
}
