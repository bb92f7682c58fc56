// Colours: 8-bit sRGB with opacity.

#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace plantloop {

struct Color {
  std::uint8_t r = 0, g = 0, b = 0, a = 255;
  friend bool operator==(const Color&, const Color&) = default;
};

// 0xRRGGBB, opaque.
constexpr Color rgb(std::uint32_t hex) {
  return {static_cast<std::uint8_t>(hex >> 16), static_cast<std::uint8_t>(hex >> 8), static_cast<std::uint8_t>(hex)};
}

constexpr Color with_alpha(Color color, std::uint8_t alpha) {
  color.a = alpha;
  return color;
}

// What the eye sees when `top` lies on an opaque `below`.
Color over(Color top, Color below);

// "#RGB", "#RRGGBB", "#RRGGBBAA" or one of the palette's names (blue vermillion green purple orange sky black grey red
// white); nothing when the text is none of them.
std::optional<Color> parse_color(std::string_view text);

// "#rrggbb", with the opacity appended when it is not full.
std::string to_hex(Color color);

// Contrast ratio after WCAG 2.1, 1 to 21; opacity is ignored.
double contrast(Color one, Color other);

// The colour moved towards black or white, just far enough to reach the contrast on this background.
Color readable_on(Color background, Color color, double wanted_contrast);

}  // namespace plantloop
