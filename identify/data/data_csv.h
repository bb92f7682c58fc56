// Data sets as CSV files.

#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "identify/data/data_set.h"

namespace plantloop::identify {

struct CsvColumns {
  // Names of columns, without units. Both empty: columns that begin with u are inputs, with y outputs, and there must
  // be no others; else columns that are not named are not read.
  std::vector<std::string> inputs, outputs;
  // s; needed only when there is no column `time`. Beside one it must agree with the times, which may then be off by up
  // to half of it, or by what their digits round away.
  std::optional<double> Ts;
};

// A header's name and unit: "flow [l/s]", or "flow (l/s)" with a space and a unit that is known.
Channel channel_of(const std::string& header);

// A table with a header: `time` (also `Time`, `t`) in s or in the unit that its header gives, signals as `name` or
// `name [unit]`, and `experiment`, a number that changes where another experiment begins and does not come back. An
// empty cell, `nan` or `NA` is a missing value of a signal. Time must advance evenly within an experiment, to 5 % of
// the sampling time and what the digits of the times round away. `file` names it in messages. Raises IdentifyError.
DataSet read_data_csv(std::string_view text, const std::string& file, const CsvColumns& columns = {});

// The same back, 17 significant digits, so that reading it gives equal numbers; the column `experiment` when there are
// several.
std::string to_csv(const DataSet& data);

}  // namespace plantloop::identify
