// Measured signals: their checks, and parts of them.

#include "identify/data/data_set.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

#include "identify/error.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

std::vector<Channel> numbered(std::string_view letter, Index count) {
  if (count == 1) return {{std::string(letter), ""}};
  std::vector<Channel> channels;
  for (Index i = 1; i <= count; ++i) channels.push_back({fmt::format("{}{}", letter, i), ""});
  return channels;
}

MatrixXd stacked(const DataSet& data, MatrixXd Experiment::*member, std::size_t columns) {
  MatrixXd all(data.samples(), static_cast<Index>(columns));
  Index at = 0;
  for (const Experiment& e : data.experiments) {
    all.middleRows(at, e.samples()) = e.*member;
    at += e.samples();
  }
  return all;
}

// Beyond these squares overflow, or vanish, and no estimate means anything.
constexpr double largest_value = 1e150, smallest_value = 1e-150;

double time_of(const DataSet& data, const Experiment& e, Index k) { return e.start + static_cast<double>(k) * data.Ts; }

void check_values(const MatrixXd& values, const std::vector<Channel>& channels, const DataSet& data,
                  const Experiment& e) {
  for (Index c = 0; c < values.cols(); ++c) {
    double greatest = 0;
    for (Index k = 0; k < values.rows(); ++k) {
      if (std::isinf(values(k, c))) {
        fail("'{}' is infinite at sample {} (time {:.6g} s) of experiment '{}'",
             channels[static_cast<std::size_t>(c)].name, k + 1, time_of(data, e, k), e.name);
      }
      if (std::fabs(values(k, c)) > greatest) greatest = std::fabs(values(k, c));
    }
    if (greatest > largest_value || (greatest > 0 && greatest < smallest_value))
      fail("'{}' has values of about {:.0e} in experiment '{}', whose squares cannot be computed; take another unit",
           channels[static_cast<std::size_t>(c)].name, greatest, e.name);
  }
}

void check_names(const DataSet& data) {
  std::vector<std::string> names;
  for (const auto* channels : {&data.inputs, &data.outputs}) {
    for (const Channel& c : *channels) {
      if (c.name.empty()) fail("a signal has no name");
      if (std::find(names.begin(), names.end(), c.name) != names.end()) fail("two signals are called '{}'", c.name);
      names.push_back(c.name);
    }
  }
}

struct Fnv {
  std::uint64_t state = 0xcbf29ce484222325ULL;
  void byte(unsigned char b) { state = (state ^ b) * 0x100000001b3ULL; }
  void number(double value) {
    std::uint64_t bits = std::bit_cast<std::uint64_t>(value);
    for (int i = 0; i < 8; ++i, bits >>= 8) byte(static_cast<unsigned char>(bits & 0xffU));
  }
  void text(const std::string& value) {
    for (const char c : value) byte(static_cast<unsigned char>(c));
    byte(0);
  }
  void matrix(const MatrixXd& m) {
    number(static_cast<double>(m.rows()));
    for (Index i = 0; i < m.size(); ++i) number(m.data()[i]);
  }
};

}  // namespace

Index DataSet::samples() const {
  Index sum = 0;
  for (const Experiment& e : experiments) sum += e.samples();
  return sum;
}

Index DataSet::missing() const {
  Index sum = 0;
  for (const Experiment& e : experiments) sum += e.u.array().isNaN().count() + e.y.array().isNaN().count();
  return sum;
}

MatrixXd DataSet::all_u() const { return stacked(*this, &Experiment::u, inputs.size()); }
MatrixXd DataSet::all_y() const { return stacked(*this, &Experiment::y, outputs.size()); }

void check(const DataSet& data) {
  if (!(data.Ts > 0) || !std::isfinite(data.Ts))
    fail("the sampling time must be greater than 0 s, it is {} s", data.Ts);
  if (data.outputs.empty()) fail("the data have no output");
  if (data.samples() == 0) fail("the data have no samples");
  check_names(data);
  for (const Experiment& e : data.experiments) {
    if (e.u.cols() != static_cast<Index>(data.inputs.size()) || e.y.cols() != static_cast<Index>(data.outputs.size())) {
      fail("experiment '{}' has {} inputs and {} outputs, but the data have {} and {}", e.name, e.u.cols(), e.y.cols(),
           data.inputs.size(), data.outputs.size());
    }
    if (e.u.cols() > 0 && e.u.rows() != e.y.rows()) {
      fail("experiment '{}' has {} samples of the inputs and {} of the outputs", e.name, e.u.rows(), e.y.rows());
    }
    check_values(e.u, data.inputs, data, e);
    check_values(e.y, data.outputs, data, e);
  }
}

void refuse_missing(const DataSet& data, std::string_view method) {
  for (const Experiment& e : data.experiments) {
    const auto look = [&](const MatrixXd& values, const std::vector<Channel>& channels) {
      for (Index c = 0; c < values.cols(); ++c) {
        for (Index k = 0; k < values.rows(); ++k) {
          if (!std::isnan(values(k, c))) continue;
          fail(
              "'{}' is missing at sample {} (time {:.6g} s) of experiment '{}', and {} needs a record without gaps: "
              "fill it first, or "
              "use the parts before and after",
              channels[static_cast<std::size_t>(c)].name, k + 1, time_of(data, e, k), e.name, method);
        }
      }
    };
    look(e.u, data.inputs);
    look(e.y, data.outputs);
  }
}

DataSet make_data_set(MatrixXd u, MatrixXd y, double Ts, std::vector<Channel> inputs, std::vector<Channel> outputs) {
  if (inputs.empty()) inputs = numbered("u", u.cols());
  if (outputs.empty()) outputs = numbered("y", y.cols());
  if (u.cols() == 0) u.resize(y.rows(), 0);
  DataSet data{Ts, std::move(inputs), std::move(outputs), {}};
  data.experiments.push_back({"1", 0, std::move(u), std::move(y)});
  check(data);
  return data;
}

DataSet part(const DataSet& data, Index from, Index until) {
  if (from < 0 || until < from) fail("a part runs from a sample to a later one, not from {} to {}", from + 1, until);
  DataSet result{data.Ts, data.inputs, data.outputs, {}};
  for (const Experiment& e : data.experiments) {
    const Index count = std::min(until, e.samples()) - from;
    if (count <= 0) continue;
    result.experiments.push_back({e.name, e.start + static_cast<double>(from) * data.Ts, e.u.middleRows(from, count),
                                  e.y.middleRows(from, count)});
  }
  if (result.experiments.empty()) fail("the data have no sample {}", from + 1);
  return result;
}

std::pair<DataSet, DataSet> split(const DataSet& data, double fraction) {
  if (!(fraction > 0 && fraction < 1)) fail("the fraction must lie between 0 and 1, it is {}", fraction);
  std::pair<DataSet, DataSet> parts{{data.Ts, data.inputs, data.outputs, {}}, {data.Ts, data.inputs, data.outputs, {}}};
  for (const Experiment& e : data.experiments) {
    const auto first = static_cast<Index>(std::lround(fraction * static_cast<double>(e.samples())));
    if (first > 0) parts.first.experiments.push_back({e.name, e.start, e.u.topRows(first), e.y.topRows(first)});
    const Index rest = e.samples() - first;
    if (rest == 0) continue;
    parts.second.experiments.push_back(
        {e.name, e.start + static_cast<double>(first) * data.Ts, e.u.bottomRows(rest), e.y.bottomRows(rest)});
  }
  if (parts.first.experiments.empty() || parts.second.experiments.empty()) {
    fail("{} samples cannot be split at {}: one part would be empty", data.samples(), fraction);
  }
  return parts;
}

DataSet choose(const DataSet& data, const std::vector<std::size_t>& experiments) {
  DataSet result{data.Ts, data.inputs, data.outputs, {}};
  for (const std::size_t i : experiments) {
    if (i >= data.experiments.size()) fail("the data have {} experiments, not {}", data.experiments.size(), i + 1);
    result.experiments.push_back(data.experiments[i]);
  }
  check(result);
  return result;
}

DataSet join(const DataSet& first, const DataSet& second) {
  if (first.inputs != second.inputs || first.outputs != second.outputs) {
    fail("two data sets are joined when their signals have the same names and units");
  }
  if (first.Ts != second.Ts)
    fail("the sampling times differ: {} s and {} s; resample one of them", first.Ts, second.Ts);
  DataSet result = first;
  result.experiments.insert(result.experiments.end(), second.experiments.begin(), second.experiments.end());
  return result;
}

std::string hash(const DataSet& data) {
  Fnv fnv;
  fnv.number(data.Ts);
  for (const auto* channels : {&data.inputs, &data.outputs}) {
    for (const Channel& c : *channels) {
      fnv.text(c.name);
      fnv.text(c.unit);
    }
    fnv.byte(1);
  }
  for (const Experiment& e : data.experiments) {
    fnv.matrix(e.u);
    fnv.matrix(e.y);
  }
  return fmt::format("{:016x}", fnv.state);
}

}  // namespace plantloop::identify
