// The pendulum as somebody writes it who needs it once and fast.

#include <cmath>
#include <vector>

#include "bench/workloads.h"

namespace plantloop::bench {

Measured run_handwritten(const Pendulum& pendulum) {
  const double Q = pendulum.Q;
  const double b = pendulum.b;
  const double h = pendulum.step;
  double theta = 0;
  double omega = 0;
  std::vector<double> thetas{theta};
  std::vector<double> omegas{omega};
  std::size_t segment = 0;

  const Stopwatch watch;
  for (long i = 0; i < pendulum.steps; ++i) {
    const double t = static_cast<double>(i) * h;
    while (segment + 1 < pendulum.times.size() && t >= pendulum.times[segment + 1] - 1e-9) ++segment;
    const double force = b * pendulum.forces[segment];
    const auto acceleration = [=](double at, double speed) { return force - Q * speed - Q * std::sin(at); };

    const double k1 = acceleration(theta, omega);
    const double omega2 = omega + 0.5 * h * k1;
    const double k2 = acceleration(theta + 0.5 * h * omega, omega2);
    const double omega3 = omega + 0.5 * h * k2;
    const double k3 = acceleration(theta + 0.5 * h * omega2, omega3);
    const double omega4 = omega + h * k3;
    const double k4 = acceleration(theta + h * omega3, omega4);
    theta += h / 6 * (omega + 2 * omega2 + 2 * omega3 + omega4);
    omega += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);

    thetas.push_back(theta);
    omegas.push_back(omega);
  }
  return {.seconds = watch.seconds(), .value = omegas.back() + 0 * thetas.back()};
}

}  // namespace plantloop::bench
