// Data sets as CSV files: which column is what, and how time advances.

#include "identify/data/data_csv.h"

#include <algorithm>
#include <cmath>

#include "engine/base/csv.h"
#include "engine/base/numbers.h"
#include "engine/base/report.h"
#include "engine/base/units.h"
#include "identify/error.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;

struct Roles {
  int time = -1, experiment = -1;
  std::vector<int> inputs, outputs;
};

std::string lower_case(std::string text) {
  for (char& c : text) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return text;
}

class Reader {
 public:
  Reader(const CsvTable& table, const std::string& file, const CsvColumns& wanted)
      : table_(table), file_(file), wanted_(wanted) {
    for (const std::string& name : table.names) channels_.push_back(channel_of(name));
    if (table.rows() == 0) fail("{} has a header and no rows", file);
  }

  DataSet read() {
    assign();
    DataSet data;
    for (const int c : roles_.inputs) data.inputs.push_back(channels_[static_cast<std::size_t>(c)]);
    for (const int c : roles_.outputs) data.outputs.push_back(channels_[static_cast<std::size_t>(c)]);
    if (roles_.outputs.empty())
      fail("{} has no output: a column whose name begins with y, or one named as output", file_);
    read_times();
    cut(data);
    data.Ts = sampling_time(data);
    check(data);
    return data;
  }

 private:
  int named(const std::string& name) const {
    std::vector<std::string> names;
    for (std::size_t i = 0; i < channels_.size(); ++i) {
      if (channels_[i].name == name) return static_cast<int>(i);
      names.push_back(channels_[i].name);
    }
    const std::string near = nearest(name, names);
    fail("{} has no column '{}'{}; it has: {}", file_, name, near.empty() ? "" : ", did you mean '" + near + "'",
         fmt::join(names, ", "));
  }

  void assign() {
    const bool told = !wanted_.inputs.empty() || !wanted_.outputs.empty();
    std::vector<std::string> others;
    for (std::size_t i = 0; i < channels_.size(); ++i) {
      const std::string& name = channels_[i].name;
      const int column = static_cast<int>(i);
      const std::string lower = lower_case(name);
      if (lower == "time" || (name == "t" && !is_wanted(name))) {
        if (roles_.time >= 0)
          fail("{} has two columns of times, '{}' and '{}'", file_, channel(roles_.time).name, name);
        roles_.time = column;
      } else if (lower == "experiment") {
        roles_.experiment = column;
      } else if (told) {
        continue;
      } else if (name.starts_with('u')) {
        roles_.inputs.push_back(column);
      } else if (name.starts_with('y')) {
        roles_.outputs.push_back(column);
      } else {
        others.push_back(name);
      }
    }
    for (const std::string& name : wanted_.inputs) roles_.inputs.push_back(named(name));
    for (const std::string& name : wanted_.outputs) roles_.outputs.push_back(named(name));
    if (others.empty()) return;
    fail(
        "{}: '{}' is no time and neither an input (u...) nor an output (y...); say which columns are inputs and "
        "outputs, the others are then left out",
        file_, fmt::join(others, "', '"));
  }

  bool is_wanted(const std::string& name) const {
    const auto in = [&](const std::vector<std::string>& list) {
      return std::find(list.begin(), list.end(), name) != list.end();
    };
    return in(wanted_.inputs) || in(wanted_.outputs);
  }

  const Channel& channel(int column) const { return channels_[static_cast<std::size_t>(column)]; }
  double at(int column, std::size_t row) const { return table_.columns[static_cast<std::size_t>(column)][row]; }
  std::uint32_t line(std::size_t row) const { return table_.lines[row]; }

  // In seconds, whatever unit the header gives.
  void read_times() {
    if (roles_.time < 0) return;
    times_ = table_.columns[static_cast<std::size_t>(roles_.time)];
    for (std::size_t row = 0; row < times_.size(); ++row) {
      if (!std::isfinite(times_[row])) fail("{}:{}: the time is missing", file_, line(row));
    }
    decimals_ = decimals_of(times_);
    const std::string& text = channel(roles_.time).unit;
    if (text.empty()) return;
    const std::variant<Unit, UnitError> found = parse_unit(text);
    const Unit* unit = std::get_if<Unit>(&found);
    if (unit == nullptr || !unit->same_dimension(std::get<Unit>(parse_unit("s"))))
      fail("{}: '{}' is no unit of time; times may be in s, ms, us, min, h or d", file_, text);
    factor_ = unit->factor;
    for (double& time : times_) time *= factor_;
  }

  // The most digits behind the point that a time has, up to 9.
  static int decimals_of(const std::vector<double>& times) {
    int most = 0;
    for (const double time : times) {
      while (most < 9) {
        const double scaled = time * std::pow(10, most);
        if (std::fabs(scaled - std::round(scaled)) <= 1e-14 * std::fabs(scaled)) break;
        ++most;
      }
    }
    return most;
  }

  void cut(DataSet& data) {
    std::size_t begin = 0;
    for (std::size_t row = 1; row <= table_.rows(); ++row) {
      const bool ends = row == table_.rows() ||
                        (roles_.experiment >= 0 && at(roles_.experiment, row) != at(roles_.experiment, begin));
      if (!ends) continue;
      Experiment e;
      e.name =
          roles_.experiment >= 0 ? name_of_experiment(data, begin) : fmt::format("{}", data.experiments.size() + 1);
      e.start = roles_.time >= 0 ? times_[begin] : 0;
      e.u = block(roles_.inputs, begin, row);
      e.y = block(roles_.outputs, begin, row);
      data.experiments.push_back(std::move(e));
      begin = row;
    }
  }

  std::string name_of_experiment(const DataSet& data, std::size_t row) const {
    const double number = at(roles_.experiment, row);
    if (std::isnan(number)) fail("{}:{}: the number of the experiment is missing", file_, line(row));
    const std::string name = shortest(number);
    for (const Experiment& earlier : data.experiments) {
      if (earlier.name == name)
        fail("{}:{}: experiment {} goes on after another one began; the rows of an experiment must stand together",
             file_, line(row), name);
    }
    return name;
  }

  Eigen::MatrixXd block(const std::vector<int>& columns, std::size_t begin, std::size_t end) const {
    Eigen::MatrixXd values(static_cast<Index>(end - begin), static_cast<Index>(columns.size()));
    for (std::size_t c = 0; c < columns.size(); ++c) {
      for (std::size_t row = begin; row < end; ++row) {
        values(static_cast<Index>(row - begin), static_cast<Index>(c)) = at(columns[c], row);
      }
    }
    return values;
  }

  double sampling_time(const DataSet& data) const {
    if (roles_.time < 0) {
      if (!wanted_.Ts) fail("{} has no column 'time': give the sampling time Ts in s", file_);
      return *wanted_.Ts;
    }
    double Ts = 0;
    std::size_t begin = 0;
    for (const Experiment& e : data.experiments) {
      const auto count = static_cast<std::size_t>(e.samples());
      if (count > 1 && is_on_grid(begin, count)) {
        Ts = *wanted_.Ts;
      } else if (count > 1) {
        const double own = (times_[begin + count - 1] - e.start) / static_cast<double>(count - 1);
        check_steps(begin, count, own);
        if (Ts > 0 && std::fabs(own - Ts) > tolerance(count, Ts)) {
          fail("{}: the sampling time is {:.6g} s in one experiment and {:.6g} s in another", file_, Ts, own);
        }
        if (!(Ts > 0)) Ts = own;
      }
      begin += count;
    }
    if (!(Ts > 0)) {
      if (wanted_.Ts) return *wanted_.Ts;
      fail("{} has one sample{}: give the sampling time Ts in s", file_,
           data.experiments.size() > 1 ? " in each experiment" : "");
    }
    if (wanted_.Ts && std::fabs(*wanted_.Ts - Ts) > tolerance(data.samples(), Ts)) {
      fail("{}: Ts is given as {} s, but its times are {:.6g} s apart", file_, *wanted_.Ts, Ts);
    }
    // Sums of rounded times leave noise in the last digits.
    return wanted_.Ts ? *wanted_.Ts : *parse_number(fmt::format("{:.10g}", Ts));
  }

  // How well `count` rounded times tell the step between them.
  double tolerance(std::size_t count, double Ts) const { return tolerance(static_cast<Index>(count), Ts); }
  double tolerance(Index count, double Ts) const {
    return 1e-3 * Ts + 2 * rounding() / static_cast<double>(std::max<Index>(1, count - 1));
  }

  // Half of the last digit that the times have, in s.
  double rounding() const { return decimals_ >= 9 ? 0 : 0.5 * factor_ * std::pow(10, -decimals_); }
  // The same for a sampling time: digits that hold it round nothing away.
  double rounding(double Ts) const {
    const double units = 0.5 * Ts / rounding();
    return std::fabs(units - std::round(units)) <= 1e-6 ? 0 : rounding();
  }

  // How far a time may be from where it belongs: what the digits of the column, six digits of a number or single
  // precision round away, as far as no lost sample hides in it.
  double slack(double time, double Ts) const {
    const double digits = rounding() <= 0.25 * Ts ? rounding() : 0;
    if (time == 0) return 0.05 * Ts + digits;
    const double six = 0.5 * factor_ * std::pow(10, std::floor(std::log10(std::fabs(time / factor_))) - 5);
    return 0.05 * Ts + std::max(digits, std::min(0.4 * Ts, six));
  }

  // Whether every time belongs to an instant of the sampling time that was given: it is nearest to it, or the digits of
  // the times tell no more.
  bool is_on_grid(std::size_t begin, std::size_t count) const {
    if (!wanted_.Ts) return false;
    double least = HUGE_VAL, most = -HUGE_VAL;
    for (std::size_t i = 0; i < count; ++i) {
      const double late = times_[begin + i] - static_cast<double>(i) * *wanted_.Ts;
      least = std::min(least, late);
      most = std::max(most, late);
    }
    return most - least <= std::max(0.98 * *wanted_.Ts, 0.1 * *wanted_.Ts + 2 * rounding(*wanted_.Ts));
  }

  void check_steps(std::size_t begin, std::size_t count, double Ts) const {
    const auto time = [&](std::size_t i) { return times_[begin + i]; };
    // The straight line through all times: the first and the last one are rounded too.
    double offset = 0, moment = 0, squares = 0;
    const double middle = 0.5 * static_cast<double>(count - 1);
    for (std::size_t i = 0; i < count; ++i) {
      const double from_middle = static_cast<double>(i) - middle,
                   late = time(i) - time(0) - static_cast<double>(i) * Ts;
      offset += late / static_cast<double>(count);
      moment += from_middle * late;
      squares += from_middle * from_middle;
    }
    const auto line_at = [&](std::size_t i) {
      const double index = static_cast<double>(i);
      return time(0) + index * Ts + offset + moment / squares * (index - middle);
    };
    const auto is_off = [&](std::size_t i) {
      const double step = time(i) - time(i - 1), slack_here = slack(time(i), Ts);
      return step <= 0 || std::fabs(step - Ts) > 2 * slack_here || std::fabs(time(i) - line_at(i)) > slack_here;
    };
    bool even = Ts > 0;
    for (std::size_t i = 1; i < count && even; ++i) even = !is_off(i);
    if (!even) refuse_steps(begin, count);
  }

  // One gap moves the mean; the row to show is the one whose step is farthest from most of them.
  [[noreturn]] void refuse_steps(std::size_t begin, std::size_t count) const {
    std::vector<double> steps;
    for (std::size_t i = 1; i < count; ++i) steps.push_back(times_[begin + i] - times_[begin + i - 1]);
    std::vector<double> sorted = steps;
    std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2), sorted.end());
    const double usual = sorted[sorted.size() / 2];
    if (!(usual > 0)) {
      const auto first = std::find_if(steps.begin(), steps.end(), [](double step) { return step <= 0; });
      const std::size_t row = begin + static_cast<std::size_t>(first - steps.begin()) + 1;
      fail("{}:{}: the time goes from {:.10g} s to {:.10g} s; {}", file_, line(row), times_[row - 1], times_[row],
           times_must_grow);
    }
    const auto odd =
        std::count_if(steps.begin(), steps.end(), [&](double step) { return std::fabs(step - usual) > 0.3 * usual; });
    const bool is_uneven = static_cast<double>(odd) > 0.1 * static_cast<double>(steps.size()) + 1;
    const auto farthest = std::max_element(
        steps.begin(), steps.end(), [&](double a, double b) { return std::fabs(a - usual) < std::fabs(b - usual); });
    const std::size_t row = begin + static_cast<std::size_t>(farthest - steps.begin()) + 1;
    const auto text = [&](std::size_t i) { return fmt::format("{:.10g} s", times_[i]); };
    fail("{}:{}: the time goes from {} to {}, but most steps are {:.6g} s; {}", file_, line(row), text(row - 1),
         text(row), usual, is_uneven ? times_are_uneven : advice_on(*farthest, usual));
  }

  static constexpr std::string_view times_must_grow =
      "times must grow: take out rows that stand twice, and where a record begins anew number the parts in a column "
      "'experiment'";
  static constexpr std::string_view times_are_uneven =
      "the times of an experiment must grow evenly: resample the record, or give the sampling time Ts if the times are "
      "only "
      "rounded";
  static std::string_view advice_on(double step, double usual) {
    if (step <= 0) return times_must_grow;
    if (step < 1.5 * usual) return times_are_uneven;
    return "leave the cells of missing samples empty, or number the parts of the record in a column 'experiment'";
  }

  const CsvTable& table_;
  const std::string& file_;
  const CsvColumns& wanted_;
  std::vector<Channel> channels_;
  Roles roles_;
  std::vector<double> times_;  // s
  double factor_ = 1;          // of the header's unit of time, in s
  int decimals_ = 9;           // of the times as they stand in the file
};

}  // namespace

Channel channel_of(const std::string& header) {
  const bool round = header.ends_with(')');
  const std::size_t open = header.find(round ? '(' : '[');
  if (open == std::string::npos || !(round || header.ends_with(']'))) return {header, ""};
  std::string name = header.substr(0, open);
  while (name.ends_with(' ')) name.pop_back();
  const std::string unit = header.substr(open + 1, header.size() - open - 2);
  // Round brackets may belong to a name: y(1), T (inlet).
  if (round && (open == 0 || header[open - 1] != ' ' || std::holds_alternative<UnitError>(parse_unit(unit))))
    return {header, ""};
  return {name, unit};
}

DataSet read_data_csv(std::string_view text, const std::string& file, const CsvColumns& columns) {
  const CsvResult result = read_csv(text, MissingCells::as_nan);
  if (!result.ok()) fail("{}:{}:{}: {}", file, result.line, result.column, result.error);
  return Reader(result.table, file, columns).read();
}

std::string to_csv(const DataSet& data) {
  const bool several = data.experiments.size() > 1;
  std::string text = several ? "experiment,time" : "time";
  for (const auto* channels : {&data.inputs, &data.outputs}) {
    for (const Channel& c : *channels) text += c.unit.empty() ? "," + c.name : fmt::format(",{} [{}]", c.name, c.unit);
  }
  text += '\n';
  std::size_t number = 0;
  for (const Experiment& e : data.experiments) {
    ++number;
    for (Index k = 0; k < e.samples(); ++k) {
      if (several) text += fmt::format("{},", number);
      text += digits17(e.start + static_cast<double>(k) * data.Ts);
      for (const Eigen::MatrixXd* m : {&e.u, &e.y}) {
        for (Index c = 0; c < m->cols(); ++c) text += std::isnan((*m)(k, c)) ? "," : "," + digits17((*m)(k, c));
      }
      text += '\n';
    }
  }
  return text;
}

}  // namespace plantloop::identify
