// The themes: light for screens, dark (a palette of its own, no inversion), print for papers.

#include "render/theme.h"

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

SeriesStyle series_style(const Theme& theme, std::size_t index) {
  const Color color = theme.palette[index % theme.palette.size()];
  const bool pale = contrast(color, theme.background) < 3.0;
  return {color, static_cast<int>(index / theme.palette.size()), pale ? 1.35 : 1.0};
}

}  // namespace plantloop
