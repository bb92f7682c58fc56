// What a neuron does with the sum of its inputs.

#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace plantloop::identify {

enum class Activation { sigmoid, tanh, linear, gaussian, signum };

// By their names in options and model files. find_activation raises IdentifyError.
Activation find_activation(std::string_view name);
std::string name_of(Activation activation);
std::vector<std::string> activation_names();

// sigmoid 1/(1 + exp(-s)), tanh, s, gaussian exp(-s^2), signum (0 at 0).
double activate(Activation activation, double s);
// The derivative at s, where h = activate(s). Of signum: 0.
double slope(Activation activation, double s, double h);

}  // namespace plantloop::identify
