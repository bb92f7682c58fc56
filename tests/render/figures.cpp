// Builds the test figures. Data are closed forms; noise is a seeded linear congruence.

#include "tests/render/figures.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>

#include "render/plots/plot.h"

namespace plantloop {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double inf = std::numeric_limits<double>::infinity();

std::vector<double> grid(double from, double to, int count) {
  std::vector<double> result;
  for (int i = 0; i < count; ++i) result.push_back(from + (to - from) * i / (count - 1));
  return result;
}

std::vector<double> map(const std::vector<double>& x, const std::function<double(double)>& f) {
  std::vector<double> result;
  for (const double v : x) result.push_back(f(v));
  return result;
}

// Unit step response of a second-order lag, damping below one.
double step_response(double t, double wn, double zeta) {
  if (t < 0) return 0;
  const double wd = wn * std::sqrt(1 - zeta * zeta);
  return 1 - std::exp(-zeta * wn * t) * (std::cos(wd * t) + zeta * wn / wd * std::sin(wd * t));
}

double step_speed(double t, double wn, double zeta) {
  if (t < 0) return 0;
  const double wd = wn * std::sqrt(1 - zeta * zeta);
  return wn * wn / wd * std::exp(-zeta * wn * t) * std::sin(wd * t);
}

struct Noise {
  std::uint32_t state = 1;
  double operator()() {
    double sum = 0;
    for (int i = 0; i < 12; ++i) {
      state = state * 1664525u + 1013904223u;
      sum += static_cast<double>(state >> 8) / 16777216.0;
    }
    return sum - 6;
  }
};

// The servo of the format's example on figures.
Figure servo() {
  const auto t = grid(0, 6, 601);
  const auto y = map(t, [](double s) { return step_response(s - 0.5, 4, 0.35); });
  const auto v = map(t, [](double s) { return step_speed(s - 0.5, 4, 0.35); });
  Figure f{.title = "Step response of a servo"};
  f.x = {.label = "time [s]", .limits = {0, 6}};
  Panel& top = f.add_panel({.y = {.label = "position [m]", .limits = {0, 1.6}}});
  top.line({0, 0.5, 0.5, 6}, {0, 0, 1, 1}, {.label = "set point", .style = LineStyle::dashed});
  top.line(t, y, {.label = "position"});
  top.bands.push_back({.lower = 0.98, .upper = 1.02, .from = 0.5, .label = "±2 %"});
  top.lines.push_back({.at = 1.31, .label = "limit"});
  top.lines.push_back({.axis = ReferenceLine::x, .at = 0.5});
  Panel& low = f.add_panel({.y = {.label = "speed [m/s]"}, .right = {.label = "drive [m/s²]"}});
  low.line(t, v, {.label = "v"});
  low.right_series.push_back(line_series(
      t, map(t, [](double s) { return 16 * ((s >= 0.5 ? 1 : 0) - step_response(s - 0.5, 4, 0.35)); }), {.label = "u"}));
  return f;
}

Figure uncertainty() {
  const auto t = grid(0, 10, 1001);
  Figure f{.title = "Step response under ±20 % damping uncertainty"};
  f.x.label = "time t [s]";
  Panel& p = f.add_panel({.y = {.label = "output y(t)"}});
  const auto spread = [&](double by, bool upper) {
    return map(t, [=](double s) {
      double best = step_response(s, 3, 0.14);
      for (double z = 0.14 - by; z <= 0.14 + by; z += by / 10)
        best = upper ? std::max(best, step_response(s, 3, z)) : std::min(best, step_response(s, 3, z));
      return best;
    });
  };
  p.band(t, spread(0.1, false), spread(0.1, true), {.color_of = 2});
  p.band(t, spread(0.05, false), spread(0.05, true), {.color_of = 2});
  p.line(t, map(t, [](double s) { return step_response(s, 3, 0.14); }), {.label = "ζ = 0.14"});
  p.line(t, map(t, [](double s) { return step_response(s, 3, 0.7); }), {.label = "ζ = 0.70"});
  p.lines.push_back({.at = 1});
  return f;
}

Figure ends() {
  const auto t = grid(0, 10, 501);
  Figure f{.title = "Tracking of three set points"};
  f.x.label = "time [s]";
  Panel& p = f.add_panel({.y = {.label = "speed v_{car} [m s^{-1}]"}});
  for (const double goal : {8.0, 14.0, 20.0})
    p.line(t, map(t, [=](double s) { return goal * step_response(s, 2, 0.6); }),
           {.label = fmt::format("v_ref = {:g}", goal)});
  return f;
}

Figure portrait() {
  Figure f{.title = "Van der Pol, phase portrait"};
  Panel& p = f.add_panel({.x = Axis{.label = "position x_1 [m]"}, .y = {.label = "speed x_2 [m/s]"}, .equal = true});
  for (const auto& [x0, v0] : {std::pair{0.1, 0.0}, {3.0, 3.0}, {-3.0, -2.0}}) {
    double x = x0, v = v0;
    std::vector<double> xs, vs;
    for (int i = 0; i < 20000; ++i) {
      xs.push_back(x);
      vs.push_back(v);
      const double h = 0.001, a = (1 - x * x) * v - x;
      v += h * a;
      x += h * v;
    }
    p.line(xs, vs, {.label = fmt::format("from ({:g}, {:g})", x0, v0)});
  }
  p.markers({0}, {0}, {.label = "rest", .marker = Marker::ring});
  return f;
}

Figure bode() {
  Figure f{.title = "Bode diagram, L(s) = 4 / (s (s+1) (0.1s+1))"};
  f.x = {.label = "frequency ω [rad s^{-1}]", .scale = Scale::log};
  std::vector<double> w = map(grid(-1, 2, 400), [](double e) { return std::pow(10, e); });
  Panel& gain = f.add_panel({.y = {.label = "gain [dB]"}});
  gain.line(w, map(w, [](double o) { return 20 * std::log10(4 / (o * std::hypot(1, o) * std::hypot(1, 0.1 * o))); }));
  gain.lines.push_back({.at = 0});
  gain.lines.push_back({.axis = ReferenceLine::x,
                        .at = 1.86,
                        .label = "ω_c = 1.86 rad/s",
                        .style = LineStyle::dotted,
                        .color = rgb(0x009E73)});
  Panel& phase = f.add_panel({.y = {.label = "phase [°]"}});
  phase.line(w, map(w, [](double o) { return (-M_PI / 2 - std::atan(o) - std::atan(0.1 * o)) * 180 / M_PI; }));
  phase.lines.push_back({.at = -180});
  phase.lines.push_back({.axis = ReferenceLine::x, .at = 1.86, .style = LineStyle::dotted, .color = rgb(0x009E73)});
  return f;
}

Figure sampled() {
  const auto t = grid(0, 5, 501);
  const auto k = grid(0, 4.9, 50);
  Figure f{.title = "A sampled controller"};
  f.x.label = "time [s]";
  const auto u = [](double s) { return 2 * std::exp(-0.5 * s) * std::cos(3 * s); };
  Panel& a = f.add_panel({.y = {.label = "input u [V]"}});
  a.stairs(k, map(k, u), {.label = "held"});
  a.line(t, map(t, u), {.label = "continuous", .style = LineStyle::dotted});
  Panel& b = f.add_panel({.y = {.label = "samples"}});
  b.line(k, map(k, [&](double s) { return u(s) * u(s); }), {.label = "power", .marker = Marker::dot});
  b.markers(k, map(k, [&](double s) { return 1.5 * std::abs(u(s + 0.2)); }),
            {.label = "peaks", .marker = Marker::diamond});
  Panel& c = f.add_panel({.y = {.label = "mode"}, .height = 0.5});
  c.stairs({0, 1.2, 1.9, 3.1, 4.4}, {0, 1, 2, 1, 0});
  return f;
}

Figure many(int count, double frequency) {
  const auto t = grid(0, 10, 300);
  Figure f{.title = fmt::format("{} runs of a sweep", count)};
  f.x.label = "time [s]";
  Panel& p = f.add_panel({.y = {.label = "amplitude"}});
  for (int i = 0; i < count; ++i)
    p.line(t, map(t, [=](double s) { return std::sin(frequency * s + 0.7 * i) * (1 + 0.1 * i); }),
           {.label = fmt::format("run {}", i + 1)});
  return f;
}

Figure long_labels() {
  const auto t = grid(0, 1e-3, 100);
  Figure f{
      .title =
          "A very long title that tells the whole story of this experiment, from the choice of the sampling time to "
          "the last "
          "of its many surprising results, and then some more words that nobody will ever read to the end of the line"};
  f.x.label =
      "time since the beginning of the very first of all the measurements that were taken in the laboratory in that "
      "summer [s]";
  Panel& p = f.add_panel(
      {.y = {.label = "temperature difference between the inlet and the outlet of the heat exchanger, filtered [K]"}});
  p.line(t, map(t, [](double s) { return 1e6 * std::sin(1e4 * s); }),
         {.label = "the measured signal after the anti-aliasing filter and the calibration of the sensor"});
  p.line(t, map(t, [](double s) { return -1e6 * std::sin(2e4 * s); }), {.label = "the other one"});
  p.lines.push_back({.at = 5e5, .label = "a limit which the engineers agreed upon in a long meeting"});
  return f;
}

Figure strange(const std::string& title, std::vector<double> x, std::vector<double> y, Scale scale = Scale::linear) {
  Figure f{.title = title};
  f.x.label = "time [s]";
  f.add_panel({.y = {.label = "value", .scale = scale}}).line(std::move(x), std::move(y), {.label = "data"});
  return f;
}

Figure small_multiples() {
  const auto t = grid(0, 8, 401);
  Figure f{.title = "One loop, six gains", .columns = 3, .share_y = true};
  f.x.label = "time [s]";
  for (const double k : {0.5, 1.0, 2.0, 4.0, 8.0, 16.0}) {
    Panel& p = f.add_panel({.title = fmt::format("k = {:g}", k), .y = {.label = k == 0.5 || k == 4 ? "y" : ""}});
    p.line(t, map(t, [=](double s) { return step_response(s, std::sqrt(2 * k), 0.7 / std::sqrt(k + 0.3)); }));
    p.lines.push_back({.at = 1});
  }
  return f;
}

Figure inset() {
  const auto t = grid(0, 20, 2001);
  Figure f{.title = "A settled response is not at rest"};
  f.x.label = "time [s]";
  Panel& p = f.add_panel({.y = {.label = "position [m]"}});
  const auto y = map(t, [](double s) { return step_response(s, 1.5, 0.5) + 0.004 * std::sin(9 * s); });
  p.line(t, y, {.label = "y"});
  Panel& detail = p.insets.emplace_back();
  detail.x = Axis{.limits = {12, 16}};
  detail.y.limits = {0.99, 1.01};
  detail.line(t, y);
  return f;
}

Figure symmetric() {
  const auto t = grid(0, 10, 801);
  Figure f{.title = "A diverging oscillation on a symmetric logarithmic axis"};
  f.x.label = "time [s]";
  Panel& p = f.add_panel({.y = {.label = "amplitude", .scale = Scale::symlog}});
  p.line(t, map(t, [](double s) { return 0.01 * std::exp(1.4 * s) * std::sin(4 * s); }), {.label = "y"});
  return f;
}

Figure remarks() {
  const auto t = grid(0, 10, 501);
  Figure f{.title = "Remarks find their place"};
  f.x.label = "time [s]";
  Panel& p = f.add_panel({.y = {.label = "y"}});
  const auto y = [](double s) { return std::sin(s) + 0.3 * std::sin(5 * s); };
  p.line(t, map(t, y), {.label = "measured"});
  for (const double at : {0.3, 1.6, 3.0, 4.7, 6.2, 7.9, 9.4})
    p.callouts.push_back({.x = at, .y = y(at), .label = fmt::format("y({:g} s) = {:.2f}", at, y(at)), .color_of = 0});
  return f;
}

Figure formulas() {
  const auto t = grid(0, 10, 301);
  Figure f{.title =
               "\\dot{x} = -\\frac{x}{\\tau} + \\sqrt{K u},  \\hat{y}(k) = \\bar{w}^{T} \\tilde{x}_1, \\ddot\\theta + "
               "\\omega_0^2\\theta = 0"};
  f.x.label = "time t/\\tau";
  Panel& p = f.add_panel({.y = {.label = "response \\frac{x(t)}{\\sqrt{K u_0} \\tau}"}});
  p.line(t, map(t, [](double s) { return 1 - std::exp(-s); }), {.label = "1 - e^{-t/\\tau}"});
  p.line(t, map(t, [](double s) { return 1 - std::exp(-0.4 * s); }), {.label = "\\hat{x}, \\frac{1}{1 + 2.5 \\tau s}"});
  p.lines.push_back({.at = 1, .label = "x(\\infty) = \\bar x"});
  return f;
}

Figure twin_many() {
  const auto t = grid(0, 20, 800);
  Figure f{.title = "Tank: levels and flows"};
  f.x.label = "time [min]";
  Panel& p = f.add_panel({.y = {.label = "level [m]"}, .right = {.label = "flow [m³/s]"}});
  p.line(t, map(t, [](double s) { return 2 - std::exp(-0.3 * s); }), {.label = "h_1"});
  p.line(t, map(t, [](double s) { return 1.2 - 0.9 * std::exp(-0.15 * s); }), {.label = "h_2"});
  p.right_series.push_back(stairs_series({0, 5, 10, 15}, {0.002, 0.0045, 0.001, 0.0031}, {.label = "q_{in}"}));
  p.bands.push_back({.from = 5, .until = 10, .label = "disturbance"});
  p.lines.push_back({.at = 1.8, .label = "overflow", .color = parse_color("red")});
  return f;
}

}  // namespace

Figure noisy_steps() {
  const auto t = grid(0, 10, 10000);
  Figure f{.title = "Step responses for five dampings, with sensor noise"};
  f.x.label = "time t [s]";
  Panel& p = f.add_panel({.y = {.label = "output y [m]"}});
  Noise noise;
  for (const double zeta : {0.1, 0.2, 0.4, 0.7, 0.9})
    p.line(t, map(t, [&](double s) { return step_response(s, 2, zeta) + 0.01 * noise(); }),
           {.label = fmt::format("ζ = {:.1f}", zeta)});
  return f;
}

Figure random_figure(std::uint32_t seed) {
  Noise noise{seed * 2654435761u + 12345u};
  const auto uniform = [&] {
    noise.state = noise.state * 1664525u + 1013904223u;
    return static_cast<double>(noise.state >> 8) / 16777216.0;
  };
  const auto pick = [&](int count) { return static_cast<int>(uniform() * count); };
  const auto words = [&](int most) {
    const char* some[] = {"position", "x_1",    "a rather long name",       "θ", "v_{ref}", "tire_force",
                          "q",        "Σ |e|²", "temperature of the outlet"};
    std::string text;
    for (int i = pick(most + 1); i > 0; --i) text += (text.empty() ? "" : " ") + std::string(some[pick(9)]);
    return text;
  };
  const auto value = [&] {
    const double special[] = {nan, inf, -inf, 0, 1e300, -1e300, 1e-300};
    return pick(200) == 0 ? special[pick(7)] : noise();
  };
  Figure f{.title = words(6)};
  f.theme = pick(3) == 0 ? "dark" : "light";
  f.width = 80 + 200 * uniform();
  f.x = {.label = words(3)};
  if (pick(4) == 0) f.x.limits = {0.1, 0.9};
  if (pick(5) == 0) f.x.scale = Scale::log;
  for (int panels = 1 + pick(3); panels > 0; --panels) {
    Panel& p = f.add_panel({.title = pick(3) == 0 ? words(3) : ""});
    p.y = {.label = words(3), .scale = pick(5) == 0 ? Scale::log : Scale::linear};
    p.right.label = words(2);
    if (pick(4) == 0) p.x = Axis{.label = words(2)};
    p.equal = pick(6) == 0;
    const double size = std::pow(10, pick(20) - 10), mean = pick(3) == 0 ? size * 1e3 : 0;
    for (int count = pick(8); count > 0; --count) {
      std::vector<double> x, y, low;
      const int n = pick(4) == 0 ? pick(3) : 5 + pick(500);
      double walk = noise();
      for (int i = 0; i < n; ++i) {
        x.push_back(p.x ? noise() : static_cast<double>(i) / n);
        walk += 0.1 * value();
        if (!std::isfinite(walk)) walk = 0;
        y.push_back(mean + size * (pick(30) == 0 ? value() : walk));
        low.push_back(y.back() - size * uniform());
      }
      const SeriesLook look{.label = pick(4) == 0 ? "" : words(2),
                            .style = static_cast<LineStyle>(pick(3)),
                            .marker = static_cast<Marker>(pick(5) == 0 ? pick(8) : 0)};
      auto& list = pick(4) == 0 ? p.right_series : p.series;
      if (pick(5) == 0)
        list.push_back(band_series(x, low, y, look));
      else if (pick(4) == 0)
        list.push_back(stairs_series(x, y, look));
      else
        list.push_back(line_series(x, y, look));
    }
    for (int count = pick(3); count > 0; --count)
      p.lines.push_back({.axis = pick(2) ? ReferenceLine::x : ReferenceLine::y,
                         .at = pick(2) ? uniform() : mean + size * noise(),
                         .label = words(2)});
    if (pick(3) == 0)
      p.bands.push_back({.lower = mean - size, .upper = mean + size * uniform(), .from = 0.2, .label = words(2)});
  }
  return f;
}

std::vector<NamedFigure> test_figures() {
  std::vector<NamedFigure> all{
      {"servo", servo()},
      {"uncertainty", uncertainty()},
      {"noisy_steps", noisy_steps()},
      {"ends", ends()},
      {"portrait", portrait()},
      {"bode", bode()},
      {"sampled", sampled()},
      {"twin_many", twin_many()},
      {"small_multiples", small_multiples()},
      {"inset", inset()},
      {"symmetric", symmetric()},
      {"symmetric_data", strange("Positive only", {0, 1, 2}, {0, 3, 2000}, Scale::symlog)},
      {"symmetric_nothing", strange("Nothing", {}, {}, Scale::symlog)},
      {"symmetric_wide", strange("From tiny to huge", {0, 1, 2, 3}, {-1e300, -1e-300, 0, 1e250}, Scale::symlog)},
      {"remarks", remarks()},
      {"formulas", formulas()},
      {"many_9", many(9, 1.0)},
      {"many_40", many(40, 0.5)},
      {"many_300", many(300, 0.5)},
      {"long_labels", long_labels()},
      {"no_panels", Figure{.title = "Nothing at all"}},
      {"no_data", strange("No data", {}, {})},
      {"one_sample", strange("One sample", {2}, {3})},
      {"constant", strange("A constant", {0, 10}, {20, 20})},
      {"zero", strange("Zero", {0, 10}, {0, 0})},
      {"huge", strange("Huge", {0, 1, 2, 3}, {-1e300, 1e300, 5e299, -1.7e308})},
      {"tiny", strange("Tiny", {0, 1e-300, 2e-300}, {1e-300, 5e-300, 2e-300})},
      {"offset", strange("A large mean", {0, 1, 2, 3, 4}, {1e6, 1e6 + 0.01, 1e6 + 0.005, 1e6 + 0.02, 1e6 + 0.003})},
      {"not_finite", strange("Gaps", {0, 1, 2, 3, 4, 5, 6, 7, 8, 9}, {1, 2, nan, 2, 3, inf, 1, 2, -inf, 4})},
      {"all_nan", strange("Nothing but NaN", {0, 1, 2}, {nan, nan, nan})},
      {"log_negative",
       strange("A logarithm of what is not positive", {0, 1, 2, 3, 4, 5}, {-1, 0, 0.01, 1, 1000, -5}, Scale::log)},
      {"log_all_negative", strange("No logarithm at all", {0, 1, 2}, {-1, -2, -3}, Scale::log)},
      {"log_narrow", strange("Less than a decade", {0, 1, 2}, {2.2, 3.1, 7.4}, Scale::log)},
      {"log_wide", strange("Many decades", {0, 1, 2}, {1e-250, 1, 1e280}, Scale::log)},
      {"dark", uncertainty()},
      {"print", servo()},
      {"column", servo()},
      {"small", strange("Small", {0, 1}, {0, 1})},
  };
  for (const Plot* plot : plots()) all.push_back({"plot_" + std::string(plot->name()), plot->example()});
  for (NamedFigure& f : all) {
    if (f.name == "dark") f.figure.theme = "dark";
    if (f.name == "print") f.figure.theme = "print";
    if (f.name == "column") f.figure.width = 86, f.figure.dpi = 300;
    if (f.name == "small") f.figure.width = 40, f.figure.height = 30;
    if (f.name == "log_wide") f.figure.add_panel(f.figure.panels[0]);
  }
  return all;
}

}  // namespace plantloop
