// Radial functions and their slopes.

#include "identify/rbf/radial.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "identify/error.h"

namespace plantloop::identify {
namespace {

constexpr std::array<const char*, 7> names{"gaussian",  "gaussian_list", "logistic",    "linear",
                                           "quadratic", "thin_plate",    "multiquadric"};

}  // namespace

std::vector<std::string> radial_names() { return {names.begin(), names.end()}; }

Radial find_radial(std::string_view name) {
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (name == names[i]) return static_cast<Radial>(i);
  }
  fail("there is no radial function '{}'; there are {}", name, fmt::join(names, ", "));
}

std::string name_of(Radial radial) { return names[static_cast<std::size_t>(radial)]; }

bool is_bounded(Radial radial) {
  return radial == Radial::gaussian || radial == Radial::gaussian_list || radial == Radial::logistic;
}

double radial_value(Radial radial, double s) {
  switch (radial) {
    case Radial::gaussian:
      return std::exp(-s / 2);
    case Radial::gaussian_list:
      return std::exp(-s);
    case Radial::logistic:
      return 1 / (1 + std::exp(s));
    case Radial::linear:
      return std::sqrt(s);
    case Radial::quadratic:
      return s;
    case Radial::thin_plate:
      return s > 0 ? 0.5 * s * std::log(s) : s;  // a NaN stays one
    case Radial::multiquadric:
      return std::sqrt(s + 1);
  }
  return s;
}

double radial_slope(Radial radial, double s, double value) {
  switch (radial) {
    case Radial::gaussian:
      return -0.5 * value;
    case Radial::gaussian_list:
      return -value;
    case Radial::logistic:
      return -value * (1 - value);
    case Radial::linear:
      return s > 0 ? 0.5 / value : 0;
    case Radial::quadratic:
      return 1;
    case Radial::thin_plate:
      return s > 0 ? 0.5 * (std::log(s) + 1) : 0;
    case Radial::multiquadric:
      return 0.5 / value;
  }
  return 0;
}

}  // namespace plantloop::identify
