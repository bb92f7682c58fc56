// Reading colours.

#include "engine/base/colors.h"

namespace plantloop {
namespace {

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

}  // namespace

const std::vector<NamedColor>& named_colors() {
  static const std::vector<NamedColor> names{
      {"blue", 0x0072B2},   {"vermillion", 0xD55E00}, {"green", 0x009E73}, {"purple", 0xCC79A7},
      {"orange", 0xE69F00}, {"sky", 0x56B4E9},        {"black", 0x000000}, {"grey", 0x6B7480},
      {"gray", 0x6B7480},   {"red", 0xC8102E},        {"white", 0xFFFFFF},
  };
  return names;
}

std::optional<std::uint32_t> color_number(std::string_view text) {
  for (const auto& [name, hex] : named_colors())
    if (name == text) return hex << 8 | 0xFF;
  if (text.empty() || text[0] != '#') return std::nullopt;
  text.remove_prefix(1);
  if (text.size() != 3 && text.size() != 6 && text.size() != 8) return std::nullopt;
  std::uint32_t number = 0;
  for (const char c : text) {
    const int digit = hex_digit(c);
    if (digit < 0) return std::nullopt;
    number = number << 4 | static_cast<std::uint32_t>(digit);
    if (text.size() == 3) number = number << 4 | static_cast<std::uint32_t>(digit);
  }
  return text.size() == 8 ? number : number << 8 | 0xFF;
}

}  // namespace plantloop
