// plantloop schema: what editors need to know, the JSON schema of diagram files and the functions of scripts.

#include <memory>

#include "app/command.h"
#include "app/figures.h"
#include "engine/graph/describe.h"
#include "scripts/host/host.h"

PLANTLOOP_COMMAND(schema) {
  using namespace plantloop;
  using namespace plantloop::app;
  struct Options {
    bool lua = false, functions = false;
  };
  const auto o = std::make_shared<Options>();
  parser.description("Print the JSON schema of diagram files, for completion and checks in an editor.");
  auto* const lua = parser.add_flag("--lua", o->lua, "the functions of scripts instead, as declarations for editors");
  parser.add_flag("--functions", o->functions, "the functions of scripts as a page with all their options")
      ->excludes(lua);
  parser.footer("Example:\n  plantloop schema > plantloop.schema.json");
  return [o] {
    return write_out(o->lua         ? lua_stubs()
                     : o->functions ? lua_reference()
                                    : diagram_schema(plot_words()))
               ? done
               : run_failed;
  };
}
