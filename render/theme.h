// How figures look: colours and measures. Measures are in pixels at 152.4 dpi (sixths of a millimetre).

#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "render/color.h"

namespace plantloop {

struct Theme {
  std::string_view name;
  Color background, text, muted, axis, grid, minor_grid, reference;
  std::array<Color, 6> palette;
  double text_size = 15, label_size = 16, title_size = 20, panel_title_size = 16;
  double line_width = 2.0;
  double grid_width = 1.0;
  double reference_width = 1.2;
  std::uint8_t band_alpha = 56;
};

// Null when there is none of this name.
const Theme* find_theme(std::string_view name);

std::vector<std::string> theme_names();

// The colour of a part between 0 and 1 of a colour scale; beyond it, that of the nearer end. The diverging map's middle
// is the theme's background.
Color map_color(const Theme& theme, std::string_view map, double part);

// viridis (dark to bright, even steps of lightness), diverging (two hues away from the middle), gray, tint (from the
// background to the first colour of the palette).
std::vector<std::string> color_maps();

// The look of the n-th series: past the palette's end colours come again with other dashes; pale colours are thicker.
struct SeriesStyle {
  Color color;
  int round = 0;       // how often the palette has been used up
  double widen = 1.0;  // factor on the line's width
};
SeriesStyle series_style(const Theme& theme, std::size_t index);

}  // namespace plantloop
