// Gain and phase over frequency.

#include <cmath>

#include "render/plots/system.h"

namespace plantloop {
namespace {

struct Bode : Plot {
  FrequencyData data{this};
  Flag show_margins{this, "margins", "mark gain and phase margin", true};

  Bode() : Plot("gain and phase over frequency one above the other, with the margins marked") {}

  void draw(Canvas& canvas, const Given& given) const override {
    const Response r = data.response(given);
    Axis& x = canvas.own_x();
    x.scale = Scale::log;
    canvas.name(x, "frequency ω [rad s^{-1}]");
    canvas.name(canvas.panel().y, "gain [dB]");
    canvas.name(canvas.panel(1).y, "phase [°]");
    SeriesLook look = given.look;
    const std::size_t series = canvas.add(line_series(r.w, r.gain, look), given);
    look.label.clear();
    canvas.add(line_series(r.w, r.phase, look), given, 1);
    const bool first = canvas.panel().lines.empty();
    if (first) canvas.panel().lines.push_back({.at = 0});
    if (first) canvas.panel(1).lines.push_back({.at = -180});
    if (given[show_margins]) mark(canvas, margins(r), series);
  }

  Figure example() const override {
    Figure figure{.title = "Bode diagram, L(s) = 4 / (s (s+1) (0.1s+1))"};
    use(figure, 0,
        {{"num", std::vector<double>{4}}, {"den", std::vector<double>{0.1, 1.1, 1, 0}}, {"from", 0.1}, {"to", 100.0}});
    return figure;
  }

 private:
  static void mark(Canvas& canvas, const Margins& m, std::size_t series) {
    if (m.gain_crossover && std::isfinite(*m.phase_margin)) {
      const double w = *m.gain_crossover, phase = *m.phase_margin - 180;
      canvas.panel().callouts.push_back(
          {.x = w, .y = 0, .label = "ω_c = " + short_number(w) + " rad/s", .color_of = series});
      canvas.panel(1).callouts.push_back(
          {.x = w, .y = phase, .label = "phase margin " + short_number(*m.phase_margin) + "°", .color_of = series});
      stroke(canvas.panel(1), w, -180, phase);
    }
    if (m.phase_crossover && std::isfinite(*m.gain_margin)) {
      const double w = *m.phase_crossover;
      canvas.panel().callouts.push_back({.x = w,
                                         .y = -*m.gain_margin,
                                         .label = "gain margin " + short_number(*m.gain_margin) + " dB",
                                         .color_of = series});
      canvas.panel(1).callouts.push_back({.x = w, .y = -180, .color_of = series});
      stroke(canvas.panel(), w, 0, -*m.gain_margin);
    }
  }

  // From the line that must not be passed to the curve.
  static void stroke(Panel& panel, double w, double from, double to) {
    panel.line({w, w}, {from, to}, {.width = 1.4, .ink = Ink::text});
  }
};

}  // namespace

PLANTLOOP_PLOT(bode, Bode)

}  // namespace plantloop
