// Where something was written: a source text and a place in it.

#pragma once

#include <cstdint>
#include <memory>
#include <string>

namespace plantloop {

// A text that findings point into. `name` is the file's name as its reader gave it.
struct Source {
  std::string name;
  std::string text;
};

// A place in a source: line and column count from 1, columns in characters (not bytes); length in characters.
// A default mark has no place.
struct Mark {
  const Source* source = nullptr;  // owned by the Sources of the model that the mark belongs to
  std::uint32_t line = 0;
  std::uint32_t column = 0;
  std::uint32_t length = 1;
};

// "diagrams/car.yaml:12:7", or "" for a mark without place.
std::string to_string(const Mark& mark);

}  // namespace plantloop
