// plantloop plot: a diagram's figures from a result that a run saved, without running again.

#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "app/command.h"
#include "app/draw.h"
#include "app/request.h"
#include "engine/base/files.h"
#include "render/image.h"

namespace plantloop::app {

namespace {

struct PlotOptions {
  std::string result, file, figures = "out", format = "png";
};

// What the figures show and the result does not have.
std::vector<std::string> missing_signals(const Model& model, const DiagramRun& run) {
  std::vector<std::string> missing;
  for (const FigureDecl& figure : model.figures) {
    for (const ExpressionPtr& signal : figure.signals()) {
      if (run.shown.contains(signal.get())) continue;
      const std::string name = to_string(*signal);
      if (std::find(missing.begin(), missing.end(), name) == missing.end()) missing.push_back(name);
    }
  }
  return missing;
}

int plot(const PlotOptions& o) {
  if (extension_of(o.result) != ".npz") {
    complain(
        fmt::format("{}: figures are drawn from a .npz file, which keeps each signal's own times: run with --out "
                    "FILE.npz",
                    o.result));
    return input_wrong;
  }
  const FileResult file = read_file(o.result, std::size_t{16} << 30);
  if (!file.ok()) {
    complain(fmt::format("cannot read '{}': {}", o.result, file.error));
    return input_wrong;
  }
  RecordingResult read = from_npz(file.value);
  if (!read.ok()) {
    complain(fmt::format("cannot read '{}': {}", o.result, read.error));
    return input_wrong;
  }
  Report report;
  const auto diagram = load_diagram(o.file, report);
  if (!diagram) return input_wrong;
  Overrides set;  // the result was made with these
  for (const auto& [key, value] : read.recording.provenance) {
    if (key.rfind("set ", 0) == 0) set.push_back({key.substr(4), value});
  }
  const auto run = diagram->replay(std::move(read.recording), set, report);
  print(report);
  if (!run) return input_wrong;
  const std::vector<std::string> missing = missing_signals(diagram->model(), *run);
  if (!missing.empty()) {
    complain(fmt::format("{} does not have what the figures show: {}. Name it in 'record:', too, and run again",
                         o.result, fmt::join(missing, ", ")));
    return input_wrong;
  }
  const std::string error = write_figures(diagram->model(), *run, o.figures, split_formats(o.format));
  if (error.empty()) return done;
  complain(error);
  return run_failed;
}

}  // namespace

}  // namespace plantloop::app

PLANTLOOP_COMMAND(plot) {
  using namespace plantloop::app;
  const auto o = std::make_shared<PlotOptions>();
  parser.description("Draw a diagram's figures again from a saved result, without running.");
  parser.add_option("RUN", o->result, "what run --out wrote, a .npz file")->required();
  parser.add_option("DIAGRAM", o->file, "the diagram whose figures are drawn")->required();
  parser.add_option("--figures", o->figures, "folder for the figures, <figure name>.<format>")
      ->type_name("DIR")
      ->capture_default_str();
  parser
      .add_option(
          "--format", o->format,
          fmt::format("formats of the figures, separated by commas: {}", fmt::join(plantloop::picture_formats(), ", ")))
      ->capture_default_str();
  parser.footer(
      "Example:\n  plantloop run loop.yaml --out loop.npz && plantloop plot loop.npz loop.yaml --figures out");
  return [o] { return plot(*o); };
}
