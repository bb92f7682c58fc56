// Files and texts to runs, runs to numbers.

#include "tests/book/book_runs.h"

#include <limits>
#include <stdexcept>
#include <utility>

#include "app/figures.h"
#include "engine/run/measures.h"

namespace plantloop::testing_book {
namespace {

BookRun run(const std::shared_ptr<Diagram>& diagram, const RunRequest& request, Report& report) {
  if (!diagram) throw std::runtime_error(to_text(report));
  auto result = diagram->run(request, report);
  if (!result) throw std::runtime_error(to_text(report));
  return BookRun(std::move(*result));
}

}  // namespace

std::size_t BookRun::index(const std::string& column) const {
  const int found = run_.recording.find(column);
  if (found < 0) throw std::runtime_error("there is no column '" + column + "'");
  return static_cast<std::size_t>(found);
}

double BookRun::at(const std::string& column, double time) const { return run_.recording.value(index(column), time); }

double BookRun::measure(const std::string& column, const std::string& name) const {
  return plantloop::measure(run_.recording, index(column), name);
}

Answer BookRun::answer(const std::string& column, const Step& step) const {
  const MeasureOptions options{.step = {step.at, step.until, step.from, step.to}};
  Answer answer{.overshoot = plantloop::measure(run_.recording, index(column), "overshoot", options),
                .settling = plantloop::measure(run_.recording, index(column), "settling_time", options),
                .rise = std::numeric_limits<double>::infinity()};
  const std::vector<double> y = run_.recording.column(index(column));
  for (std::size_t row = 0; row < y.size(); ++row) {
    const double time = run_.recording.time()[row];
    const double part = (y[row] - step.from) / (step.to - step.from);
    if (time < step.at || time > step.until || part < 0.632) continue;
    answer.rise = time - step.at;
    break;
  }
  return answer;
}

std::string BookRun::unmet() const {
  std::string lines;
  for (const Verdict& verdict : run_.verdicts) {
    if (!verdict.met) lines += verdict.text + ": " + verdict.measured + "\n";
  }
  return lines;
}

BookRun run_file(const std::string& path, const RunRequest& request) {
  Report report;
  return run(Diagram::load(path, report, plot_words()), request, report);
}

BookRun run_text(const std::string& text, const RunRequest& request) {
  Report report;
  return run(Diagram::from_text(text, "test.yaml", report), request, report);
}

std::string findings(const std::string& text) {
  Report report;
  const auto diagram = Diagram::from_text(text, "test.yaml", report);
  if (diagram) diagram->check({}, report);
  return to_text(report);
}

}  // namespace plantloop::testing_book
