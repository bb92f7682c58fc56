// How often values occur.

#include <fmt/format.h>
#include <algorithm>
#include <cmath>

#include "render/numbers/statistics.h"
#include "render/plots/example.h"
#include "render/plots/plot.h"

namespace plantloop {
namespace {

struct Histogram : Plot {
  Column values{this, "values", "the sample"};
  Real bins{this, "bins", 0, "number of bars; 0: after Freedman and Diaconis"};
  Flag density{this, "density", "scale to area one, and draw a smooth density over the bars"};
  Flag median{this, "median", "mark the median"};

  Histogram() : Plot("how often values occur, with a smooth density on request") {}

  void draw(Canvas& canvas, const Given& given) const override {
    const std::vector<double> sorted = finite_sorted(given[values]);
    const std::vector<double> edges = histogram_edges(
        sorted, static_cast<int>(std::isfinite(given[bins]) ? std::clamp(given[bins], 0.0, 2000.0) : 0.0));
    Series bars{.kind = Series::Kind::areas};
    bars.look = given.look;
    if (bars.look.opacity == 1) bars.look.opacity = 0.8;
    for (std::size_t i = 0; i + 1 < edges.size(); ++i) {
      const bool last = i + 2 == edges.size();
      const auto begin = std::lower_bound(sorted.begin(), sorted.end(), edges[i]);
      const auto end = last ? std::upper_bound(sorted.begin(), sorted.end(), edges[i + 1])
                            : std::lower_bound(sorted.begin(), sorted.end(), edges[i + 1]);
      const double width = edges[i + 1] - edges[i], count = static_cast<double>(end - begin);
      const double height = given[density] ? count / (width * static_cast<double>(sorted.size())) : count;
      const double a = edges[i] + 0.03 * width, b = edges[i + 1] - 0.03 * width;
      if (count > 0 && std::isfinite(height)) bars.areas.push_back({{a, b, b, a}, {0, 0, height, height}, {}});
    }
    bars.crisp = true;
    canvas.own_x();
    canvas.name(canvas.panel().y, given[density] ? "density" : "count");
    canvas.add(std::move(bars), given);
    if (given[density] && sorted.size() > 1 && sorted.back() - sorted.front() < 1e300) {
      const double span = sorted.back() - sorted.front();
      const std::vector<double> x = evenly(sorted.front() - 0.1 * span, sorted.back() + 0.1 * span, 240);
      canvas.add(line_series(x, kernel_density(sorted, x), {.ink = Ink::text}), given);
    }
    if (given[median] && !sorted.empty()) {
      const double middle = quantile(sorted, 0.5);
      canvas.panel().lines.push_back(
          {.axis = ReferenceLine::x, .at = middle, .label = fmt::format("median {:.3g}", middle)});
    }
  }

  Figure example() const override {
    Figure figure{.title = "Monte Carlo: overshoot of 1000 runs"};
    figure.add_panel({.x = Axis{.label = "overshoot [%]"}});
    example::Noise noise{3};
    std::vector<double> overshoot;
    for (int i = 0; i < 1000; ++i) {
      const double zeta = std::clamp(0.38 + 0.08 * noise(), 0.05, 0.95);
      overshoot.push_back(100 * std::exp(-3.14159265358979 * zeta / std::sqrt(1 - zeta * zeta)));
    }
    use(figure, 0, {{"values", overshoot}, {"density", true}, {"median", true}});
    return figure;
  }
};

}  // namespace

PLANTLOOP_PLOT(histogram, Histogram)

}  // namespace plantloop
