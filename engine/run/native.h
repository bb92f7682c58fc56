// What the files of a recording hold: the columns that are not hidden, each at its own rate.

#pragma once

#include <cstddef>
#include <vector>

#include "engine/run/recording.h"

namespace plantloop {

// Version of the JSON and NPZ files; to be raised when a reader of the older ones would misread the newer.
inline constexpr int recording_format = 1;

// Indices of the columns that are written.
inline std::vector<std::size_t> written_columns(const Recording& recording) {
  std::vector<std::size_t> indices;
  for (std::size_t i = 0; i < recording.columns.size(); ++i) {
    if (!recording.columns[i].hidden) indices.push_back(i);
  }
  return indices;
}

// Calls body(row) for the rows that are samples of the rate: all rows for the continuous one, else the hits.
template <typename Body>
void for_rows_of(const Recording& recording, int rate, Body body) {
  if (rate == 0) {
    for (std::size_t row = 0; row < recording.rows(); ++row) body(row);
  } else {
    for (const std::size_t row : recording.hits[static_cast<std::size_t>(rate)]) body(row);
  }
}

inline std::size_t rows_of(const Recording& recording, int rate) {
  return rate == 0 ? recording.rows() : recording.hits[static_cast<std::size_t>(rate)].size();
}

}  // namespace plantloop
