// What no model can tell of some data.

#pragma once

#include <string>
#include <vector>

#include "identify/data/data_set.h"

namespace plantloop::identify {

// As warnings: signals that do not vary, inputs that carry the same signal.
std::vector<std::string> undetermined(const DataSet& data);

}  // namespace plantloop::identify
