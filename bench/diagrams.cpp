// Writes the benchmarks as diagram files.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <random>
#include <utility>

#include "bench/workloads.h"

namespace plantloop::bench {
namespace {

std::string simulation(double step, long steps, std::string_view record) {
  return fmt::format("simulation: {{stop: {}, solver: rk4, step: {}}}\nrecord: [{}]\n",
                     static_cast<double>(steps) * step, step, record);
}

// Fisher and Yates with a fixed generator: the same order with every C++ library.
void shuffle(std::vector<std::string>& lines) {
  std::mt19937_64 random(20);
  for (std::size_t i = lines.size(); i > 1; --i) std::swap(lines[i - 1], lines[random() % i]);
}

}  // namespace

std::string to_yaml(const Pendulum& pendulum) {
  return fmt::format(
             "# Benchmark: the damped pendulum of elementary blocks.\n"
             "plantloop: 1\n"
             "parameters:\n"
             "  Q: {}\n"
             "  b: {}\n"
             "blocks:\n"
             "  force: {{type: staircase, times: [{}], values: [{}]}}\n"
             "  push: {{type: gain, in: force, k: b}}\n"
             "  damping: {{type: gain, in: omega, k: Q}}\n"
             "  sine: {{type: math_function, function: sin, in: theta}}\n"
             "  weight: {{type: gain, in: sine, k: Q}}\n"
             "  acceleration: {{type: sum, in: [push, damping, weight], signs: \"+--\"}}\n"
             "  omega: {{type: integrator, in: acceleration}}\n"
             "  theta: {{type: integrator, in: omega}}\n",
             pendulum.Q, pendulum.b, fmt::join(pendulum.times, ", "), fmt::join(pendulum.forces, ", ")) +
         simulation(pendulum.step, pendulum.steps, "theta, omega");
}

std::string to_yaml(const Chain& chain, Order order) {
  const std::size_t n = chain.gains.size();
  std::vector<std::string> blocks{"  source: {type: constant, value: 1}\n"};
  for (std::size_t i = 1; i <= n; ++i) {
    const std::string before = i == 1 ? "source" : fmt::format("x{}", i - 1);
    blocks.push_back(fmt::format("  difference{0}: {{type: sum, in: [{1}, x{0}], signs: \"+-\"}}\n", i, before));
    blocks.push_back(fmt::format("  gain{0}: {{type: gain, in: difference{0}, k: {1}}}\n", i, chain.gains[i - 1]));
    blocks.push_back(fmt::format("  x{0}: {{type: integrator, in: gain{0}}}\n", i));
  }
  if (order == Order::random) shuffle(blocks);
  return fmt::format("# Benchmark: a chain of {} first-order lags of elementary blocks.\nplantloop: 1\nblocks:\n{}", n,
                     fmt::join(blocks, "")) +
         simulation(chain.step, chain.steps, fmt::format("x{}", n));
}

}  // namespace plantloop::bench
