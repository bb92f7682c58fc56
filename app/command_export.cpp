// plantloop export: a sampled subsystem as a function block in structured text.

#include <memory>

#include "app/command.h"
#include "app/request.h"
#include "engine/analysis/structured_text.h"

namespace plantloop::app {

namespace {

struct ExportOptions {
  std::string file, part, name, out;
  std::vector<std::string> set;
};

int export_part(const ExportOptions& o) {
  StructuredTextRequest request{.part = o.part, .name = o.name, .set = {}};
  if (!read_overrides(o.set, request.set)) return input_wrong;
  Report report;
  const auto diagram = load_diagram(o.file, report);
  if (!diagram) return input_wrong;
  const auto text = structured_text(diagram->model_pointer(), request, report);
  print(report);
  if (!text) return input_wrong;
  if (o.out.empty()) return write_out(*text) ? done : run_failed;
  return write_result(o.out, *text) ? done : run_failed;
}

}  // namespace

}  // namespace plantloop::app

PLANTLOOP_COMMAND(export) {
  using namespace plantloop::app;
  const auto o = std::make_shared<ExportOptions>();
  parser.description(
      "Write a sampled subsystem as a function block in structured text (IEC 61131-3): called once in each period, it "
      "computes what the subsystem computes at its hits.");
  parser.add_option("DIAGRAM", o->file, "the diagram")->required();
  parser.add_option("--part", o->part, "the subsystem")->required()->type_name("PATH");
  parser.add_option("--name", o->name, "of the function block; default: the subsystem's")->type_name("NAME");
  add_set_option(parser, o->set);
  parser.add_option("-o,--out", o->out, "where to write it; default: standard output")->type_name("FILE");
  parser.footer(
      "Parameters become constants, states begin as the diagram begins. What has no counterpart, as a delay or a "
      "learned "
      "map, is refused with its place.\n\n"
      "Example:\n"
      "  plantloop export plant.yaml --part controller -o controller.st");
  return [o] { return export_part(*o); };
}
