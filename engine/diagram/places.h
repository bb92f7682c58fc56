// Byte offsets of a source -> marks, fast for offsets that mostly grow.

#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "engine/base/mark.h"

namespace plantloop {

class Places {
 public:
  explicit Places(const Source& source);
  // The mark of bytes [offset, offset + size); the length ends with the line.
  Mark at(std::size_t offset, std::size_t size = 1);
  std::size_t line_begin(std::uint32_t line) const { return begins_[line - 1]; }

 private:
  const Source& source_;
  std::vector<std::size_t> begins_;  // of each line
  std::size_t line_ = 0;             // the line of the last offset, from 0
  std::size_t offset_ = 0;           // the last offset and its column, from 0
  std::uint32_t column_ = 0;
};

}  // namespace plantloop
