// plantloop run: simulates a diagram; the result to a file, the figures to a folder, a summary to the terminal.

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <memory>

#include "app/command.h"
#include "app/draw.h"
#include "app/figures.h"
#include "app/progress.h"
#include "app/request.h"
#include "engine/base/error.h"
#include "engine/base/files.h"
#include "engine/run/checkpoint.h"
#include "engine/run/diagram.h"
#include "engine/solve/integrator.h"
#include "render/image.h"

namespace plantloop::app {

namespace {

struct RunOptions {
  std::string file;
  std::vector<std::string> set;
  std::string out;
  std::string figures;
  std::string format = "png";
  std::string solver;
  std::string save, from;
  std::vector<double> save_at;
  bool partial = false;
  double stop = NAN, step = NAN, rtol = NAN, atol = NAN, max_time = 0;
  bool timing = false;
  bool strict = false;
  bool quiet = false;
};

double seconds() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

std::optional<double> given(double value) { return std::isnan(value) ? std::nullopt : std::optional(value); }

std::string summary(const Diagram& diagram, const DiagramRun& run) {
  const auto& s = run.statistics;
  std::string text;
  if (!diagram.model().title.empty()) text += diagram.model().title + "\n";
  text += fmt::format("{} steps", s.solver.steps);
  if (s.solver.rejected > 0) text += fmt::format(" ({} rejected)", s.solver.rejected);
  text += fmt::format(", {} events, {} rows, to time {:g} s in {:.3f} s\n", s.events, s.rows,
                      run.recording.rows() > 0 ? run.recording.time().back() : run.options.start, run.timing.simulate);
  if (!s.ended_by.empty()) text += fmt::format("ended by '{}'\n", s.ended_by);
  std::size_t width = 0;
  for (const auto& column : run.recording.columns) {
    if (!column.hidden) width = std::max(width, column.name.size());
  }
  for (std::size_t i = 0; i < run.recording.columns.size() && run.recording.rows() > 0; ++i) {
    const auto& column = run.recording.columns[i];
    if (column.hidden) continue;
    const double value = run.recording.at(run.recording.rows() - 1, i);
    text += fmt::format("  {:<{}}  {:.9g}", column.name, width, value);
    const auto number = static_cast<std::size_t>(value);
    if (number >= 1 && number <= column.names.size()) text += fmt::format(" ({})", column.names[number - 1]);
    text += column.unit.empty() ? "\n" : " " + column.unit + "\n";
  }
  return text;
}

std::string verdicts(const DiagramRun& run) {
  std::string text;
  for (const Verdict& v : run.verdicts) {
    text += fmt::format("  {}  {}: {}\n", v.met ? "met    " : "NOT met", v.text, v.measured);
  }
  return text.empty() ? text : "expect:\n" + text;
}

std::string bytes_of(const Recording& recording, const std::string& path) {
  const std::string extension = extension_of(path);
  return extension == ".json" ? to_json(recording) : extension == ".npz" ? to_npz(recording) : to_csv(recording);
}

// Said now: a long run must not end with a result that has no place.
bool can_be_written(const char* option, const std::string& given, const std::string& file) {
  const std::string why = why_not_writable(file);
  if (!why.empty()) complain(fmt::format("{} {}: it cannot be written: {}", option, given, why));
  return why.empty();
}

bool check_paths(const RunOptions& o) {
  if (!o.out.empty() && o.out != "-") {
    const std::string extension = extension_of(o.out);
    if (extension != ".csv" && extension != ".json" && extension != ".npz") {
      complain(fmt::format("--out {}: the name must end in .csv, .json or .npz", o.out));
      return false;
    }
    if (!can_be_written("--out", o.out, o.out)) return false;
  }
  if (!o.save.empty() && !can_be_written("--save", o.save, o.save)) return false;
  if (!o.figures.empty() && !can_be_written("--figures", o.figures, o.figures + "/figure")) return false;
  const std::vector<std::string> formats = picture_formats();
  for (const std::string& format : split_formats(o.format)) {
    if (std::find(formats.begin(), formats.end(), format) != formats.end()) continue;
    complain(fmt::format("--format {}: there is no figure format '{}'; there are: {}", o.format, format,
                         fmt::join(formats, ", ")));
    return false;
  }
  return true;
}

// Where to go on from; false after complaining.
bool read_checkpoint(const std::string& path, RunControl& control) {
  const FileResult file = read_file(path, std::size_t{4} << 30);
  CheckpointResult read;
  if (file.ok()) read = checkpoint_from_json(file.value);
  const std::string& error = file.ok() ? read.error : file.error;
  if (!error.empty()) {
    complain(fmt::format("cannot read '{}': {}", path, error));
    return false;
  }
  control.from = std::make_shared<const Checkpoint>(std::move(read.checkpoint));
  return true;
}

// Of a run that failed or was stopped: beside the place of the result, which stays as it was.
void keep_what_there_is(const Recording& recording, const std::string& out) {
  if (out.empty() || out == "-" || recording.rows() == 0) return;
  std::filesystem::path path(out);
  path.replace_filename(path.stem().string() + ".partial" + path.extension().string());
  if (write_result(path.string(), bytes_of(recording, out)))
    fmt::print(stderr, "plantloop: what was recorded until then is in '{}'\n", path.string());
}

int run_diagram(const RunOptions& o) {
  RunRequest request;
  if (!read_overrides(o.set, request.set) || !check_paths(o)) return input_wrong;
  request.stop = given(o.stop);
  request.step = given(o.step);
  request.rtol = given(o.rtol);
  request.atol = given(o.atol);
  if (!o.solver.empty()) request.solver = o.solver;

  Report report;
  if (o.strict) report.make_strict();
  const auto diagram = Diagram::load(o.file, report, plot_words());
  if (!diagram || report.has_errors()) {
    if (diagram) diagram->check(request.set, report);
    print(report);
    return input_wrong;
  }
  if (!request.stop && !diagram->model().simulation.stop && !diagram->model().is_library) {
    complain(fmt::format("{} does not say when to stop: write  simulation: {{stop: 10}}  or give --stop 10", o.file));
    return input_wrong;
  }
  request.save_at = o.save_at;
  request.save_at_end = !o.save.empty() && o.save_at.empty();
  request.partial = o.partial;
  RunControl control;
  bool saved = true;
  if (!o.save.empty()) {
    control.save = [&](const Checkpoint& checkpoint) { saved = write_result(o.save, to_json(checkpoint)) && saved; };
  }
  if (!o.from.empty() && !read_checkpoint(o.from, control)) return input_wrong;
  Progress progress(!o.quiet);
  control.cancel = &interrupted;
  control.time_limit = o.max_time;
  control.progress = [&progress](double fraction) { progress(fraction); };
  std::optional<DiagramRun> run;
  DiagramRun so_far;
  try {
    run = diagram->run(request, report, control, &so_far);
  } catch (const RunError& e) {
    progress.clear();
    print(report);
    complain(e.what());
    keep_what_there_is(so_far.recording, o.out);
    return run_failed;
  }
  progress.clear();
  print(report);
  if (!run) return input_wrong;

  const double writing = seconds();
  bool written = saved;
  const bool on_terminal = is_terminal(STDOUT_FILENO);
  if (!o.out.empty() && o.out != "-") {
    written = write_result(o.out, bytes_of(run->recording, o.out));
  } else if (o.out == "-" || (!on_terminal && o.figures.empty())) {
    written = write_out(to_csv(run->recording));
  }
  if (!o.figures.empty()) {
    const std::string error = write_figures(diagram->model(), *run, o.figures, split_formats(o.format));
    if (!error.empty()) {
      complain(error);
      written = false;
    }
  }
  if (!o.quiet && on_terminal && o.out != "-") {
    written = write_out(summary(*diagram, *run) + verdicts(*run)) && written;
  } else if (!o.quiet) {
    fmt::print(stderr, "{}", verdicts(*run));
  }
  if (o.timing) {
    fmt::print(stderr, "timing: read {:.6f} compile {:.6f} simulate {:.6f} write {:.6f}\n", diagram->read_time(),
               run->timing.compile, run->timing.simulate, seconds() - writing);
  }
  return written && !report.has_errors() ? done : run_failed;
}

std::string solver_names() {
  std::string names;
  for (const SolverInfo& solver : solvers()) names += (names.empty() ? "" : ", ") + std::string(solver.name);
  return names;
}

}  // namespace

}  // namespace plantloop::app

PLANTLOOP_COMMAND(run) {
  using namespace plantloop::app;
  const auto o = std::make_shared<RunOptions>();
  parser.description(
      "Simulate a diagram. Without --out the result goes to standard output as CSV, on a terminal a summary is shown.");
  parser.add_option("DIAGRAM", o->file, "the diagram")->required();
  add_set_option(parser, o->set);
  parser.add_option("--stop", o->stop, "stop time in s");
  parser.add_option("--solver", o->solver, solver_names());
  parser.add_option("--step", o->step, "fixed step in s (euler, heun, rk4; also the other explicit ones)");
  parser.add_option("--rtol", o->rtol, "relative tolerance");
  parser.add_option("--atol", o->atol, "absolute tolerance");
  parser.add_option("--out", o->out, "file for the result: .csv, .json or .npz; - for standard output")
      ->type_name("FILE");
  parser.add_option("--figures", o->figures, "folder for the diagram's figures, <figure name>.<format>")
      ->type_name("DIR");
  parser
      .add_option(
          "--format", o->format,
          fmt::format("formats of the figures, separated by commas: {}", fmt::join(plantloop::picture_formats(), ", ")))
      ->capture_default_str();
  parser
      .add_option(
          "--save-at", o->save_at,
          "a save point, in s: the solver starts anew there, so that a run that saves and one that goes on agree "
          "to the last bit; any number of times")
      ->allow_extra_args(false)
      ->type_name("T");
  parser
      .add_option("--save", o->save,
                  "write a checkpoint at each save point (the last one stays), without any at the end")
      ->type_name("FILE");
  parser.add_option("--from", o->from, "go on from a checkpoint")->type_name("FILE");
  parser.add_flag("--partial", o->partial,
                  "go on from a checkpoint of a diagram that has changed since: the values of equal paths");
  parser.add_option("--max-time", o->max_time, "stop the run after this many seconds")->check(CLI::PositiveNumber);
  add_strict_option(parser, o->strict);
  parser.add_flag("--timing", o->timing, "print how long reading, compiling, simulating and writing took, in s");
  parser.add_flag("--quiet", o->quiet, "no summary, no progress");
  parser.footer(
      "Examples:\n"
      "  plantloop run loop.yaml\n"
      "  plantloop run loop.yaml --set controller.ki=20 --stop 5 --out loop.csv\n"
      "  plantloop run loop.yaml --figures out --format png,svg\n"
      "  plantloop run loop.yaml --stop 5 --save half.json && plantloop run loop.yaml --from half.json --stop 10");
  return [o] { return run_diagram(*o); };
}
