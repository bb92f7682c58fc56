// Mixing, naming and judging colours.

#include "render/color.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <utility>

namespace plantloop {
namespace {

constexpr std::array<std::pair<std::string_view, Color>, 11> names{{
    {"blue", rgb(0x0072B2)},
    {"vermillion", rgb(0xD55E00)},
    {"green", rgb(0x009E73)},
    {"purple", rgb(0xCC79A7)},
    {"orange", rgb(0xE69F00)},
    {"sky", rgb(0x56B4E9)},
    {"black", rgb(0x000000)},
    {"grey", rgb(0x6B7480)},
    {"gray", rgb(0x6B7480)},
    {"red", rgb(0xC8102E)},
    {"white", rgb(0xFFFFFF)},
}};

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

// Relative luminance of sRGB, WCAG 2.1.
double luminance(Color color) {
  const auto linear = [](std::uint8_t level) {
    const double value = level / 255.0;
    return value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
  };
  return 0.2126 * linear(color.r) + 0.7152 * linear(color.g) + 0.0722 * linear(color.b);
}

std::uint8_t mix(int top, int below, int alpha) {
  return static_cast<std::uint8_t>((top * alpha + below * (255 - alpha) + 127) / 255);
}

}  // namespace

Color over(Color top, Color below) {
  return {mix(top.r, below.r, top.a), mix(top.g, below.g, top.a), mix(top.b, below.b, top.a)};
}

std::optional<Color> parse_color(std::string_view text) {
  for (const auto& [name, color] : names)
    if (name == text) return color;
  if (text.empty() || text[0] != '#') return std::nullopt;
  text.remove_prefix(1);
  const std::size_t digits = text.size() == 3 ? 1 : 2;
  if (text.size() != 3 && text.size() != 6 && text.size() != 8) return std::nullopt;
  std::array<std::uint8_t, 4> level{0, 0, 0, 255};
  for (std::size_t i = 0; i * digits < text.size(); ++i) {
    const int high = hex_digit(text[i * digits]);
    const int low = hex_digit(text[i * digits + digits - 1]);
    if (high < 0 || low < 0) return std::nullopt;
    level[i] = static_cast<std::uint8_t>(16 * high + low);
  }
  return Color{level[0], level[1], level[2], level[3]};
}

std::string to_hex(Color color) {
  if (color.a == 255) return fmt::format("#{:02x}{:02x}{:02x}", color.r, color.g, color.b);
  return fmt::format("#{:02x}{:02x}{:02x}{:02x}", color.r, color.g, color.b, color.a);
}

double contrast(Color one, Color other) {
  double bright = luminance(one);
  double dark = luminance(other);
  if (bright < dark) std::swap(bright, dark);
  return (bright + 0.05) / (dark + 0.05);
}

Color readable_on(Color background, Color color, double wanted_contrast) {
  const std::uint8_t goal = luminance(background) > 0.18 ? 0 : 255;
  const Color start = with_alpha(color, 255);
  Color result = start;
  for (int part = 0; part <= 255 && contrast(result, background) < wanted_contrast; part += 5)
    result = over({goal, goal, goal, static_cast<std::uint8_t>(part)}, start);
  return result;
}

}  // namespace plantloop
