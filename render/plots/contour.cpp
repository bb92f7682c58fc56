// Lines of equal height.

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "render/numbers/contours.h"
#include "render/plots/colored.h"
#include "render/plots/example.h"
#include "render/plots/plot.h"

namespace plantloop {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

struct Contour : Plot {
  Grid z{this, "z", "heights, a row for each y, a column for each x"};
  Column x{this, "x", "the columns' places; else 1, 2, ...", Need::optional};
  Column y{this, "y", "the rows' places; else 1, 2, ...", Need::optional};
  Column levels{this, "levels", "the heights to draw; else about ten nice ones", Need::optional};
  Flag filled{this, "filled", "colour the areas between the lines"};
  Colored colored{this};

  Contour() : Plot("lines of equal height, with numbers; or coloured areas between them") {}

  void draw(Canvas& canvas, const Given& given) const override {
    const GridValues& values = given[z];
    HeightField field{middles(given[x], values.columns), middles(given[y], values.rows), values.values};
    check_grid(values, field.x, field.y);
    std::vector<double> heights = given[levels];
    if (heights.empty()) heights = nice_levels(field.z, 10);
    std::sort(heights.begin(), heights.end());
    frame(canvas, field.x, field.y);
    if (given[filled]) fill(canvas, given, field, heights);

    std::vector<double> xs, ys;
    for (const double height : heights)
      for (const Path& path : contour_lines(field, height)) {
        xs.insert(xs.end(), path.x.begin(), path.x.end());
        ys.insert(ys.end(), path.y.begin(), path.y.end());
        xs.push_back(nan);
        ys.push_back(nan);
        // The number stands in the middle of the line, where it is long enough.
        const std::size_t n = path.x.size();
        if (!given[filled] && n > 12)
          canvas.panel().callouts.push_back(
              {.x = path.x[n / 3], .y = path.y[n / 3], .label = number(height), .quiet = true});
      }
    SeriesLook look = given.look;
    if (given[filled]) {
      look.ink = Ink::text;
      look.opacity = 0.55;
      look.width = 0.5;
      look.label.clear();
    } else if (look.width == 0) {
      look.width = 0.7;
    }
    canvas.add(line_series(xs, ys, look), given);
  }

  Figure example() const override {
    Figure figure{.title = "A function of two variables", .columns = 2};
    const auto u = example::grid(-3, 3, 91), v = example::grid(-3, 3, 91);
    const GridValues peaks = example::field(u, v, [](double a, double b) {
      return 3 * std::pow(1 - a, 2) * std::exp(-a * a - (b + 1) * (b + 1)) -
             10 * (a / 5 - a * a * a - std::pow(b, 5)) * std::exp(-a * a - b * b) -
             std::exp(-(a + 1) * (a + 1) - b * b) / 3;
    });
    for (const bool full : {false, true}) {
      figure.add_panel(
          {.title = full ? "filled" : "lines", .x = Axis{.label = "x_1"}, .y = {.label = full ? "" : "x_2"}});
      use(figure, full ? 1 : 0, {{"z", peaks}, {"x", u}, {"y", v}, {"filled", full}});
    }
    return figure;
  }

 private:
  static std::string number(double v) {
    std::string text = fmt::format("{:.4g}", v);
    return text.starts_with('-') ? "−" + text.substr(1) : text;
  }

  // From the lowest area to the highest, each on top of those before.
  void fill(Canvas& canvas, const Given& given, const HeightField& field, const std::vector<double>& heights) const {
    const ColorScale scale = colored.scale(given, field.z);
    canvas.panel().colors = scale;
    Series areas{.kind = Series::Kind::areas};
    for (std::size_t i = 0; i <= heights.size(); ++i) {
      const double below = i == 0 ? scale.lower : heights[i - 1], above = i < heights.size() ? heights[i] : scale.upper;
      const double level = i == 0 ? -std::numeric_limits<double>::infinity() : below;
      for (Path& path : area_above(field, level))
        areas.areas.push_back({std::move(path.x), std::move(path.y), below + (above - below) / 2});
    }
    canvas.add(std::move(areas), given);
  }
};

}  // namespace

PLANTLOOP_PLOT(contour, Contour)

}  // namespace plantloop
