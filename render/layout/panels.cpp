// The plan of one panel: its series with their colours, and those of the panels inside it.

#include <algorithm>
#include <cmath>

#include "render/layout/plan.h"

namespace plantloop {
namespace {

Color ink_of(const Theme& theme, const SeriesLook& look, Color palette) {
  switch (look.ink) {
    case Ink::grid:
      return theme.grid;
    case Ink::reference:
      return theme.reference;
    case Ink::text:
      return theme.text;
    case Ink::palette:
      break;
  }
  return palette;
}

SeriesPlan plan_series(const Plan& plan, const Series& series, bool right, const SeriesStyle& style) {
  const SeriesLook& look = series.look;
  SeriesPlan result;
  result.series = &series;
  result.right = right;
  result.color = look.color.value_or(ink_of(*plan.theme, look, style.color));
  const double point = 152.4 / 72;  // in sixths of a millimetre
  const double own = result.is_guide() ? plan.theme->reference_width : plan.theme->line_width;
  const bool plain = look.color || look.ink != Ink::palette;
  const double width = look.width > 0 ? look.width * point : own * (plain ? 1.0 : style.widen);
  // A pale colour of the palette carries a thin line only when it is darkened.
  if (!plain && width < 2.4) result.color = readable_on(plan.theme->background, result.color, 3.0);
  result.text_color = readable_on(plan.theme->background, result.color, 4.5);
  if (look.opacity < 1)
    result.color.a = static_cast<std::uint8_t>(std::lround(255 * std::clamp(look.opacity, 0.0, 1.0)));
  result.width = plan.unit * width;
  result.mark_radius = look.size > 0                   ? 0.5 * look.size * point * plan.unit
                       : look.style == LineStyle::none ? 3.6 * plan.unit
                                                       : std::max(3.2 * plan.unit, 1.6 * result.width);
  result.style = look.style;
  if (result.style == LineStyle::solid && !plain && style.round % 3 != 0)
    result.style = style.round % 3 == 1 ? LineStyle::dashed : LineStyle::dotted;
  return result;
}

// Every series takes the next place in the palette, except those that are given a colour or share another's.
void add_series(const Plan& plan, PanelPlan& p) {
  std::vector<std::pair<const Series*, bool>> all;
  for (const Series& s : p.panel->series) all.emplace_back(&s, false);
  for (const Series& s : p.panel->right_series) all.emplace_back(&s, true);
  const auto borrows = [&](const SeriesLook& look) {
    return !look.color && look.color_of && *look.color_of < all.size();
  };
  const auto colored_by_value = [](const Series& s) {
    return !s.areas.empty() && std::all_of(s.areas.begin(), s.areas.end(), [](const Area& a) { return a.value; });
  };
  std::vector<SeriesStyle> styles;
  std::size_t next = 0;
  for (const auto& [series, right] : all) {
    const bool own = !series->look.color && !borrows(series->look) && !series->look.same_color &&
                     series->look.ink == Ink::palette && !colored_by_value(*series);
    styles.push_back(series_style(*plan.theme, own ? next++ : 0));
    if (series->look.color) styles.back().color = *series->look.color;
  }
  for (std::size_t i = 0; i < all.size(); ++i) {
    const auto [series, right] = all[i];
    if (series->look.same_color && !series->look.color && i > 0 && all[i - 1].second == right)
      styles[i] = styles[i - 1];
    if (borrows(series->look)) styles[i] = styles[*series->look.color_of];
    p.series.push_back(plan_series(plan, *series, right, styles[i]));
  }
}

}  // namespace

PanelPlan plan_panel(const Plan& plan, const Panel& panel) {
  PanelPlan p;
  p.panel = &panel;
  p.x_axis = panel.x ? &*panel.x : &plan.figure->x;
  if (panel.bare) p.shows_x = p.shows_y = false;
  if (panel.space) {
    p.shows_x = p.shows_y = false;
    return p;
  }
  p.twin = !panel.right_series.empty();
  add_series(plan, p);
  if (p.twin && panel.series.size() == 1) p.left_color = p.series.front().text_color;
  if (p.twin && panel.right_series.size() == 1) p.right_color = p.series.back().text_color;
  for (const Panel& inset : panel.insets) {
    p.insets.push_back(plan_panel(plan, inset));
    p.insets.back().is_inset = true;
    if (!inset.x) p.insets.back().x_axis = p.x_axis;
  }
  return p;
}

}  // namespace plantloop
