// Explicit Runge-Kutta methods as data: to add one, write its Tableau in tableau.cpp.

#pragma once

#include <algorithm>
#include <cstddef>
#include <string_view>
#include <vector>

namespace plantloop {

// k_1 = f(t, x),  k_i = f(t + c_i h, x + h sum_j a_ij k_j),  x(t + h) = x + h sum_i b_i k_i.
struct Tableau {
  std::string_view name;
  std::string_view summary;
  int order = 0;
  std::vector<double> c;               // of stages 2, 3, ...; each the sum of its row
  std::vector<std::vector<double>> a;  // the rows of stages 2, 3, ...
  std::vector<double> b;
  // Embedded methods only: b minus the weights of the embedded method. One entry more than b: the last stage is
  // f(t + h, x(t + h)), which the next step needs anyway (first same as last).
  std::vector<double> error;
  int error_order = 0;  // order of the embedded method
  // Dense output: cubic Hermite, plus theta^2 (1 - theta)^2 h sum_i bubble_i k_i where given (the last entry is for
  // f(t + h, x(t + h))).
  std::vector<double> bubble;

  std::size_t stages() const { return b.size(); }
  bool adaptive() const { return !error.empty(); }
  // The error of interpolated values falls with this power of h.
  int dense_order() const { return std::min(order, bubble.empty() ? 4 : 5); }
  // Each stage needs the derivative of the one before only: one pass over the state per stage is enough.
  bool low_storage() const;
};

// All explicit methods, in order of listing.
const std::vector<Tableau>& tableaus();
// The method of that name, or null.
const Tableau* find_tableau(std::string_view name);

}  // namespace plantloop
