// The explicit methods. Sources: Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I (II.1, II.5, II.6);
// Bogacki, Shampine, A 3(2) pair of Runge-Kutta formulas, Appl. Math. Lett. 2 (1989).

#include "engine/solve/tableau.h"

#include <algorithm>

namespace plantloop {
namespace {

const Tableau euler{
    .name = "euler",
    .summary = "explicit Euler, order 1",
    .order = 1,
    .b = {1},
};

const Tableau heun{
    .name = "heun",
    .summary = "Heun's trapezoid, order 2",
    .order = 2,
    .c = {1},
    .a = {{1}},
    .b = {0.5, 0.5},
};

const Tableau rk4{
    .name = "rk4",
    .summary = "the classical Runge-Kutta method, order 4",
    .order = 4,
    .c = {0.5, 0.5, 1},
    .a = {{0.5}, {0, 0.5}, {0, 0, 1}},
    .b = {1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6},
};

const Tableau bogacki_shampine{
    .name = "bogacki_shampine",
    .summary = "Bogacki and Shampine, order 3 with error control of order 2; for loose tolerances",
    .order = 3,
    .c = {1.0 / 2, 3.0 / 4},
    .a = {{1.0 / 2}, {0, 3.0 / 4}},
    .b = {2.0 / 9, 1.0 / 3, 4.0 / 9},
    .error = {2.0 / 9 - 7.0 / 24, 1.0 / 3 - 1.0 / 4, 4.0 / 9 - 1.0 / 3, -1.0 / 8},
    .error_order = 2,
};

const Tableau dopri5{
    .name = "dopri5",
    .summary = "Dormand and Prince, order 5 with error control of order 4; the default",
    .order = 5,
    .c = {1.0 / 5, 3.0 / 10, 4.0 / 5, 8.0 / 9, 1},
    .a = {{1.0 / 5},
          {3.0 / 40, 9.0 / 40},
          {44.0 / 45, -56.0 / 15, 32.0 / 9},
          {19372.0 / 6561, -25360.0 / 2187, 64448.0 / 6561, -212.0 / 729},
          {9017.0 / 3168, -355.0 / 33, 46732.0 / 5247, 49.0 / 176, -5103.0 / 18656}},
    .b = {35.0 / 384, 0, 500.0 / 1113, 125.0 / 192, -2187.0 / 6784, 11.0 / 84},
    .error = {71.0 / 57600, 0, -71.0 / 16695, 71.0 / 1920, -17253.0 / 339200, 22.0 / 525, -1.0 / 40},
    .error_order = 4,
    .bubble = {-12715105075.0 / 11282082432, 0, 87487479700.0 / 32700410799, -10690763975.0 / 1880347072,
               701980252875.0 / 199316789632, -1453857185.0 / 822651844, 69997945.0 / 29380423},
};

}  // namespace

bool Tableau::low_storage() const {
  return std::all_of(a.begin(), a.end(), [](const std::vector<double>& row) {
    return std::all_of(row.begin(), row.end() - 1, [](double entry) { return entry == 0; });
  });
}

const std::vector<Tableau>& tableaus() {
  static const std::vector<Tableau> all{euler, heun, rk4, bogacki_shampine, dopri5};
  return all;
}

const Tableau* find_tableau(std::string_view name) {
  for (const Tableau& tableau : tableaus()) {
    if (tableau.name == name) return &tableau;
  }
  return nullptr;
}

}  // namespace plantloop
