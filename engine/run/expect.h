// The verdicts on a diagram's `expect:` section.

#pragma once

#include <vector>

#include "engine/run/diagram.h"

namespace plantloop {

// One verdict per entry, in order. An entry that asks for what was not recorded is not met, and says why.
std::vector<Verdict> judge(const Model& model, const DiagramRun& run);

}  // namespace plantloop
