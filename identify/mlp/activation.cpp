// Activation functions and their slopes.

#include "identify/mlp/activation.h"

#include <array>
#include <cmath>
#include <utility>

#include "identify/error.h"

namespace plantloop::identify {
namespace {

constexpr std::array<std::pair<std::string_view, Activation>, 5> table{{{"sigmoid", Activation::sigmoid},
                                                                        {"tanh", Activation::tanh},
                                                                        {"linear", Activation::linear},
                                                                        {"gaussian", Activation::gaussian},
                                                                        {"signum", Activation::signum}}};

}  // namespace

std::vector<std::string> activation_names() {
  std::vector<std::string> names;
  for (const auto& entry : table) names.emplace_back(entry.first);
  return names;
}

Activation find_activation(std::string_view name) {
  for (const auto& entry : table) {
    if (entry.first == name) return entry.second;
  }
  fail("there is no activation '{}'; there are {}", name, fmt::join(activation_names(), ", "));
}

std::string name_of(Activation activation) {
  for (const auto& entry : table) {
    if (entry.second == activation) return std::string(entry.first);
  }
  return {};
}

double activate(Activation activation, double s) {
  switch (activation) {
    case Activation::sigmoid:
      return 1 / (1 + std::exp(-s));
    case Activation::tanh:
      return std::tanh(s);
    case Activation::linear:
      return s;
    case Activation::gaussian:
      return std::exp(-s * s);
    case Activation::signum:
      return s > 0 ? 1 : s < 0 ? -1 : s;  // a NaN stays one
  }
  return s;
}

double slope(Activation activation, double s, double h) {
  switch (activation) {
    case Activation::sigmoid:
      return h * (1 - h);
    case Activation::tanh:
      return 1 - h * h;
    case Activation::linear:
      return 1;
    case Activation::gaussian:
      return -2 * s * h;
    case Activation::signum:
      return 0;
  }
  return 1;
}

}  // namespace plantloop::identify
