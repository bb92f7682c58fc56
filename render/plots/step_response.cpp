// A step response with its measures.

#include <algorithm>
#include <cmath>
#include <optional>

#include "render/plots/example.h"
#include "render/plots/system.h"

namespace plantloop {
namespace {

struct StepResponse : Plot {
  Column t{this, "t", "time [s], ascending"};
  Column y{this, "y", "the response"};
  Real from{this, "from_value", std::nan(""), "the value before the step; else the first of y"};
  Real to{this, "to_value", std::nan(""), "the value it should settle at; else the last of y"};
  Real at{this, "at", std::nan(""), "when the step is [s]; else the first time"};
  Real band{this, "band", 0.02, "settled is what stays this near to the end value, as a part of the step"};

  StepResponse() : Plot("a step response with overshoot, rise time and settling time called out") {}

  void draw(Canvas& canvas, const Given& given) const override {
    check_lengths("t", given[t], "y", given[y]);
    const std::size_t series = canvas.add(line_series(given[t], given[y], given.look), given);
    const std::vector<double>&ts = given[t], &ys = given[y];
    if (ts.size() < 2) return;
    const double before = std::isfinite(given[from]) ? given[from] : ys.front();
    const double goal = std::isfinite(given[to]) ? given[to] : ys.back();
    const double start = std::isfinite(given[at]) ? given[at] : ts.front(), step = goal - before;
    if (step == 0 || !std::isfinite(step)) return;
    Panel& panel = canvas.panel();
    const auto part = [&](std::size_t i) { return (ys[i] - before) / step; };
    const auto add = [&](double when, double value, const std::string& label) {
      panel.callouts.push_back({.x = when, .y = value, .label = label, .color_of = series, .right = given.right});
    };
    std::size_t peak = 0;
    for (std::size_t i = 0; i < ts.size(); ++i)
      if (ts[i] >= start && (part(i) > part(peak) || !std::isfinite(ys[peak]))) peak = i;
    if (part(peak) > 1.0005)
      add(ts[peak], ys[peak],
          "overshoot " + short_number(100 * (part(peak) - 1)) + " % at " + short_number(ts[peak] - start) + " s");

    const std::optional<double> low = first(ts, ys, start, before + 0.1 * step, step),
                                high = first(ts, ys, start, before + 0.9 * step, step);
    if (low && high) add(*high, before + 0.9 * step, "rise time " + short_number(*high - *low) + " s");
    const double near = std::clamp(given[band], 0.0, 1.0);
    std::size_t settled = ts.size();
    while (settled > 0 && std::abs(part(settled - 1) - 1) <= near) --settled;
    if (settled < ts.size() && settled > 0)
      add(ts[settled], ys[settled], "settled after " + short_number(ts[settled] - start) + " s");
    if (!given.right) {
      panel.lines.push_back({.at = goal});
      panel.bands.push_back({.lower = goal - near * std::abs(step),
                             .upper = goal + near * std::abs(step),
                             .from = start,
                             .label = "±" + short_number(100 * near) + " %"});
    }
  }

  Figure example() const override {
    Figure figure{.title = "Step response of the position loop"};
    figure.x.label = "time t [s]";
    figure.add_panel({.y = {.label = "position y [m]"}});
    const auto times = example::grid(0, 8, 801);
    use(figure, 0,
        {{"t", times},
         {"y", example::map(times, [](double s) { return example::step_response(s, 2, 0.35); })},
         {"to_value", 1.0}});
    return figure;
  }

 private:
  // When the response first reaches the level.
  static std::optional<double> first(const std::vector<double>& ts, const std::vector<double>& ys, double start,
                                     double level, double step) {
    for (std::size_t i = 1; i < ts.size(); ++i) {
      const double a = (ys[i - 1] - level) / step, b = (ys[i] - level) / step;
      if (ts[i] >= start && a < 0 && b >= 0) return ts[i - 1] + (ts[i] - ts[i - 1]) * (a / (a - b));
    }
    return std::nullopt;
  }
};

}  // namespace

PLANTLOOP_PLOT(step_response, StepResponse)

}  // namespace plantloop
