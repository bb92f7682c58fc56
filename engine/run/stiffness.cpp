// Power iteration; the growth is averaged over steps, as that of a complex pair swings about its absolute value.

#include "engine/run/stiffness.h"

#include <cmath>
#include <vector>

#include "engine/program/execute.h"

namespace plantloop {

double fastest_eigenvalue(const Frame& given, double rtol, double atol) {
  constexpr int iterations = 40;
  constexpr int averaged = 20;
  Frame frame = given;
  const std::size_t n = frame.state_count();
  KernelFrame kernels = frame.kernel_frame(true);
  const auto derivatives = [&] {
    execute(frame.program->derivative_list, frame.arena, &kernels);
    const double* const first = frame.arena + frame.program->derivative_list.roots.front();
    return std::vector<double>(first, first + n);
  };
  const std::vector<double> x(frame.states(), frame.states() + n);
  const std::vector<double> at_x = derivatives();
  std::vector<double> size(n), v(n);
  for (std::size_t i = 0; i < n; ++i) size[i] = atol + rtol * std::fabs(x[i]);
  for (std::size_t i = 0; i < n; ++i) v[i] = 1 + 0.1 * static_cast<double>(i % 7);
  double sum_of_logs = 0;
  for (int k = -1; k < iterations; ++k) {
    double square = 0;
    for (const double component : v) square += component * component;
    const double length = std::sqrt(square / static_cast<double>(n));
    if (!(length > 0) || !std::isfinite(length)) return 0;
    if (k >= iterations - averaged) sum_of_logs += std::log(length);
    for (std::size_t i = 0; i < n; ++i) frame.states()[i] = x[i] + size[i] * v[i] / length;
    const std::vector<double> beside = derivatives();
    for (std::size_t i = 0; i < n; ++i) v[i] = (beside[i] - at_x[i]) / size[i];
  }
  return std::exp(sum_of_logs / averaged);
}

}  // namespace plantloop
