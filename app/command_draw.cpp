// plantloop draw: the diagram itself as a picture.

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>

#include "app/command.h"
#include "app/drawing/sheets.h"
#include "engine/base/files.h"
#include "render/diagram/draw.h"
#include "render/error.h"
#include "render/image.h"
#include "render/theme.h"

namespace plantloop::app {

namespace {

struct DrawOptions {
  std::string file, out, inside, theme = "light";
  std::vector<std::string> set, show;
  int depth = 0;
};

// The format that the file's name asks for; "" after complaining.
std::string format_of(const std::string& path) {
  const std::vector<std::string> formats = picture_formats();
  std::string extension = std::filesystem::path(path).extension().string();
  if (!extension.empty()) extension.erase(0, 1);
  if (std::find(formats.begin(), formats.end(), extension) != formats.end()) return extension;
  complain(fmt::format("-o {}: the name must end in .{}", path, fmt::join(formats, ", .")));
  return {};
}

// The scope that is to be drawn; nothing after complaining.
std::optional<std::uint32_t> scope_of(const Graph& graph, const DrawOptions& o) {
  if (o.inside.empty()) return 0;
  const Named named = find_named(graph, o.inside);
  if (named.kind == Named::Kind::scope) return named.index;
  std::vector<std::string> subsystems;
  for (const GraphScope& s : graph.scopes)
    if (!s.path.empty() && subsystems.size() < 10) subsystems.push_back(s.path);
  complain(subsystems.empty() ? fmt::format("--inside {}: {} has no subsystems", o.inside, o.file)
                              : fmt::format("--inside {}: there is no subsystem of this name; there are: {}", o.inside,
                                            fmt::join(subsystems, ", ")));
  return std::nullopt;
}

int draw_diagram(const DrawOptions& o) {
  const std::string format = format_of(o.out);
  if (format.empty()) return input_wrong;
  Report report;
  const std::shared_ptr<const Model> model = read_model(o.file, report);
  std::shared_ptr<const Graph> graph;
  if (model && !report.has_errors()) graph = elaborate(model, {}, report);
  if (!graph || report.has_errors()) {
    print(report);
    return input_wrong;
  }
  const auto scope = scope_of(*graph, o);
  if (!scope) return input_wrong;
  const auto shows = [&](const char* what) { return std::find(o.show.begin(), o.show.end(), what) != o.show.end(); };
  const Sheet sheet = sheet_of(
      *graph, *scope, {.depth = o.depth, .rates = shows("rates"), .sizes = shows("sizes"), .units = shows("units")});
  if (sheet.blocks.empty()) {
    complain(fmt::format("{} has no blocks, so there is nothing to draw", o.file));
    return input_wrong;
  }
  std::vector<std::uint8_t> bytes;
  try {
    bytes = picture(draw(sheet, arrange(sheet), o.theme), format);
  } catch (const RenderError& e) {
    complain(fmt::format("cannot draw '{}': {}", o.out, e.what()));
    return run_failed;
  }
  if (const std::string error = write_file(o.out, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
      !error.empty()) {
    complain(fmt::format("cannot write '{}': {}", o.out, error));
    return run_failed;
  }
  return done;
}

}  // namespace

}  // namespace plantloop::app

PLANTLOOP_COMMAND(draw) {
  using namespace plantloop;
  using namespace plantloop::app;
  const auto o = std::make_shared<DrawOptions>();
  parser.description(
      "Draw a diagram as a block diagram: the forward path from left to right, what leads back below it.");
  parser.add_option("DIAGRAM", o->file, "the diagram")->required();
  parser.add_option("-o,--out", o->out, fmt::format("the picture: .{}", fmt::join(picture_formats(), ", .")))
      ->required()
      ->type_name("FILE");
  parser.add_option("--inside", o->inside, "draw the inside of this subsystem")->type_name("PATH");
  parser.add_option("--depth", o->depth, "how many levels of subsystems are drawn open, in frames")
      ->check(CLI::Range(0, 100))
      ->capture_default_str();
  parser.add_option("--theme", o->theme, "how it looks")->check(CLI::IsMember(theme_names()))->capture_default_str();
  parser
      .add_option("--show", o->show,
                  "what else is written: rates below the blocks, sizes and units on the wires; separated by commas")
      ->delimiter(',')
      ->check(CLI::IsMember({"rates", "sizes", "units"}));
  parser.footer(
      "Examples:\n"
      "  plantloop draw loop.yaml -o loop.svg\n"
      "  plantloop draw loop.yaml -o loop.png --depth 1 --show rates,sizes\n"
      "  plantloop draw loop.yaml -o controller.pdf --inside controller");
  return [o] { return draw_diagram(*o); };
}
