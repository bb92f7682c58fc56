// No allocation while stepping: what a run allocates does not grow with its steps but by doubling of its recording.

#include <gtest/gtest.h>

#include "engine/run/diagram.h"
#include "tests/allocations/counting.h"

namespace plantloop {
namespace {

long allocations_of(const std::string& blocks, const std::string& stop, const std::string& solver) {
  Report report;
  const auto diagram = Diagram::from_text(
      "plantloop: 1\nblocks:\n" + blocks + "simulation: {stop: " + stop + ", " + solver + "}\n", "test.yaml", report);
  if (!diagram || !diagram->run({}, report)) ADD_FAILURE() << to_text(report);
  const long before = testing::allocations();
  (void)diagram->run({}, report);  // compiled already
  return testing::allocations() - before;
}

const std::string smooth = "  x: {type: integrator, in: v, initial: 1}\n  v: {type: integrator, in: -sin(x)}\n";
const std::string sampled = smooth +
                            "  z: {type: zero_order_hold, in: x, rate: 0.05}\n"
                            "  d: {type: unit_delay, in: z, rate: 0.1}\n"
                            "  c: {type: integrator, in: saturated}\n"
                            "  saturated: {type: saturation, in: 3*d, lower: -9, upper: 9}\n";

TEST(Stepping, DoesNotAllocate) {
  for (const char* solver : {"solver: rk4, step: 0.01", "solver: heun, step: 0.01", "rtol: 1e-6"}) {
    const long once = allocations_of(smooth, "100", solver), twice = allocations_of(smooth, "200", solver);
    EXPECT_LE(twice - once, 8) << solver;
  }
}

TEST(Stepping, OverHitsAndEdgesDoesNotAllocate) {
  const std::string blocks = sampled + "  u: {type: square, period: 0.3}\n  y: {type: first_order, in: u}\n";
  for (const char* solver : {"solver: rk4, step: 0.01", "rtol: 1e-6"}) {
    const long once = allocations_of(blocks, "100", solver), twice = allocations_of(blocks, "200", solver);
    // 2000 more hits: the lists of rows at hits, the recording's three arrays, and the run's statistics double.
    EXPECT_LE(twice - once, 12) << solver;
  }
}

}  // namespace
}  // namespace plantloop
