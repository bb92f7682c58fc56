// The names of colours: those of the palette that the colour-blind can tell apart (Okabe and Ito, 2008), and a few
// more.

#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace plantloop {

struct NamedColor {
  std::string_view name;
  std::uint32_t hex;  // 0xRRGGBB
};
const std::vector<NamedColor>& named_colors();

// 0xRRGGBBAA of a name, "#RGB", "#RRGGBB" or "#RRGGBBAA"; nothing when the text is none of them.
std::optional<std::uint32_t> color_number(std::string_view text);

}  // namespace plantloop
