// Runs of the book's diagrams, and what tests ask of them.

#pragma once

#include <string>
#include <vector>

#include "engine/run/diagram.h"

namespace plantloop::testing_book {

// How a signal answers a step of its set point, as the book's tables say it.
struct Answer {
  double overshoot = 0;  // %
  double settling = 0;   // s, the last time outside of 2 %; infinite when that is the end
  double rise = 0;       // s, the first time at 63.2 %
};

struct Step {
  double at = 0, until = 0;  // s
  double from = 0, to = 0;
};

class BookRun {
 public:
  explicit BookRun(DiagramRun run) : run_(std::move(run)) {}
  // A column's value; exact where a row stands, else on the straight line between rows.
  double at(const std::string& column, double time) const;
  double measure(const std::string& column, const std::string& name) const;
  Answer answer(const std::string& column, const Step& step) const;
  // The expectations of the diagram that are not met, one a line.
  std::string unmet() const;

 private:
  std::size_t index(const std::string& column) const;
  DiagramRun run_;
};

// Throws std::runtime_error with the findings when the diagram is wrong.
BookRun run_file(const std::string& path, const RunRequest& request = {});
BookRun run_text(const std::string& text, const RunRequest& request = {});
// The findings on a diagram as a user would read them; "" when there are none.
std::string findings(const std::string& text);

}  // namespace plantloop::testing_book
