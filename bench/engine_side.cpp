// The engine's side of a benchmark: a diagram file, read and compiled as the program does it, then run in this process.

#include <stdexcept>

#include "bench/measured.h"
#include "engine/run/diagram.h"

namespace plantloop::bench {

Measured run_plantloop(const std::string& yaml_path) {
  Report report;
  const auto diagram = Diagram::load(yaml_path, report);
  const auto run = diagram ? diagram->run({}, report) : std::nullopt;
  if (!run || report.has_errors()) throw std::runtime_error(to_text(report));
  const Recording& recording = run->recording;
  return {run->timing.simulate, recording.at(recording.rows() - 1, recording.columns.size() - 1)};
}

}  // namespace plantloop::bench
