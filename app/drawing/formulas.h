// Expressions and names as they look in a paper.

#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "engine/diagram/expression.h"
#include "render/diagram/formula.h"

namespace plantloop {

// "theta0" -> "θ_0", "K1" -> "K_1", "kp" -> "k_p", "set_point" -> "set point".
std::string pretty_name(std::string_view name);
// Whether the name looks like a symbol of a formula rather than a word: one letter or Greek name, with an index or not.
bool is_symbol(std::string_view name);
// "0.05", "1.2·10^{-6}", "∞".
std::string pretty_number(double value);

// What stands for a name in a formula; nothing: the name itself.
using Substitute = std::function<std::optional<Formula>(const Expression& name, bool is_factor)>;

// `is_factor`: a sum gets brackets.
Formula formula_of(const Expression& expression, const Substitute& substitute = {}, bool is_factor = false);

// A polynomial in `variable`, the coefficients in descending powers.
Formula polynomial(const std::vector<Formula>& coefficients, const std::vector<std::optional<double>>& numbers,
                   const std::string& variable);

}  // namespace plantloop
