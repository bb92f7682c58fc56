// Mixing, naming and judging colours.

#include "render/color.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "engine/base/colors.h"

namespace plantloop {
namespace {

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
  const auto number = color_number(text);
  if (!number) return std::nullopt;
  return with_alpha(rgb(*number >> 8), static_cast<std::uint8_t>(*number));
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
