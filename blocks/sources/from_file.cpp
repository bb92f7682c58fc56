// Measured signals from a CSV file.

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/csv.h"
#include "engine/base/files.h"
#include "engine/block.h"
#include "engine/program/kernel.h"

namespace plantloop {
namespace {

struct Signals {
  std::vector<double> time;
  std::vector<std::vector<double>> values;
};

// How many rows have passed -> the line that holds now: values, slopes, and the time from which it counts.
class RowOfFile final : public Kernel {
 public:
  RowOfFile(Signals signals, bool linear) : signals_(std::move(signals)), linear_(linear) {}
  std::string name() const override { return "rows of a file"; }
  int outputs() const override { return static_cast<int>(2 * signals_.values.size() + 1); }
  void evaluate(const KernelCall& call) const override {
    const std::size_t rows = signals_.time.size(), width = signals_.values.size();
    const auto passed = static_cast<std::size_t>(call.in[0]);
    const std::size_t row = std::min(passed == 0 ? 0 : passed - 1, rows - 1);
    const bool between = linear_ && passed > 0 && passed < rows;
    for (std::size_t i = 0; i < width; ++i) {
      const std::vector<double>& values = signals_.values[i];
      call.out[i] = values[row];
      call.out[width + i] =
          between ? (values[row + 1] - values[row]) / (signals_.time[row + 1] - signals_.time[row]) : 0;
    }
    call.out[2 * width] = signals_.time[row];
  }

 private:
  Signals signals_;
  bool linear_;
};

struct FromFile final : Block {
  static constexpr auto summary = "Give signals that are read from a CSV file.";
  static constexpr auto details =
      "The column `time_column` (default: the first one) holds ascending times in s, two rows of one time are a jump; "
      "`column` one or several signals (\"v\", \"v, i\"; default: the second one). interpolation hold: the value of "
      "the last row; linear: straight lines between the rows. Before the first row its values hold, after the last one "
      "those. The rows are stops of the solver, so their edges are exact. The file is read when the diagram is "
      "compiled.";
  static constexpr auto example = R"(
blocks: {v: {type: from_file, file: signals.csv, column: v}}
simulation: {stop: 4}
expect: [{signal: v, at: 1.2, value: 3}]
)";

  Text file{this, "file", {.doc = "the file, beside the diagram or below", .file = true}};
  Text column{this, "column", {.doc = "name of the column, or several with commas in between", .optional = true}};
  Text time_column{this, "time_column", {.doc = "name of the column of times", .optional = true}};
  Choice interpolation{this, "interpolation", {.of = {"hold", "linear"}, .doc = "what holds between the rows"}};
  Output y{this, "y", {.doc = "the signal, or a vector of several", .size = any_size}};

  void check(Checking& checking) const override {
    const auto problem = [&](const Declared& what, const std::string& text) { checking.problem(what, text); };
    load(problem);
  }
  void sizes(Sizing& sizing) const override {
    const std::size_t count = names().size();
    sizing.set(y, count < 2 ? Shape::scalar() : Shape::vector(static_cast<int>(count)));
  }

  void outputs(Now now, Out out) const override {
    const std::optional<Signals> signals = load([](const Declared&, const std::string&) {});
    if (!signals) return;  // reported by check()
    const auto width = static_cast<int>(signals->values.size());
    Array times(Shape::vector(static_cast<int>(signals->time.size())));
    for (int i = 0; i < times.size(); ++i) times[i] = signals->time[static_cast<std::size_t>(i)];
    const Value row = segment(times);
    const bool linear = interpolation.is("linear");
    const std::vector<Value> line = now.kernel(std::make_shared<RowOfFile>(*signals, linear), {row});
    Array value(width == 1 ? Shape::scalar() : Shape::vector(width));
    const Value elapsed = now.time() - line[static_cast<std::size_t>(2 * width)];
    for (int i = 0; i < width; ++i) {
      const auto at = static_cast<std::size_t>(i);
      value[i] = linear ? line[at] + line[at + static_cast<std::size_t>(width)] * elapsed : line[at];
    }
    out[y] = value;
  }

 private:
  std::vector<std::string> names() const {
    std::vector<std::string> names;
    std::istringstream text(column.value());
    for (std::string name; std::getline(text, name, ',');) {
      const std::size_t first = name.find_first_not_of(' '), last = name.find_last_not_of(' ');
      if (first != std::string::npos) names.push_back(name.substr(first, last - first + 1));
    }
    return names;
  }

  // The file's columns, or nothing after reporting what is wrong.
  template <typename Problem>
  std::optional<Signals> load(const Problem& problem) const {
    const FileResult bytes = read_file(file.value());
    if (!bytes.ok()) return std::nullopt;  // reported where the file is named
    const CsvResult csv = read_csv(bytes.value);
    if (!csv.ok()) {
      problem(file, fmt::format("cannot read '{}': line {}: {}", file.value(), csv.line, csv.error));
      return std::nullopt;
    }
    const CsvTable& table = csv.table;
    const auto find = [&](const Text& which, const std::string& name, int otherwise) -> const std::vector<double>* {
      const int index = name.empty() ? otherwise : table.find(name);
      if (index >= 0 && index < static_cast<int>(table.columns.size()))
        return &table.columns[static_cast<std::size_t>(index)];
      std::string known;
      for (const std::string& n : table.names) known += (known.empty() ? "" : ", ") + n;
      problem(which, name.empty()
                         ? fmt::format("'{}' has one column only: a time and a signal are needed", file.value())
                         : fmt::format("'{}' has no column '{}'; it has: {}", file.value(), name, known));
      return nullptr;
    };
    Signals signals;
    const std::vector<double>* time = find(time_column, time_column.value(), 0);
    if (time == nullptr) return std::nullopt;
    signals.time = *time;
    std::vector<std::string> wanted = names();
    if (wanted.empty()) wanted.emplace_back();
    for (const std::string& name : wanted) {
      const std::vector<double>* values = find(column, name, 1);
      if (values == nullptr) return std::nullopt;
      signals.values.push_back(*values);
    }
    if (!is_sound(signals, problem)) return std::nullopt;
    return signals;
  }

  template <typename Problem>
  bool is_sound(const Signals& signals, const Problem& problem) const {
    if (signals.time.empty()) {
      problem(file, fmt::format("'{}' has no rows", file.value()));
      return false;
    }
    for (std::size_t i = 0; i < signals.time.size(); ++i) {
      if (i > 0 && !(signals.time[i] >= signals.time[i - 1])) {
        problem(file, fmt::format("the times in '{}' must ascend, but row {} has {:g} s after {:g} s", file.value(),
                                  i + 1, signals.time[i], signals.time[i - 1]));
        return false;
      }
      for (const auto& values : signals.values) {
        if (std::isfinite(values[i]) && std::isfinite(signals.time[i])) continue;
        problem(file, fmt::format("row {} of '{}' has a number that is not finite", i + 1, file.value()));
        return false;
      }
    }
    return true;
  }
};

}  // namespace

PLANTLOOP_BLOCK(from_file, FromFile)

}  // namespace plantloop
