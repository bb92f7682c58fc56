// plantloop draw: the diagram itself as a picture.

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <set>

#include "app/command.h"
#include "app/drawing/formulas.h"
#include "app/drawing/hints.h"
#include "app/drawing/sheets.h"
#include "app/figures.h"
#include "engine/base/files.h"
#include "engine/run/recording.h"
#include "render/diagram/draw.h"
#include "render/error.h"
#include "render/image.h"
#include "render/theme.h"

namespace plantloop::app {

namespace {

struct DrawOptions {
  std::string file, out, inside, hints, theme = "light";
  std::vector<std::string> show;
  int depth = 0;
  bool pages = false;
  std::string values;
  double at = std::numeric_limits<double>::infinity();
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

struct Page {
  std::string path;  // of the subsystem; "" for the diagram
  Scene scene;
};

// The scope and, below it, one subsystem of each type, by their paths.
std::vector<std::uint32_t> scopes_below(const Graph& graph, std::uint32_t top) {
  std::vector<std::uint32_t> scopes{top};
  std::set<const TypeDecl*> types{graph.scopes[top].type};
  for (const std::uint32_t s : graph.scope_order) {
    const GraphScope& scope = graph.scopes[s];
    const bool below = top == 0 ? !scope.path.empty() : scope.path.starts_with(graph.scopes[top].path + ".");
    if (below && types.insert(scope.type).second) scopes.push_back(s);
  }
  return scopes;
}

// One PDF with all pages; in other formats a file for each, loop.controller.svg beside loop.svg.
int write_pages(const std::string& out, const std::string& format, const std::vector<Page>& pages) {
  const auto write = [](const std::string& path, std::string_view bytes) {
    const std::string error = write_file(path, bytes);
    if (!error.empty()) complain(fmt::format("cannot write '{}': {}", path, error));
    return error.empty() ? done : run_failed;
  };
  try {
    if (format == "pdf") {
      std::vector<Scene> scenes;
      for (const Page& page : pages) scenes.push_back(page.scene);
      return write(out, to_pdf(scenes));
    }
    const std::string stem = out.substr(0, out.size() - format.size());
    for (std::size_t i = 0; i < pages.size(); ++i) {
      const std::vector<std::uint8_t> bytes = picture(pages[i].scene, format);
      const std::string path = i == 0 ? out : stem + pages[i].path + "." + format;
      const int status = write(path, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
      if (status != done) return status;
    }
    return done;
  } catch (const RenderError& e) {
    complain(fmt::format("cannot draw '{}': {}", out, e.what()));
    return run_failed;
  }
}

// The values of a saved run at a time, by signals; vectors as their elements in brackets. Nothing after complaining.
std::optional<std::map<std::string, std::string>> values_of(const DrawOptions& o) {
  std::map<std::string, std::string> values;
  if (o.values.empty()) return values;
  const FileResult file = read_file(o.values, std::size_t{16} << 30);
  const RecordingResult read = file.ok() ? from_npz(file.value) : RecordingResult{};
  if (!file.ok() || !read.ok()) {
    complain(fmt::format("--values: cannot read '{}': {}; it is made by run --out FILE.npz", o.values,
                         file.ok() ? read.error : file.error));
    return std::nullopt;
  }
  const std::vector<double>& time = read.recording.time();
  const auto after = std::upper_bound(time.begin(), time.end(), o.at);
  if (after == time.begin()) {
    complain(fmt::format("--at {:g}: {} begins at {:g} s", o.at, o.values, time.empty() ? 0.0 : time.front()));
    return std::nullopt;
  }
  const auto row = static_cast<std::size_t>(after - time.begin() - 1);
  std::map<std::string, std::vector<std::string>> vectors;
  for (std::size_t c = 0; c < read.recording.columns.size(); ++c) {
    const std::string& name = read.recording.columns[c].name;
    const std::string text =
        pretty_number(std::strtod(fmt::format("{:.4g}", read.recording.at(row, c)).c_str(), nullptr));
    values[name] = "= " + text;
    const std::size_t dot = name.rfind('.');
    if (dot != std::string::npos && name.find_first_not_of("0123456789", dot + 1) == std::string::npos)
      vectors[name.substr(0, dot)].push_back(text);
  }
  for (auto& [name, elements] : vectors) {
    if (elements.size() > 3) {
      elements.resize(3);
      elements.emplace_back("...");
    }
    values[name] = fmt::format("= [{}]", fmt::join(elements, ", "));
  }
  return values;
}

int draw_diagram(const DrawOptions& o) {
  const std::string format = format_of(o.out);
  if (format.empty()) return input_wrong;
  Report report;
  const std::shared_ptr<const Model> model = read_model(o.file, report, plot_words());
  std::shared_ptr<const Graph> graph;
  if (model && !report.has_errors()) graph = elaborate(model, {}, report);
  if (!graph || report.has_errors()) {
    print(report);
    return input_wrong;
  }
  const auto scope = scope_of(*graph, o);
  if (!scope) return input_wrong;
  DrawingHints hints;
  if (!o.hints.empty()) {
    auto read = read_hints(o.hints, *graph, report);
    print(report);
    if (!read) return input_wrong;
    hints = *std::move(read);
  }
  auto values = values_of(o);
  if (!values) return input_wrong;
  const auto shows = [&](const char* what) { return std::find(o.show.begin(), o.show.end(), what) != o.show.end(); };
  const SheetOptions options{.depth = o.depth,
                             .rates = shows("rates"),
                             .sizes = shows("sizes"),
                             .units = shows("units"),
                             .values = *std::move(values),
                             .hidden = hints.hidden};
  std::vector<Page> pages;
  for (const std::uint32_t s : o.pages ? scopes_below(*graph, *scope) : std::vector{*scope}) {
    const Sheet sheet = sheet_of(*graph, s, options);
    if (sheet.blocks.empty()) continue;
    try {
      pages.push_back({graph->scopes[s].path, draw(sheet, arrange(sheet, hints.directions), o.theme)});
    } catch (const RenderError& e) {
      complain(fmt::format("cannot draw '{}': {}", o.out, e.what()));
      return run_failed;
    }
  }
  if (pages.empty()) {
    complain(fmt::format("{} has no blocks, so there is nothing to draw", o.file));
    return input_wrong;
  }
  return write_pages(o.out, format, pages);
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
  parser.add_flag("--pages", o->pages,
                  "draw each type of subsystem, too: a page of its own in a .pdf, else a file of its own");
  parser.add_option("--hints", o->hints, "a YAML file with lists of names: forward, feedback, hide")->type_name("FILE");
  parser.add_option("--theme", o->theme, "how it looks")->check(CLI::IsMember(theme_names()))->capture_default_str();
  parser
      .add_option("--show", o->show,
                  "what else is written: rates below the blocks, sizes and units on the wires; separated by commas")
      ->delimiter(',')
      ->check(CLI::IsMember({"rates", "sizes", "units"}));
  parser.add_option("--values", o->values, "a result of a run, .npz: the signals' values stand on the wires")
      ->type_name("RESULT");
  parser.add_option("--at", o->at, "the time of the values, in s; by default the end of the run")->type_name("T");
  parser.footer(
      "Examples:\n"
      "  plantloop draw loop.yaml -o loop.svg\n"
      "  plantloop draw loop.yaml -o loop.png --depth 1 --show rates,sizes\n"
      "  plantloop draw loop.yaml -o controller.pdf --inside controller\n"
      "  plantloop run loop.yaml --out loop.npz && plantloop draw loop.yaml -o loop.svg --values loop.npz");
  return [o] { return draw_diagram(*o); };
}
