// plantloop explain: what the engine made of a diagram, and why.

#include <memory>

#include "app/command.h"
#include "app/request.h"
#include "engine/analysis/explain.h"

PLANTLOOP_COMMAND(explain) {
  using namespace plantloop;
  using namespace plantloop::app;
  struct Options {
    std::string file, name;
    std::vector<std::string> set;
  };
  const auto o = std::make_shared<Options>();
  parser.description(
      "Tell what the engine made of a diagram and why: order, rates, sizes, events, restarts; or everything about one "
      "block, signal, parameter or subsystem.");
  parser.add_option("DIAGRAM", o->file, "the diagram")->required();
  parser.add_option("NAME", o->name, "a path in it, as 'record:' writes it: plant, plant.u, controller.ki");
  add_set_option(parser, o->set);
  parser.footer("Examples:\n  plantloop explain loop.yaml\n  plantloop explain loop.yaml controller.u");
  return [o] {
    Overrides set;
    if (!read_overrides(o->set, set)) return input_wrong;
    Report report;
    const auto diagram = load_diagram(o->file, report);
    if (!diagram) return input_wrong;
    if (diagram->model().is_library) {
      complain(o->file + " is a library: it has types, but no blocks to explain");
      return input_wrong;
    }
    const auto text = explain(diagram->model_pointer(), set, o->name, report);
    print(report);
    if (!text) return input_wrong;
    return write_out(*text) ? done : run_failed;
  };
}
