// plantloop linearise: a diagram as a linear model around an operating point, with poles, zeros and frequency response.

#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <numbers>

#include "app/command.h"
#include "app/draw.h"
#include "app/request.h"
#include "engine/analysis/linearise.h"
#include "engine/base/error.h"
#include "engine/base/numbers.h"

namespace plantloop::app {

namespace {

struct LinearOptions {
  std::string file, out, response, figure;
  std::vector<std::string> set;
  LineariseRequest request;
  double at = NAN, low = NAN, high = NAN;
  std::size_t points = 400;
};

std::string list_of(const std::vector<std::string>& names) {
  return names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "));
}

std::string text_of(const std::string& name, const DenseMatrix& m) {
  if (m.rows == 0 || m.columns == 0) return fmt::format("{} = none\n", name);
  std::string text = fmt::format("{} =\n", name);
  for (std::size_t i = 0; i < m.rows; ++i) {
    text += "  ";
    for (std::size_t j = 0; j < m.columns; ++j) text += fmt::format("{:>16.9g}", m(i, j));
    text += "\n";
  }
  return text;
}

std::string text_of(std::complex<double> z) {
  if (z.imag() == 0) return fmt::format("{:.9g}", z.real());
  return fmt::format("{:.9g} {} {:.9g}i", z.real(), z.imag() < 0 ? "-" : "+", std::fabs(z.imag()));
}

std::string text_of(const std::vector<std::complex<double>>& roots) {
  std::vector<std::string> texts;
  for (const auto z : roots) texts.push_back(text_of(z));
  return list_of(texts);
}

std::string summary(const LinearModel& m) {
  std::string text = m.period > 0 ? fmt::format("sampled every {} s, at {} s\n", m.period, m.time)
                                  : fmt::format("continuous, at {} s\n", m.time);
  text +=
      fmt::format("states: {}\ninputs: {}\noutputs: {}\n", list_of(m.states), list_of(m.inputs), list_of(m.outputs));
  text += text_of("A", m.A) + text_of("B", m.B) + text_of("C", m.C) + text_of("D", m.D);
  text += "poles: " + text_of(poles(m)) + "\n";
  if (m.inputs.empty() || m.outputs.empty()) return text;
  text += "zeros: " + text_of(zeros(m)) + "\n";
  if (m.inputs.size() == 1 && m.outputs.size() == 1) {
    text += fmt::format("gain at rest: {:.9g}\n", gains_at_rest(m).front());
    const Margins margin = margins(m);
    if (margin.gain)
      text += fmt::format("gain margin: {:.6g} at {:.6g} rad/s\n", *margin.gain, *margin.phase_crossover);
    if (margin.phase) {
      text += fmt::format("phase margin: {:.6g} degrees at {:.6g} rad/s, a dead time of {:.6g} s\n", *margin.phase,
                          *margin.gain_crossover, *margin.delay);
    }
  }
  return text;
}

std::string json_of(const DenseMatrix& m) {
  std::string text = "[";
  for (std::size_t i = 0; i < m.rows; ++i) {
    text += i > 0 ? ", [" : "[";
    for (std::size_t j = 0; j < m.columns; ++j) text += (j > 0 ? ", " : "") + shortest(m(i, j));
    text += "]";
  }
  return text + "]";
}

std::string json_of(const std::vector<std::complex<double>>& roots) {
  std::string text = "[";
  for (std::size_t i = 0; i < roots.size(); ++i)
    text += fmt::format("{}[{}, {}]", i > 0 ? ", " : "", shortest(roots[i].real()), shortest(roots[i].imag()));
  return text + "]";
}

std::string json_of(const std::vector<std::string>& names) {
  std::string text = "[";
  for (std::size_t i = 0; i < names.size(); ++i) text += fmt::format("{}\"{}\"", i > 0 ? ", " : "", names[i]);
  return text + "]";
}

std::string to_json(const LinearModel& m) {
  return fmt::format(
      "{{\n  \"period\": {},\n  \"time\": {},\n  \"states\": {},\n  \"inputs\": {},\n  \"outputs\": {},\n  \"A\": {},\n"
      "  \"B\": {},\n  \"C\": {},\n  \"D\": {},\n  \"poles\": {},\n  \"zeros\": {}\n}}\n",
      shortest(m.period), shortest(m.time), json_of(m.states), json_of(m.inputs), json_of(m.outputs), json_of(m.A),
      json_of(m.B), json_of(m.C), json_of(m.D), json_of(poles(m)), json_of(zeros(m)));
}

struct Curves {
  std::vector<double> frequency;
  std::vector<std::vector<std::complex<double>>> values;  // at each frequency, as response() gives them
};

Curves curves(const LinearModel& m, const LinearOptions& o) {
  Curves c;
  c.frequency = frequencies_for(m, o.points);
  if (!std::isnan(o.low) || !std::isnan(o.high)) {
    const double low = std::isnan(o.low) ? c.frequency.front() : o.low;
    const double high = std::isnan(o.high) ? c.frequency.back() : o.high;
    for (std::size_t i = 0; i < o.points; ++i)
      c.frequency[i] = low * std::pow(high / low, static_cast<double>(i) / static_cast<double>(o.points - 1));
  }
  for (const double w : c.frequency) c.values.push_back(response(m, w));
  return c;
}

// The phase in degrees, without jumps from one frequency to the next.
std::vector<double> phases(const Curves& c, std::size_t pair) {
  std::vector<double> phase;
  for (const auto& values : c.values) {
    double p = std::arg(values[pair]) * 180 / std::numbers::pi;
    if (!phase.empty()) p += 360 * std::round((phase.back() - p) / 360);
    phase.push_back(p);
  }
  return phase;
}

std::string to_csv(const LinearModel& m, const Curves& c) {
  std::string text = "frequency";
  std::vector<std::vector<double>> phase;
  for (std::size_t i = 0; i < m.outputs.size(); ++i) {
    for (std::size_t j = 0; j < m.inputs.size(); ++j) {
      for (const char* what : {"magnitude", "phase", "real", "imaginary"})
        text += fmt::format(",{} of {} by {}", what, m.outputs[i], m.inputs[j]);
      phase.push_back(phases(c, i * m.inputs.size() + j));
    }
  }
  text += "\n";
  for (std::size_t k = 0; k < c.frequency.size(); ++k) {
    text += digits17(c.frequency[k]);
    for (std::size_t pair = 0; pair < phase.size(); ++pair) {
      const std::complex<double> g = c.values[k][pair];
      text += fmt::format(",{},{},{},{}", digits17(std::abs(g)), digits17(phase[pair][k]), digits17(g.real()),
                          digits17(g.imag()));
    }
    text += "\n";
  }
  return text;
}

Figure bode(const LinearModel& m, const Curves& c) {
  Figure figure;
  figure.x = {.label = "frequency [rad/s]", .scale = Scale::log};
  Panel magnitude{.y = {.label = "magnitude", .scale = Scale::log}}, phase{.y = {.label = "phase [°]"}};
  for (std::size_t i = 0; i < m.outputs.size(); ++i) {
    for (std::size_t j = 0; j < m.inputs.size(); ++j) {
      const std::size_t pair = i * m.inputs.size() + j;
      std::vector<double> size;
      for (const auto& values : c.values) size.push_back(std::abs(values[pair]));
      const std::string label = m.outputs.size() * m.inputs.size() > 1 ? m.outputs[i] + " by " + m.inputs[j] : "";
      magnitude.line(c.frequency, size, {.label = label});
      phase.line(c.frequency, phases(c, pair), {.label = label});
    }
  }
  figure.panels = {magnitude, phase};
  return figure;
}

int run(const LinearOptions& o) {
  LineariseRequest request = o.request;
  if (!read_overrides(o.set, request.set)) return input_wrong;
  if (!std::isnan(o.at)) request.at = o.at;
  Report report;
  const auto diagram = load_diagram(o.file, report);
  if (!diagram) return input_wrong;
  std::optional<LinearModel> model;
  try {
    model = linearise(diagram->model_pointer(), request, report);
  } catch (const RunError& e) {
    print(report);
    complain(e.what());
    return run_failed;
  }
  print(report);
  if (!model) return input_wrong;
  bool written = o.out.empty() ? write_out(summary(*model)) : write_result(o.out, to_json(*model));
  if (o.response.empty() && o.figure.empty()) return written ? done : run_failed;
  if (model->inputs.empty() || model->outputs.empty()) {
    complain("a frequency response needs --input and --output");
    return input_wrong;
  }
  const Curves c = curves(*model, o);
  if (!o.response.empty()) written = write_result(o.response, to_csv(*model, c)) && written;
  if (!o.figure.empty()) {
    const std::string error = write_figure(bode(*model, c), o.figure);
    if (!error.empty()) complain(error);
    written = written && error.empty();
  }
  return written ? done : run_failed;
}

}  // namespace

}  // namespace plantloop::app

PLANTLOOP_COMMAND(linearise) {
  using namespace plantloop::app;
  const auto o = std::make_shared<LinearOptions>();
  parser.description(
      "Linearise a diagram around an operating point, by exact derivatives: A, B, C, D, poles, zeros, margins, "
      "frequency response. A diagram with sampled blocks gives a sampled model.");
  parser.add_option("DIAGRAM", o->file, "the diagram")->required();
  parser.add_option("--input", o->request.inputs, "a signal to which the input is added: u, plant.u, x.2")
      ->allow_extra_args(false)
      ->type_name("PATH");
  parser.add_option("--output", o->request.outputs, "a signal to look at")->allow_extra_args(false)->type_name("PATH");
  parser
      .add_option("--open", o->request.open,
                  "a signal whose driver counts as constant: cuts a loop there, at the closed loop's operating point")
      ->allow_extra_args(false)
      ->type_name("PATH");
  add_set_option(parser, o->set);
  parser.add_option("--at", o->at, "run to this time, in s, and linearise there; without it at the initial values");
  parser.add_flag("--trim", o->request.trim, "first look for a rest near there");
  parser.add_flag("--hold", o->request.hold, "keep sampled values as they are: the continuous part alone");
  parser.add_option("--out", o->out, "write the model as JSON")->type_name("FILE");
  parser.add_option("--response", o->response, "write the frequency response as CSV")->type_name("FILE");
  parser.add_option("--figure", o->figure, "draw the frequency response (Bode), .png or .svg")->type_name("FILE");
  parser.add_option("--from", o->low, "lowest frequency in rad/s")->check(CLI::PositiveNumber);
  parser.add_option("--to", o->high, "highest frequency in rad/s")->check(CLI::PositiveNumber);
  parser.add_option("--points", o->points, "frequencies of the response")
      ->check(CLI::Range(2, 1000000))
      ->capture_default_str();
  parser.footer(
      "Examples:\n"
      "  plantloop linearise loop.yaml --input r --output y\n"
      "  plantloop linearise loop.yaml --input x.u --output u --open x.u --figure out/bode.png");
  return [o] { return run(*o); };
}
