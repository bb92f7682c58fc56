// Models beside what was measured.

#include <fmt/format.h>

#include <cmath>

#include "render/error.h"
#include "render/plots/example.h"
#include "render/plots/plot.h"

namespace plantloop {
namespace {

struct Comparison : Plot {
  Column x{this, "x", "time"};
  Column measured{this, "measured", "measured values"};
  Grid models{this, "models", "a row for each time, a column for each model"};
  Texts names{this, "names", "the models' names"};

  Comparison() : Plot("measured values against models, each with its fit, 100 (1 - |y - model| / |y - mean y|) %") {}

  void draw(Canvas& canvas, const Given& given) const override {
    check_lengths("x", given[x], "measured", given[measured]);
    const GridValues& all = given[models];
    if (all.rows != given[x].size())
      throw RenderError(fmt::format("x has {} numbers and models has {} rows", given[x].size(), all.rows));
    if (!given[names].empty() && given[names].size() != all.columns)
      throw RenderError(fmt::format("models has {} columns and names has {}", all.columns, given[names].size()));
    SeriesLook look = given.look;
    if (look.label.empty()) look.label = "measured";
    if (!look.color) look.ink = Ink::text;
    look.opacity = 0.75;
    canvas.add(line_series(given[x], given[measured], look), given);
    for (std::size_t k = 0; k < all.columns; ++k) {
      std::vector<double> y;
      for (std::size_t i = 0; i < all.rows; ++i) y.push_back(all.at(i, k));
      std::string name = given[names].empty() ? fmt::format("model {}", k + 1) : given[names][k];
      if (const double percent = fit(given[measured], y); std::isfinite(percent))
        name += fmt::format(", fit {}{:.1f} %", percent < 0 ? "−" : "", std::abs(percent));
      canvas.add(line_series(given[x], y, {.label = name}), given);
    }
  }

  Figure example() const override {
    Figure figure{.title = "Measured response and two identified models"};
    figure.x.label = "time [s]";
    figure.add_panel({.y = {.label = "temperature [°C]"}});
    const auto t = example::grid(0, 60, 301);
    example::Noise noise{8};
    GridValues made{t.size(), 2, {}};
    std::vector<double> truth;
    for (const double s : t) {
      const double y =
          20 + 18 * example::step_response(s - 4, 0.25, 0.45) - 9 * example::step_response(s - 34, 0.25, 0.45);
      truth.push_back(y + 0.4 * noise());
      const auto lag = [&](double from) { return s < from ? 0 : 1 - std::exp(-(s - from) / 4.6); };
      made.values.push_back(20 + 18 * lag(5) - 9 * lag(35));
      made.values.push_back(20 + 18.2 * example::step_response(s - 4.1, 0.25, 0.47) -
                            9.1 * example::step_response(s - 34.1, 0.25, 0.47));
    }
    use(figure, 0,
        {{"x", t}, {"measured", truth}, {"models", made}, {"names", std::vector<std::string>{"ARX 1", "ARX 2"}}});
    return figure;
  }

 private:
  // Where both are finite.
  static double fit(const std::vector<double>& y, const std::vector<double>& model) {
    double sum = 0, count = 0;
    for (std::size_t i = 0; i < y.size(); ++i)
      if (std::isfinite(y[i]) && std::isfinite(model[i])) sum += y[i], ++count;
    double error = 0, spread = 0;
    for (std::size_t i = 0; i < y.size(); ++i) {
      if (!std::isfinite(y[i]) || !std::isfinite(model[i])) continue;
      error = std::hypot(error, y[i] - model[i]);
      spread = std::hypot(spread, y[i] - sum / count);
    }
    return 100 * (1 - error / spread);
  }
};

}  // namespace

PLANTLOOP_PLOT(comparison, Comparison)

}  // namespace plantloop
