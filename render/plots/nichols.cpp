// Gain over phase.

#include <algorithm>
#include <cmath>

#include "render/numbers/statistics.h"
#include "render/plots/system.h"

namespace plantloop {
namespace {

constexpr double pi = 3.14159265358979323846;

struct Nichols : Plot {
  FrequencyData data{this};
  Flag chart{this, "chart", "lines of equal closed-loop gain", true};

  Nichols() : Plot("gain over phase of the open loop, on a chart of the closed loop's gain") {}

  void draw(Canvas& canvas, const Given& given) const override {
    const Response r = data.response(given);
    canvas.name(canvas.own_x(), "phase of L(jω) [°]");
    canvas.name(canvas.panel().y, "gain of L(jω) [dB]");
    Panel& panel = canvas.panel();
    const bool first = panel.callouts.empty();
    if (given[chart] && first) draw_chart(panel);
    if (first) panel.callouts.push_back({.x = -180, .y = 0, .label = "−1", .marker = Marker::cross});
    const std::size_t series = canvas.add(line_series(r.phase, r.gain, given.look), given);
    const Margins m = margins(r);
    if (m.gain_crossover && std::isfinite(*m.phase_margin))
      panel.callouts.push_back(
          {.x = *m.phase_margin - 180, .y = 0, .label = short_number(*m.phase_margin) + "°", .color_of = series});
    if (m.phase_crossover && std::isfinite(*m.gain_margin))
      panel.callouts.push_back(
          {.x = -180, .y = -*m.gain_margin, .label = short_number(*m.gain_margin) + " dB", .color_of = series});
    if (first) {
      panel.x->limits = {-270, -45};
      panel.y.limits = {-40, 40};
    }
  }

  Figure example() const override {
    Figure figure{.title = "Nichols chart, L(s) = 4 / (s (s+1) (0.1s+1))"};
    use(figure, 0, {{"num", std::vector<double>{4}}, {"den", std::vector<double>{0.1, 1.1, 1, 0}}});
    return figure;
  }

 private:
  // L = T / (1 - T) for T of equal size.
  static void draw_chart(Panel& panel) {
    for (const double decibel : {12.0, 6.0, 3.0, 1.0, 0.0, -1.0, -3.0, -6.0, -12.0, -20.0}) {
      const double size = std::pow(10, decibel / 20);
      std::vector<double> x, y;
      for (const double angle : evenly(0.002, 2 * pi - 0.002, 361)) {
        const Complex closed = std::polar(size, angle), open = closed / (1.0 - closed);
        double phase = std::arg(open) * 180 / pi;
        if (phase > 0) phase -= 360;
        // A line does not run back across the whole chart.
        if (!x.empty() && std::abs(phase - x.back()) > 180) {
          x.push_back(std::nan(""));
          y.push_back(std::nan(""));
        }
        x.push_back(phase);
        y.push_back(20 * std::log10(std::abs(open)));
      }
      panel.line(x, y, {.width = 0.55, .ink = Ink::reference, .opacity = 0.6});
      // Lines that close about -1 are named at their top, the others at the left.
      const Complex top = std::polar(size, decibel > 0 ? pi * 1e-6 + pi : pi * 1.25);
      const Complex open = decibel > 0 ? std::polar(size, 0.0) / (1.0 - std::polar(size, 0.0)) : top / (1.0 - top);
      double phase = std::arg(open) * 180 / pi;
      if (phase > 0) phase -= 360;
      std::string label = short_number(decibel) + " dB";
      panel.callouts.push_back({.x = phase, .y = 20 * std::log10(std::abs(open)), .label = label, .quiet = true});
    }
  }
};

}  // namespace

PLANTLOOP_PLOT(nichols, Nichols)

}  // namespace plantloop
