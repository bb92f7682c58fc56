// The verdicts on a diagram's `expect:` section.

#pragma once

#include <map>
#include <string>
#include <vector>

#include "engine/run/compare.h"
#include "engine/run/diagram.h"

namespace plantloop {

// A file that `baseline:` names.
struct Baseline {
  CsvTable table;
  std::size_t time_column = 0;
  std::string error;  // why there is none: the whole sentence
};
using Baselines = std::map<const ExpectDecl*, Baseline>;
// Those of all entries. A run samples at their times, so that no interpolation between rows decides.
Baselines read_baselines(const Model& model);

// A column of a run in all its rows and samples.
SampledSignal recorded_signal(const Recording& recording, std::size_t column);

// One verdict per entry, in order. An entry that asks for what was not recorded is not met, and says why.
std::vector<Verdict> judge(const Model& model, const DiagramRun& run, const Baselines& baselines);

}  // namespace plantloop
