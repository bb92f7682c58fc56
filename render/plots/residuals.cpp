// What a model leaves unexplained.

#include <cmath>

#include "render/numbers/statistics.h"
#include "render/plots/example.h"
#include "render/plots/plot.h"

namespace plantloop {
namespace {

struct Residuals : Plot {
  Column x{this, "x", "time, or the samples' numbers"};
  Column measured{this, "measured", "measured values"};
  Column model{this, "model", "what the model says"};
  Real lags{this, "lags", 25, "the greatest shift of the autocorrelation, in samples"};

  Residuals() : Plot("measured less model over time, its distribution and its autocorrelation, in three panels") {}

  void draw(Canvas& canvas, const Given& given) const override {
    check_lengths("x", given[x], "measured", given[measured]);
    check_lengths("measured", given[measured], "model", given[model]);
    std::vector<double> residual;
    for (std::size_t i = 0; i < given[x].size(); ++i) residual.push_back(given[measured][i] - given[model][i]);
    const std::vector<double> sorted = finite_sorted(residual);
    const double sigma = deviation(sorted), middle = sorted.empty() ? 0 : mean(sorted);
    for (const std::size_t below : {1, 2}) {
      canvas.panel(below).height = 0.62;
      canvas.under(below).own_x();
    }
    Panel& top = canvas.panel();
    canvas.name(top.y, "residual");
    if (sigma > 0 && std::isfinite(sigma))
      top.bands.push_back({.lower = middle - 2 * sigma, .upper = middle + 2 * sigma, .label = "±2σ"});
    top.lines.push_back({.at = 0, .style = LineStyle::solid});
    SeriesLook look = given.look;
    canvas.add(line_series(given[x], residual, look), given);
    look.label.clear();
    further(canvas, 1, "histogram", {{"values", residual}, {"density", true}}, look);
    canvas.panel(1).x->label = "residual";
    further(canvas, 2, "correlation", {{"y", residual}, {"lags", given[lags]}}, look);
  }

  Figure example() const override {
    Figure figure{.title = "Residuals of an identified lag"};
    figure.x.label = "time [s]";
    const auto t = example::grid(0, 40, 401);
    example::Noise noise{4};
    std::vector<double> truth, guess;
    for (const double s : t) {
      truth.push_back(std::sin(0.8 * s) + 0.06 * noise());
      guess.push_back(std::sin(0.8 * s - 0.03));
    }
    use(figure, 0, {{"x", t}, {"measured", truth}, {"model", guess}});
    return figure;
  }

 private:
  static void further(const Canvas& canvas, std::size_t below, std::string_view type,
                      std::initializer_list<std::pair<std::string_view, PlotValue>> values, const SeriesLook& look) {
    Canvas under = canvas.under(below);
    find_plot(type)->use(under, values, look);
  }
};

}  // namespace

PLANTLOOP_PLOT(residuals, Residuals)

}  // namespace plantloop
