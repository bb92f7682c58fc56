// Data sets as CSV files: which column is what, and how time advances.

#include "identify/data/data_csv.h"

#include <algorithm>
#include <cmath>

#include "engine/base/csv.h"
#include "engine/base/numbers.h"
#include "engine/base/report.h"
#include "identify/error.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;

struct Roles {
  int time = -1, experiment = -1;
  std::vector<int> inputs, outputs;
};

class Reader {
 public:
  Reader(const CsvTable& table, const std::string& file, const CsvColumns& wanted)
      : table_(table), file_(file), wanted_(wanted) {
    for (const std::string& name : table.names) channels_.push_back(channel_of(name));
  }

  DataSet read() {
    assign();
    DataSet data;
    for (const int c : roles_.inputs) data.inputs.push_back(channels_[static_cast<std::size_t>(c)]);
    for (const int c : roles_.outputs) data.outputs.push_back(channels_[static_cast<std::size_t>(c)]);
    if (roles_.outputs.empty())
      fail("{} has no output: a column whose name begins with y, or one named as output", file_);
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
      if (name == "time" || name == "t") {
        roles_.time = column;
      } else if (name == "experiment") {
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

  double at(int column, std::size_t row) const { return table_.columns[static_cast<std::size_t>(column)][row]; }

  void cut(DataSet& data) {
    std::size_t begin = 0;
    for (std::size_t row = 1; row <= table_.rows(); ++row) {
      const bool ends = row == table_.rows() ||
                        (roles_.experiment >= 0 && at(roles_.experiment, row) != at(roles_.experiment, begin));
      if (!ends) continue;
      Experiment e;
      e.name = roles_.experiment >= 0 ? shortest(at(roles_.experiment, begin))
                                      : fmt::format("{}", data.experiments.size() + 1);
      e.start = roles_.time >= 0 ? at(roles_.time, begin) : 0;
      e.u = block(roles_.inputs, begin, row);
      e.y = block(roles_.outputs, begin, row);
      data.experiments.push_back(std::move(e));
      begin = row;
    }
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
      if (count > 1) {
        const double own = (at(roles_.time, begin + count - 1) - e.start) / static_cast<double>(count - 1);
        check_steps(begin, count, own);
        if (Ts > 0 && std::fabs(own - Ts) > 1e-3 * Ts) {
          fail("{}: the sampling time is {:.6g} s in one experiment and {:.6g} s in another", file_, Ts, own);
        }
        if (!(Ts > 0)) Ts = own;
      }
      begin += count;
    }
    if (!(Ts > 0)) {
      if (wanted_.Ts) return *wanted_.Ts;
      fail("{} has one sample in each experiment: give the sampling time Ts in s", file_);
    }
    if (wanted_.Ts && std::fabs(*wanted_.Ts - Ts) > 1e-3 * Ts) {
      fail("{}: Ts is given as {} s, but its times are {:.6g} s apart", file_, *wanted_.Ts, Ts);
    }
    // Sums of rounded times leave noise in the last digits.
    return wanted_.Ts ? *wanted_.Ts : *parse_number(fmt::format("{:.10g}", Ts));
  }

  // How far a time may be from where it belongs: what six digits round away, as far as no lost sample hides in it.
  static double slack(double time, double Ts) {
    if (time == 0) return 0.05 * Ts;
    const double rounding = 0.5 * std::pow(10, std::floor(std::log10(std::fabs(time))) - 5);
    return 0.05 * Ts + std::min(0.4 * Ts, rounding);
  }

  void check_steps(std::size_t begin, std::size_t count, double Ts) const {
    const auto time = [&](std::size_t i) { return at(roles_.time, begin + i); };
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
    const auto line = [&](std::size_t i) {
      const double index = static_cast<double>(i);
      return time(0) + index * Ts + offset + moment / squares * (index - middle);
    };
    const auto is_off = [&](std::size_t i) {
      const double step = time(i) - time(i - 1);
      return !(std::isfinite(step) && step > 0 && std::fabs(step - Ts) <= 2 * slack(time(i), Ts) &&
               std::fabs(time(i) - line(i)) <= slack(time(i), Ts));
    };
    std::size_t bad = 1;
    while (bad < count && !is_off(bad)) ++bad;
    if (bad == count) return;
    // One gap moves the mean; the row to show is the first whose step is not like most.
    std::vector<double> steps;
    for (std::size_t i = 1; i < count; ++i) steps.push_back(time(i) - time(i - 1));
    std::vector<double> sorted = steps;
    const auto by_size = [](double a, double b) { return std::isnan(b) ? !std::isnan(a) : a < b; };
    std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2), sorted.end(),
                     by_size);
    const double usual = sorted[sorted.size() / 2];
    for (std::size_t i = 1; i < count; ++i) {
      if (std::fabs(steps[i - 1] - usual) <= 0.3 * std::fabs(usual) && steps[i - 1] > 0) continue;
      bad = i;
      break;
    }
    fail(
        "{}: time goes from {} s to {} s at row {}, but most steps are {:.6g} s; the times of an experiment must "
        "grow evenly: leave cells of missing samples empty, and number the experiments in a column 'experiment'",
        file_, time(bad - 1), time(bad), bad + 1, usual);
  }

  const CsvTable& table_;
  const std::string& file_;
  const CsvColumns& wanted_;
  std::vector<Channel> channels_;
  Roles roles_;
};

}  // namespace

Channel channel_of(const std::string& header) {
  const std::size_t open = header.find('[');
  if (open == std::string::npos || !header.ends_with(']')) return {header, ""};
  std::string name = header.substr(0, open);
  while (name.ends_with(' ')) name.pop_back();
  return {name, header.substr(open + 1, header.size() - open - 2)};
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
