// The PI controller in velocity form, figures 6.4 to 6.6 of the book, and why nothing differentiates a signal.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "tests/book/book_runs.h"

namespace plantloop::testing_book {
namespace {

using testing::HasSubstr;

TEST(PiInVelocityForm, AnswersAStepAsComputedElsewhere) {
  const BookRun run = run_file("diagrams/book/pi_velocity.yaml", {.output_interval = 0.01});
  for (const char* u : {"u", "controller.u"}) {
    EXPECT_NEAR(run.at(u, 0.01), 7.155660, 1e-5) << u;  // printed digits
    EXPECT_NEAR(run.at(u, 0.1), 15.949526, 1e-5) << u;
    EXPECT_NEAR(run.at(u, 1), 65.45, 1e-5) << u;
  }
}

// With constant gains it is (K0 + K1/s)/(s/p + 1); the book's (6.1) is this with p = 50 and both gains divided by 50.
TEST(PiInVelocityForm, HasItsTransferFunctionForOtherNumbers) {
  const double numbers[][3] = {{11.0 / 50, 55.0 / 50, 50}, {-3, 0.5, 7}, {0, 20, 400}, {4, 0, 12}};
  for (const auto& [K0, K1, p] : numbers) {
    const RunRequest request{
        .set = {{"K0", fmt::format("{}", K0)}, {"K1", fmt::format("{}", K1)}, {"p", fmt::format("{}", p)}},
        .output_interval = 0.05};
    const BookRun run = run_file("diagrams/book/pi_velocity.yaml", request);
    for (int i = 1; i <= 20; ++i) {
      const double t = 0.05 * i;
      const double lag = 1 - std::exp(-p * t);
      const double exact = K0 * lag + K1 * (t - lag / p);
      EXPECT_NEAR(run.at("u", t), exact, 1e-7) << t;  // rtol 1e-9 of values up to some ten
      EXPECT_NEAR(run.at("controller.u", t), exact, 1e-7) << t;
    }
  }
}

TEST(PiInVelocityForm, IsWhatAFasterAndFasterDerivativeLeadsTo) {
  // Off by K0 p/(N - p) (r^(N/(N-p)) - r^(p/(N-p))) with r = p/N at worst: about K0 p/N.
  const auto off = [](double N) {
    const RunRequest request{.set = {{"N", fmt::format("{}", N)}}, .max_step = 1e-4};
    return run_file("diagrams/book/pi_derivative.yaml", request).measure("error", "max_abs");
  };
  for (const double N : {200.0, 1000.0, 5000.0}) {
    const double r = 100 / N;
    const double exact = 11 * r / (1 - r) * (std::pow(r, r / (1 - r)) - std::pow(r, 1 / (1 - r)));
    EXPECT_NEAR(off(N), exact, 1e-3 * exact) << N;  // rows are 1e-4 s apart
  }
}

TEST(PiInVelocityForm, AgreesWithGainsBehindTheIntegratorWhileTheyAreConstant) {
  const BookRun run = run_file("diagrams/book/pi_scheduled.yaml", {.set = {{"change", "0"}}});
  EXPECT_LT(run.measure("difference", "max_abs"), 1e-7);  // solver accuracy: rtol 1e-9 of 40
}

TEST(PiInVelocityForm, DoesNotMoveTheControlSignalWhenGainsChangeWithoutAnError) {
  // The error's integral is 0.5 from 0.5 s on, the gains fall to (1 - change) from 1 s to 2 s.
  for (const double change : {0.5, 0.2, -1.0}) {
    const RunRequest request{.set = {{"change", fmt::format("{}", change)}}, .output_interval = 0.01};
    const BookRun run = run_file("diagrams/book/pi_scheduled.yaml", request);
    EXPECT_NEAR(run.at("velocity.u", 1), 27.5, 1e-6);
    EXPECT_NEAR(run.at("velocity.u", 2.4), 27.5, 1e-6);
    EXPECT_NEAR(run.at("usual", 2.4), 27.5 * (1 - change), 1e-6);
    EXPECT_NEAR(run.measure("difference", "max_abs"), std::fabs(27.5 * change), 1e-6);
  }
}

// What a newcomer may write for the derivative of a signal.
class PureDerivative : public testing::TestWithParam<const char*> {};

TEST_P(PureDerivative, IsRefusedWithWhatToWriteInstead) {
  const std::string text = findings(
      fmt::format("plantloop: 1\nblocks:\n  e: {{type: sine}}\n  x: {}\nsimulation: {{stop: 1}}\n", GetParam()));
  EXPECT_THAT(text, HasSubstr("test.yaml:4:"));
  EXPECT_THAT(text, HasSubstr("there is no pure derivative"));
  EXPECT_THAT(text, HasSubstr("filtered_derivative"));
  EXPECT_THAT(text, HasSubstr("velocity_pi"));
  EXPECT_THAT(text, HasSubstr("the derivative of a state is the integrator's input"));
}

INSTANTIATE_TEST_SUITE_P(Some, PureDerivative,
                         testing::Values("der(e)", "2*derivative(e) + 1", "diff(e)", "ddt(e)",
                                         "{type: derivative, in: e}", "{type: differentiator, in: e}",
                                         "{type: der, in: e}", "{type: diff, in: e}", "{type: du/dt, in: e}",
                                         "{type: derivate, in: e}"));

TEST(PureDerivatives, AreNoTransferFunctionsEither) {
  const std::string text = findings(R"(plantloop: 1
blocks:
  e: {type: sine}
  x: {type: transfer_function, in: e, num: [1, 0], den: [1]}
simulation: {stop: 1}
)");
  EXPECT_THAT(text, HasSubstr("test.yaml:4:"));
  EXPECT_THAT(text, HasSubstr("would need derivatives of its input"));
}

}  // namespace
}  // namespace plantloop::testing_book
