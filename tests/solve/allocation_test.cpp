// A step of an explicit method allocates nothing.

#include <gtest/gtest.h>

#include "engine/solve/tableau.h"
#include "tests/allocations/counting.h"
#include "tests/solve/systems.h"

namespace plantloop {
namespace {

TEST(ExplicitMethods, AllocateNothingWhileStepping) {
  for (const Tableau& method : tableaus()) {
    for (const double step : {0.0, 0.01}) {
      if (step == 0 && !method.adaptive()) continue;
      for (const int n : {3, 40}) {
        testing::Chain chain(n);
        const auto integrator =
            make_integrator(chain, {.solver = std::string(method.name), .stop = 1000, .step = step});
        std::vector<double> x(static_cast<std::size_t>(n));
        const long before = testing::allocations();
        for (int k = 0; k < 50; ++k) {
          const double t = integrator->step(1000);
          integrator->interpolate(t - 1e-3, x.data());
          if (k == 20) integrator->restart(t);
        }
        EXPECT_EQ(testing::allocations() - before, 0) << method.name;
      }
    }
  }
}

}  // namespace
}  // namespace plantloop
