// Places in source texts, printed.

#include "engine/base/mark.h"

#include <fmt/format.h>

namespace plantloop {

std::string to_string(const Mark& mark) {
  if (!mark.source) return {};
  if (mark.line == 0) return mark.source->name;
  return fmt::format("{}:{}:{}", mark.source->name, mark.line, mark.column);
}

}  // namespace plantloop
