// The themes: light for screens, dark (a palette of its own, no inversion), print for papers.

#include "render/theme.h"

#include <algorithm>
#include <cmath>

namespace plantloop {
namespace {

constexpr Theme light{
    .name = "light",
    .background = rgb(0xFFFFFF),
    .text = rgb(0x1B1F24),
    .muted = rgb(0x59636E),
    .axis = rgb(0x7A838D),
    .grid = rgb(0xE4E7EB),
    .minor_grid = rgb(0xF1F3F5),
    .reference = rgb(0x6B7480),
    .palette = {rgb(0x0072B2), rgb(0xD55E00), rgb(0x009E73), rgb(0xCC79A7), rgb(0xE69F00), rgb(0x56B4E9)},
};

constexpr Theme dark{
    .name = "dark",
    .background = rgb(0x0D1117),
    .text = rgb(0xE6EDF3),
    .muted = rgb(0x9BA5B0),
    .axis = rgb(0x7A838D),
    .grid = rgb(0x262C34),
    .minor_grid = rgb(0x1A2028),
    .reference = rgb(0x9BA5B0),
    .palette = {rgb(0x58A6FF), rgb(0xFF9E64), rgb(0x3FD0A4), rgb(0xF092C8), rgb(0xF2CC60), rgb(0xB8C4D0)},
};

constexpr Theme print{
    .name = "print",
    .background = rgb(0xFFFFFF),
    .text = rgb(0x000000),
    .muted = rgb(0x000000),
    .axis = rgb(0x000000),
    .grid = rgb(0xDADDE1),
    .minor_grid = rgb(0xEEF0F2),
    .reference = rgb(0x444B53),
    .palette = {rgb(0x0072B2), rgb(0xD55E00), rgb(0x009E73), rgb(0xCC79A7), rgb(0xE69F00), rgb(0x56B4E9)},
    .line_width = 1.8,
    .grid_width = 0.8,
};

constexpr std::array themes{&light, &dark, &print};

// Viridis by N. Smith and S. van der Walt (2015, public domain), every sixteenth of its 256 colours and the last.
constexpr std::array viridis{rgb(0x440154), rgb(0x481A6C), rgb(0x472F7D), rgb(0x414487), rgb(0x39568C), rgb(0x31688E),
                             rgb(0x2A788E), rgb(0x23888E), rgb(0x1F988B), rgb(0x22A884), rgb(0x35B779), rgb(0x54C568),
                             rgb(0x7AD151), rgb(0xA5DB36), rgb(0xD2E21B), rgb(0xECE51B), rgb(0xFDE725)};

Color mixed(Color a, Color b, double part) {
  const auto level = [part](int from, int to) {
    return static_cast<std::uint8_t>(std::lround(from + part * (to - from)));
  };
  return {level(a.r, b.r), level(a.g, b.g), level(a.b, b.b)};
}

}  // namespace

const Theme* find_theme(std::string_view name) {
  for (const Theme* theme : themes)
    if (theme->name == name) return theme;
  return nullptr;
}

std::vector<std::string> theme_names() {
  std::vector<std::string> names;
  for (const Theme* theme : themes) names.emplace_back(theme->name);
  return names;
}

std::vector<std::string> color_maps() { return {"viridis", "diverging", "gray", "tint"}; }

Color map_color(const Theme& theme, std::string_view map, double part) {
  part = part >= 0 ? std::min(part, 1.0) : 0;  // a NaN is the lower end
  if (map == "diverging") {
    const Color end = part < 0.5 ? theme.palette[0] : theme.palette[1];
    return mixed(theme.background, end, std::abs(2 * part - 1));
  }
  if (map == "tint") return mixed(theme.background, theme.palette[0], 0.15 + 0.85 * part);
  if (map == "gray") return mixed(theme.grid, theme.text, part);
  const double place = part * static_cast<double>(viridis.size() - 1);
  const std::size_t below = std::min(static_cast<std::size_t>(place), viridis.size() - 2);
  return mixed(viridis[below], viridis[below + 1], place - static_cast<double>(below));
}

SeriesStyle series_style(const Theme& theme, std::size_t index) {
  const Color color = theme.palette[index % theme.palette.size()];
  const bool pale = contrast(color, theme.background) < 3.0;
  return {color, static_cast<int>(index / theme.palette.size()), pale ? 1.35 : 1.0};
}

}  // namespace plantloop
