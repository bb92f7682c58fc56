// What a fit tells about itself, as text and in model files.

#include "identify/fit_report.h"

namespace plantloop::identify {

std::string to_text(const FitReport& report) {
  std::string text = fmt::format("{}: {} parameters from {} rows\n", report.method, report.parameters, report.samples);
  for (const std::string& line : report.tried) text += fmt::format("  tried: {}\n", line);
  text += fmt::format("  reached: {:.6g}, {}\n", report.reached, report.measure);
  if (report.iterations > 0) text += fmt::format("  iterations: {}\n", report.iterations);
  if (!report.stopped.empty()) text += fmt::format("  stopped: {}\n", report.stopped);
  if (report.seed != 0) text += fmt::format("  seed: {}\n", report.seed);
  if (!report.options.empty()) text += fmt::format("  options: {}\n", fmt::join(report.options, ", "));
  if (!report.data.empty()) text += fmt::format("  data: {}\n", report.data);
  for (const std::string& line : report.warnings) text += fmt::format("  warning: {}\n", line);
  return text;
}

Item to_item(const FitReport& report) {
  Item item;
  item.set("method", report.method)
      .set("samples", report.samples)
      .set("parameters", report.parameters)
      .set("reached", report.reached)
      .set("measure", report.measure)
      .set("iterations", report.iterations)
      .set("stopped", report.stopped)
      .set("seed", report.seed)
      .set("data", report.data)
      .set("options", report.options)
      .set("tried", report.tried)
      .set("warnings", report.warnings);
  return item;
}

FitReport fit_report_of(const Item& item) {
  item.only({"method", "samples", "parameters", "reached", "measure", "iterations", "stopped", "seed", "data",
             "options", "tried", "warnings"});
  FitReport report;
  report.method = item.text("method");
  report.samples = item.integer("samples");
  report.parameters = item.integer("parameters");
  report.reached = item.number("reached");
  report.iterations = item.integer("iterations");
  report.stopped = item.text("stopped");
  report.seed = static_cast<std::uint64_t>(item.integer("seed"));
  // Files made by hand may leave these out.
  if (item.has("measure")) report.measure = item.text("measure");
  if (item.has("data")) report.data = item.text("data");
  if (item.has("options")) report.options = item.texts("options");
  report.tried = item.texts("tried");
  report.warnings = item.texts("warnings");
  return report;
}

void FitControl::step(double fraction) const {
  look();
  if (progress) progress(fraction);
}

void FitControl::look() const {
  if (cancel != nullptr && cancel->load(std::memory_order_relaxed)) throw Cancelled("the fit was stopped on request");
  if (deadline && std::chrono::steady_clock::now() > *deadline)
    throw Cancelled("the fit was stopped: its time was over");
}

}  // namespace plantloop::identify
