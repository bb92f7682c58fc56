// Adding series to panels and panels to figures.

#include "render/figure.h"

#include <stdexcept>

namespace plantloop {
namespace {

Series checked(Series series) {
  const bool band = series.kind == Series::Kind::band;
  if (series.x.size() != series.y.size() || (band && series.lower.size() != series.y.size()))
    throw std::invalid_argument("the columns of a series differ in length");
  return series;
}

}  // namespace

Series line_series(std::vector<double> x, std::vector<double> y, SeriesLook look) {
  return checked({Series::Kind::line, std::move(x), std::move(y), {}, std::move(look)});
}

Series stairs_series(std::vector<double> x, std::vector<double> y, SeriesLook look) {
  return checked({Series::Kind::stairs, std::move(x), std::move(y), {}, std::move(look)});
}

Series marker_series(std::vector<double> x, std::vector<double> y, SeriesLook look) {
  look.style = LineStyle::none;
  if (look.marker == Marker::none) look.marker = Marker::dot;
  return line_series(std::move(x), std::move(y), std::move(look));
}

Series band_series(std::vector<double> x, std::vector<double> lower, std::vector<double> upper, SeriesLook look) {
  return checked({Series::Kind::band, std::move(x), std::move(upper), std::move(lower), std::move(look)});
}

Series& Panel::line(std::vector<double> xs, std::vector<double> ys, SeriesLook look) {
  return series.emplace_back(line_series(std::move(xs), std::move(ys), std::move(look)));
}

Series& Panel::stairs(std::vector<double> xs, std::vector<double> ys, SeriesLook look) {
  return series.emplace_back(stairs_series(std::move(xs), std::move(ys), std::move(look)));
}

Series& Panel::markers(std::vector<double> xs, std::vector<double> ys, SeriesLook look) {
  return series.emplace_back(marker_series(std::move(xs), std::move(ys), std::move(look)));
}

Series& Panel::band(std::vector<double> xs, std::vector<double> lower, std::vector<double> upper, SeriesLook look) {
  return series.emplace_back(band_series(std::move(xs), std::move(lower), std::move(upper), std::move(look)));
}

Panel& Figure::add_panel(Panel panel) { return panels.emplace_back(std::move(panel)); }

}  // namespace plantloop
