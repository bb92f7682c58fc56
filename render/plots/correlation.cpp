// How a signal resembles itself, or another one, some samples later.

#include <algorithm>
#include <cmath>
#include <limits>

#include "render/numbers/statistics.h"
#include "render/plots/example.h"
#include "render/plots/plot.h"

namespace plantloop {
namespace {

struct Correlation : Plot {
  Column y{this, "y", "the signal, as the residuals of a model"};
  Column with{this, "with", "the signal to compare with, as the input; else y itself", Need::optional};
  Real lags{this, "lags", 25, "the greatest shift, in samples"};

  Correlation() : Plot("auto- or cross-correlation with the bounds that white noise keeps to 95 %") {}

  void draw(Canvas& canvas, const Given& given) const override {
    const std::vector<double>& other = given.has(with) ? given[with] : given[y];
    check_lengths("y", given[y], "with", other);
    const std::size_t n = given[y].size();
    const int most = static_cast<int>(
        std::clamp(std::isfinite(given[lags]) ? given[lags] : 25, 1.0, std::max(static_cast<double>(n) - 1, 1.0)));
    const std::vector<double> all = plantloop::correlation(other, given[y], most);
    std::vector<double> x, value, stem_x, stem_y;
    // An autocorrelation is even: one half tells all.
    for (int lag = given.has(with) ? -most : 0; lag <= most; ++lag) {
      x.push_back(lag);
      value.push_back(all[static_cast<std::size_t>(lag + most)]);
      stem_x.insert(stem_x.end(), 3, lag);
      stem_y.insert(stem_y.end(), {0, value.back(), std::numeric_limits<double>::quiet_NaN()});
    }
    Axis& axis = canvas.own_x();
    canvas.name(axis, "lag [samples]");
    if (!axis.limits.lower) axis.limits = {x.front() - 0.5, x.back() + 0.5};
    canvas.name(canvas.panel().y, given.has(with) ? "cross-correlation" : "autocorrelation");
    Panel& panel = canvas.panel();
    if (n > 0) {
      const double bound = 1.96 / std::sqrt(static_cast<double>(n));
      panel.bands.push_back({.lower = -bound, .upper = bound, .label = "95 %"});
    }
    panel.lines.push_back({.at = 0, .style = LineStyle::solid});
    SeriesLook stems = given.look, heads = given.look;
    stems.label.clear();
    if (stems.width == 0) stems.width = 0.8;
    canvas.add(line_series(stem_x, stem_y, stems), given);
    heads.same_color = true;
    if (heads.size == 0) heads.size = 3;
    canvas.add(marker_series(x, value, heads), given);
  }

  Figure example() const override {
    Figure figure{.title = "Residuals of a model that misses a time constant"};
    std::vector<double> residual, input;
    example::Noise noise{21};
    double state = 0;
    for (int i = 0; i < 400; ++i) {
      input.push_back(noise.uniform() < 0.5 ? -1 : 1);
      state = 0.72 * state + 0.25 * (i > 2 ? input[static_cast<std::size_t>(i - 3)] : 0);
      residual.push_back(0.6 * state + 0.5 * noise());
    }
    figure.add_panel({.title = "with itself"});
    use(figure, 0, {{"y", residual}});
    figure.add_panel({.title = "with the input"});
    use(figure, 1, {{"y", residual}, {"with", input}});
    return figure;
  }
};

}  // namespace

PLANTLOOP_PLOT(correlation, Correlation)

}  // namespace plantloop
