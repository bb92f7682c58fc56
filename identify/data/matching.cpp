// What models ask of data, and what is said when data do not have it.

#include "identify/data/matching.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "identify/error.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;

std::vector<std::string> names_of(const std::vector<Channel>& channels) {
  std::vector<std::string> names;
  for (const Channel& c : channels) names.push_back(c.name);
  return names;
}

std::string listed(const std::vector<std::string>& names, std::string_view what) {
  if (names.empty()) return fmt::format("no {}", what);
  return fmt::format("the {}{} '{}'", what, names.size() == 1 ? "" : "s", fmt::join(names, "', '"));
}

void check_list(const std::vector<std::string>& own, const std::vector<Channel>& given, std::string_view what) {
  const std::vector<std::string> theirs = names_of(given);
  if (own == theirs) return;
  const bool other_order = own.size() == theirs.size() && std::is_permutation(own.begin(), own.end(), theirs.begin());
  fail("the model has {}, the data have {}: {}", listed(own, what), listed(theirs, what),
       other_order ? "they must stand in the same order" : "the names must be the same, in the same order");
}

void check_sampling_time(double own, double given) {
  if (std::fabs(own - given) > 1.001e-3 * own)
    fail("the model's sampling time is {} s, that of the data {} s; resample the data", own, given);
}

// Why a free run cannot be, or nothing.
std::string gap(const DataSet& data, Index first, const std::vector<std::size_t>& outputs) {
  const auto place = [&](const Experiment& e, Index k) {
    return fmt::format("sample {} (time {:.6g} s) of experiment '{}'", k + 1,
                       e.start + static_cast<double>(k) * data.Ts, e.name);
  };
  for (const Experiment& e : data.experiments) {
    for (Index k = 0; k < e.samples(); ++k) {
      for (std::size_t c = 0; c < data.inputs.size(); ++c) {
        if (!std::isnan(e.u(k, static_cast<Index>(c)))) continue;
        return fmt::format(
            "a free run needs every input, and '{}' is missing at {}: fill the gap first, or use the "
            "parts before and after",
            data.inputs[c].name, place(e, k));
      }
      if (k >= first) continue;
      for (const std::size_t c : outputs) {
        if (!std::isnan(e.y(k, static_cast<Index>(c)))) continue;
        return fmt::format("a free run begins with {} of each output, and '{}' is missing at {}",
                           first == 1 ? "the first measured value" : fmt::format("the first {} measured values", first),
                           data.outputs[c].name, place(e, k));
      }
    }
  }
  return {};
}

}  // namespace

void check_names(const std::vector<std::string>& inputs, const std::vector<std::string>& outputs, const DataSet& data) {
  check_list(inputs, data.inputs, "input");
  check_list(outputs, data.outputs, "output");
}

void check_signals(const std::vector<Channel>& inputs, const std::vector<Channel>& outputs, double Ts,
                   const DataSet& data) {
  check(data);
  check_names(names_of(inputs), names_of(outputs), data);
  check_sampling_time(Ts, data.Ts);
}

std::size_t check_signals(const std::vector<Channel>& inputs, const Channel& output, double Ts, const DataSet& data) {
  check(data);
  check_list(names_of(inputs), data.inputs, "input");
  check_sampling_time(Ts, data.Ts);
  for (std::size_t i = 0; i < data.outputs.size(); ++i) {
    if (data.outputs[i].name == output.name) return i;
  }
  check_list({output.name}, data.outputs, "output");
  return 0;
}

void check_free_run(const DataSet& data, Index first, const std::vector<std::size_t>& outputs) {
  const std::string why = gap(data, first, outputs);
  if (!why.empty()) fail("{}", why);
}

void check_free_run(const DataSet& data, Index first) {
  std::vector<std::size_t> all(data.outputs.size());
  std::iota(all.begin(), all.end(), 0);
  check_free_run(data, first, all);
}

bool can_run_free(const DataSet& data, Index first, const std::vector<std::size_t>& outputs) {
  return gap(data, first, outputs).empty();
}

}  // namespace plantloop::identify
