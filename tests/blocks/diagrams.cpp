// Text to recording in one call.

#include "tests/blocks/diagrams.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace plantloop::testing_diagrams {

std::size_t Signals::index(const std::string& name) const {
  const int found = run_.recording.find(name);
  if (found < 0) throw std::runtime_error("there is no column '" + name + "'");
  return static_cast<std::size_t>(found);
}

double Signals::at(const std::string& name, double t, bool left) const {
  return run_.recording.value(index(name), t, left);
}

double Signals::sampled(const std::string& name, double t) const {
  for (const auto& sample : run_.recording.samples) {
    if (sample.time == t) return sample.right[index(name)];
  }
  throw std::runtime_error("no `expect:` asks for a value at that time");
}

double Signals::last(const std::string& name) const {
  return run_.recording.at(run_.recording.rows() - 1, index(name));
}

std::vector<double> Signals::column(const std::string& name) const { return run_.recording.column(index(name)); }

std::vector<double> Signals::samples(const std::string& name) const {
  std::vector<double> all = column(name);
  const int rate = run_.recording.columns[index(name)].rate;
  if (rate == 0) return all;
  std::vector<double> samples;
  for (const std::size_t row : run_.recording.hits[static_cast<std::size_t>(rate)]) samples.push_back(all[row]);
  return samples;
}

double Signals::greatest(const std::string& name) const {
  double most = 0;
  for (const double v : column(name)) most = std::max(most, std::fabs(v));
  return most;
}

Signals run(const std::string& text, const RunRequest& request) {
  Report report;
  const auto diagram = Diagram::from_text("plantloop: 1\n" + text, "test.yaml", report);
  if (!diagram) throw std::runtime_error(to_text(report));
  auto result = diagram->run(request, report);
  if (!result) throw std::runtime_error(to_text(report));
  return Signals(std::move(*result));
}

std::string findings(const std::string& text) {
  Report report;
  const auto diagram = Diagram::from_text("plantloop: 1\n" + text, "test.yaml", report);
  if (diagram) diagram->check({}, report);
  return to_text(report);
}

}  // namespace plantloop::testing_diagrams
