// Controllers behind converters, with other levels and steps than the diagrams', and the instants of readings.

#include <gtest/gtest.h>

#include <cmath>

#include "tests/book/book_runs.h"

namespace plantloop::testing_book {
namespace {

// The same loop by Runge and Kutta's method in 25 ms steps and integers for the converters, written independently in
// another language: level 1.3 m, from 0.45 to 0.51 bar.
TEST(SeparatorHil, AgreesWithAnIndependentLoopAtAnotherLevel) {
  const BookRun run =
      run_file("diagrams/book/separator_hil.yaml", {.set = {{"h0", "1.3"}, {"p0", "0.45"}, {"D", "0.06"}}});
  const double code = 1.5 / 4095;  // bar; the reference is far closer than the two codes that are asked for
  for (const auto& [time, pressure] : {std::pair{60.0, 0.47917639172878124},
                                       {70.0, 0.49921661445652404},
                                       {100.0, 0.5101482650367681},
                                       {200.0, 0.5105199611321529},
                                       {260.0, 0.47609653724362766},
                                       {400.0, 0.44941017594595095}}) {
    EXPECT_NEAR(run.at("plant.p", time), pressure, 1e-3 * code) << time;
  }
}

TEST(ProgrammableController, ReadsAndWritesWithinItsJitter) {
  const BookRun run = run_text(R"(plantloop: 1
import: [diagrams/parts/programmable_controller.yaml]
blocks:
  k: {type: sample_counter, rate: 1}
  read: {type: analogue_input, in: 0.01*time, Ts: 1, bits: 32, conversion: 0.1, jitter: 0.3}
  other: {type: analogue_input, in: 0.01*time, Ts: 1, bits: 32, conversion: 0.1, jitter: 0.3}
  given: {type: analogue_output, in: 0.01*k, Ts: 1, bits: 32, latency: 0.2, jitter: 0.4}
simulation: {stop: 50}
record: [read, other, given, given.wait]
)");
  double least = 1, most = 0, apart = 0;
  for (int k = 1; k < 50; ++k) {
    const double age = k - 100 * run.at("read", k + 0.01);
    least = std::fmin(least, age), most = std::fmax(most, age);
    apart = std::fmax(apart, std::fabs(run.at("read", k + 0.01) - run.at("other", k + 0.01)));
    const double wait = run.at("given.wait", k + 0.01);
    EXPECT_NEAR(run.at("given", k + wait - 1e-6), 0.01 * (k - 1), 1e-8) << k;
    EXPECT_NEAR(run.at("given", k + wait + 1e-6), 0.01 * k, 1e-8) << k;
    EXPECT_GE(wait, 0.2);
    EXPECT_LE(wait, 0.6);
  }
  EXPECT_GE(least, 0.1 - 1e-6);
  EXPECT_LT(least, 0.15);
  EXPECT_LE(most, 0.4 + 1e-6);
  EXPECT_GT(most, 0.35);
  EXPECT_GT(apart, 1e-3);  // each input has instants of its own
}

}  // namespace
}  // namespace plantloop::testing_book
