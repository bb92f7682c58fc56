// What a run recorded: one table over the union of times, and which rows are whose native samples.

#pragma once

#include <cassert>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace plantloop {

struct RecordedColumn {
  std::string name;  // as `record` says, elements with a dot: "xh.3"
  std::string unit;
  int rate = 0;                         // 0: continuous; else index into Recording::hits
  bool hidden = false;                  // logged for figures and expect only, not written
  std::vector<std::string> names = {};  // of a state machine's state: what the numbers from 1 are called
};

// Rows are in order of time; a jump gives two rows of equal time, the left side first. Discrete columns hold between
// their hits.
class Recording {
 public:
  std::vector<RecordedColumn> columns;
  std::vector<std::vector<std::size_t>> hits;         // rows at which a rate had a hit; [0] is unused
  std::vector<std::pair<double, double>> rates;       // period and offset in s; [0] is unused
  std::map<std::string, std::string> provenance;      // diagram, title, engine version, solver, options, overrides
  std::map<std::string, std::vector<double>> events;  // times of each event function by name, "h.reset"

  // All columns at times that were asked for, exactly: on both sides, should something jump there.
  struct Sample {
    double time = 0;
    std::vector<double> left, right;  // empty when the run did not get there
  };
  std::vector<Sample> samples;  // in order of time
  // The value of a column at a sampled time, or NaN.
  double sampled(std::size_t column, double time, bool left = false) const;

  std::size_t rows() const { return time_.size(); }
  const std::vector<double>& time() const { return time_; }
  // -1: left side of a jump, 1: its right side, 0: neither.
  const std::vector<std::int8_t>& side() const { return side_; }
  double at(std::size_t row, std::size_t column) const { return values_[row * columns.size() + column]; }
  // A column's values in all rows.
  std::vector<double> column(std::size_t index) const;
  // Index of a column by name, or -1.
  int find(std::string_view name) const;

  // Appends a row; room grows by doubling. `limit_rows` and memory are checked by the caller between steps.
  void append(double time, std::int8_t side, std::span<const double> row) {
    assert(row.size() == columns.size());
    assert(time_.empty() || time >= time_.back());
    if (values_.size() + row.size() > values_.capacity()) reserve(2 * rows() + 64);
    for (const double value : row) values_.push_back(value);
    time_.push_back(time);
    side_.push_back(side);
  }
  void reserve(std::size_t rows);
  void mark_hit(int rate) { hits[static_cast<std::size_t>(rate)].push_back(time_.size() - 1); }
  void set_side(std::size_t row, std::int8_t side) { side_[row] = side; }
  void remove_last_row();

  // The value of a column at time t by linear interpolation between rows (held for discrete columns); at a jump the
  // right side unless `left`.
  double value(std::size_t column, double t, bool left = false) const;

 private:
  std::vector<double> time_;
  std::vector<std::int8_t> side_;
  std::vector<double> values_;
};

// CSV: first column `time`, then the columns that are not hidden, 17 significant digits.
std::string to_csv(const Recording& recording);
// The same in parts of some 64 kB, for results that should not stand in memory a second time.
void write_csv(const Recording& recording, const std::function<void(std::string_view)>& write);
// JSON and NPZ keep native rates (each column its own times), the side, units and provenance.
std::string to_json(const Recording& recording);
std::string to_npz(const Recording& recording);

// A recording read back, or why there is none, in words that follow "cannot read 'x': ".
struct RecordingResult {
  Recording recording;
  std::string error;
  bool ok() const { return error.empty(); }
};
// Reads what to_npz wrote. A discrete column holds its first sample before its first hit.
RecordingResult from_npz(std::string_view bytes);

}  // namespace plantloop
