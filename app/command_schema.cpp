// plantloop schema: the JSON schema of diagram files, for editors.

#include "app/command.h"
#include "app/figures.h"
#include "engine/graph/describe.h"

PLANTLOOP_COMMAND(schema) {
  using namespace plantloop;
  using namespace plantloop::app;
  parser.description("Print the JSON schema of diagram files, for completion and checks in an editor.");
  parser.footer("Example:\n  plantloop schema > plantloop.schema.json");
  return [] { return write_out(diagram_schema(plot_words())) ? done : run_failed; };
}
