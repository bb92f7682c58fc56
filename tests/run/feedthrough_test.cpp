// S4: which input reaches which output at the same instant is read off the equations, element by element.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/blocks/diagrams.h"

namespace plantloop::testing_diagrams {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

// Whether feeding the block's output back to its input closes a path at the same instant.
bool closes_a_loop(const std::string& block) {
  return findings("blocks:\n  it: " + block + "\nsimulation: {stop: 1}\n").find("algebraic loop") != std::string::npos;
}

TEST(S4Feedthrough, OfAStateSpaceIsWhereItsDIsNotZero) {
  const std::string system = "{type: state_space, A: -1, B: 1, C: 1, in: 1 - 0.5*it, D: ";
  EXPECT_FALSE(closes_a_loop(system + "0}"));
  EXPECT_TRUE(closes_a_loop(system + "0.1}"));
}

TEST(S4Feedthrough, OfAMatrixIsTakenElementByElement) {
  // Each channel reads the other one's output: crossed channels close no path, straight ones do.
  const std::string two = R"(
blocks:
  both: {type: matrix_gain, K: MATRIX, in: [1 - x.1, both.1]}
  x: {type: integrator, in: both}
simulation: {stop: 1}
record: [both]
)";
  const auto with = [&](const std::string& matrix) {
    std::string text = two;
    return findings(text.replace(text.find("MATRIX"), 6, matrix));
  };
  EXPECT_THAT(with("\"[[1, 0], [0, 1]]\""), IsEmpty());
  EXPECT_THAT(with("\"[[1, 0.5], [0, 1]]\""), HasSubstr("algebraic loop"));
}

TEST(S4Feedthrough, OfADelayIsThereWhereItCanBeNothing) {
  EXPECT_FALSE(closes_a_loop("{type: transport_delay, in: 1 - 0.5*it, delay: 0.1, initial: 0}"));
  EXPECT_TRUE(closes_a_loop("{type: transport_delay, in: 1 - 0.5*it, delay: 0, initial: 0}"));
  EXPECT_TRUE(
      closes_a_loop("{type: transport_delay, in: 1 - 0.5*it, delay: 0.1, initial: 0, short_delay: feedthrough}"));
  EXPECT_TRUE(closes_a_loop("{type: variable_delay, in: {u: 1 - 0.5*it, delay: 0.1}, initial: 0}"));
  EXPECT_FALSE(closes_a_loop("{type: variable_delay, in: {u: 1 - 0.5*it, delay: 0.1}, initial: 0, shortest: 0.01}"));
}

TEST(S4Feedthrough, EndsAtStatesAndSamples) {
  EXPECT_FALSE(closes_a_loop("{type: integrator, in: 1 - it}"));
  EXPECT_FALSE(closes_a_loop("{type: first_order, in: 1 - it, tau: 2}"));
  EXPECT_FALSE(closes_a_loop("{type: unit_delay, in: 1 - it, rate: 0.1}"));
  EXPECT_TRUE(closes_a_loop("{type: gain, k: 0.5, in: 1 - it}"));
}

}  // namespace
}  // namespace plantloop::testing_diagrams
