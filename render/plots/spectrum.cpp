// How a signal's power is spread over frequency.

#include <algorithm>
#include <cmath>

#include "render/error.h"
#include "render/numbers/statistics.h"
#include "render/plots/example.h"
#include "render/plots/plot.h"

namespace plantloop {
namespace {

struct SpectrumPlot : Plot {
  Column y{this, "y", "samples of the signal, evenly spaced"};
  Real period{this, "period", 1, "time between samples [s]"};
  Real length{this, "length", 0, "samples in a segment; 0: an eighth of all, at least 256"};
  Flag decibel{this, "decibel", "in decibel on a straight axis instead of a logarithmic one"};

  SpectrumPlot() : Plot("the power spectral density after Welch, over frequency") {}

  void draw(Canvas& canvas, const Given& given) const override {
    if (!(given[period] > 0) || !std::isfinite(given[period])) throw RenderError("'period' must be greater than 0");
    const std::size_t n = given[y].size();
    std::size_t segment = std::max<std::size_t>(n / 8, 256);
    if (given[length] >= 4) segment = static_cast<std::size_t>(std::min(given[length], 1e7));
    Spectrum s = welch(given[y], given[period], segment);
    // Zero frequency has no place on a logarithmic axis, and the mean was taken away.
    if (!s.frequency.empty()) {
      s.frequency.erase(s.frequency.begin());
      s.density.erase(s.density.begin());
    }
    if (given[decibel])
      for (double& v : s.density) v = 10 * std::log10(v);
    Axis& x = canvas.own_x();
    x.scale = Scale::log;
    canvas.name(x, "frequency [Hz]");
    if (!s.frequency.empty() && !x.limits.lower) x.limits = {s.frequency.front(), s.frequency.back()};
    Axis& axis = given.right ? canvas.panel().right : canvas.panel().y;
    if (!given[decibel]) axis.scale = Scale::log;
    canvas.name(axis, given[decibel] ? "power density [dB]" : "power density [1/Hz]");
    canvas.add(line_series(std::move(s.frequency), std::move(s.density), given.look), given);
  }

  Figure example() const override {
    Figure figure{.title = "Spectrum of a vibrating arm, measured with noise"};
    std::vector<double> signal;
    example::Noise noise{9};
    double x = 0, v = 0;
    constexpr double step = 0.002;
    for (int i = 0; i < 16384; ++i) {
      const double force = noise() * 20 + std::sin(2 * 3.14159265358979 * 50 * i * step) * 25;
      v += step * (force - 6 * v - 8000 * x);
      x += step * v;
      signal.push_back(1000 * x + 0.4 * noise());
    }
    figure.add_panel({.y = {.label = "acceleration density [(m/s²)²/Hz]"}});
    use(figure, 0, {{"y", signal}, {"period", step}, {"length", 2048.0}});
    return figure;
  }
};

}  // namespace

PLANTLOOP_PLOT(spectrum, SpectrumPlot)

}  // namespace plantloop
