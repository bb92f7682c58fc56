// The fonts inside the program, as bytes.

#pragma once

#include <array>
#include <span>
#include <string_view>

namespace plantloop {

struct EmbeddedFont {
  std::string_view name;
  std::span<const unsigned char> bytes;
  int weight = 0;           // to be set on the weight axis of a variable font; 0 for a static one
  std::string_view sha256;  // of the bytes, lower-case hexadecimal
};

// In the order of FontId.
std::array<EmbeddedFont, 3> embedded_fonts();

}  // namespace plantloop
