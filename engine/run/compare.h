// Two signals side by side: where they differ, by how much, and whether that is more than is allowed.

#pragma once

#include <string>
#include <vector>

#include "engine/base/csv.h"
#include "engine/run/recording.h"

namespace plantloop {

// A signal as samples in order of time (s). A jump has two samples of equal time, the left side first.
struct SampledSignal {
  enum class Between {
    line,   // straight from sample to sample
    held,   // each value until the next sample
    either  // a file does not say: whichever is nearer to what it is compared with
  };
  std::vector<double> time, value;
  Between between = Between::line;
};

// |signal - wanted| <= abs + rel |wanted|, with the signal at any time within `shift` of the wanted sample's.
struct Tolerance {
  double abs = 0;          // in the signal's unit
  double rel = 0;          // part of the wanted value
  double shift = 0;        // s
  bool of_signal = false;  // rel counts from the signal's value instead
};

// A sample of `wanted` and what the signal has there.
struct Deviation {
  bool met = true;
  double time = 0;               // s
  double wanted = 0, found = 0;  // there
  double distance = 0;           // |found - wanted|
  double allowed = 0;            // abs + rel |wanted|
  bool outside = false;          // the signal has no value at that time
};

// Every sample of `wanted` against the signal: of a jump each side against the same side, a value between the signal's
// samples as `between` says. Values that are both not a number agree. An empty `wanted` is met.
std::vector<Deviation> deviations(const SampledSignal& signal, const SampledSignal& wanted, const Tolerance& tolerance);
// The worst of them: of those that are not met, else of all, the one farthest beyond (or nearest to) what is allowed.
Deviation worst_deviation(const SampledSignal& signal, const SampledSignal& wanted, const Tolerance& tolerance);

// A column of a run, in all its rows.
SampledSignal signal_of(const Recording& recording, std::size_t column);
// A column of a table over its column `time`; nothing when it has none of these names.
std::vector<std::string> signal_names(const CsvTable& table);
SampledSignal signal_of(const CsvTable& table, std::size_t column, std::size_t time_column);

}  // namespace plantloop
