// One diagram run with many settings: what is compiled again, and what is not.

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "tests/blocks/diagrams.h"

namespace plantloop::testing_diagrams {
namespace {

class Runs {
 public:
  explicit Runs(const std::string& text) : diagram_(Diagram::from_text("plantloop: 1\n" + text, "test.yaml", report_)) {
    if (!diagram_) throw std::runtime_error(to_text(report_));
  }
  Signals operator()(const RunRequest& request) {
    auto run = diagram_->run(request, report_);
    if (!run) throw std::runtime_error(to_text(report_));
    return Signals(std::move(*run));
  }
  Signals set(const std::string& path, const std::string& value) {
    RunRequest request;
    request.set.push_back({path, value});
    return (*this)(request);
  }

 private:
  Report report_;
  std::shared_ptr<Diagram> diagram_;
};

std::string lag() {
  return R"(
parameters: {k: 2, tau: 0.5, T: 1, n: 3}
blocks:
  x: {type: first_order, in: 1, k: k, tau: tau, initial: k/4}
  v: {type: integrator, in: k*ones(n)}
  z: {type: discrete_integrator, in: 1, rate: T/10}
simulation: {stop: 2*T, rtol: 1e-9, atol: 1e-11}
record: [x, v, z]
)";
}

double lag_at(double k, double tau, double t) { return k + (k / 4 - k) * std::exp(-t / tau); }

TEST(Settings, OfATunableNumberReachEverythingThatFollowsFromIt) {
  Runs runs(lag());
  EXPECT_NEAR(runs({}).last("x"), lag_at(2, 0.5, 2), 1e-7);
  for (const double k : {1.0, 5.0, -3.0, 0.0}) {
    const Signals r = runs.set("k", std::to_string(k));
    EXPECT_NEAR(r.last("x"), lag_at(k, 0.5, 2), 1e-7);
    EXPECT_EQ(r.column("x").front(), k / 4);
  }
  EXPECT_NEAR(runs.set("tau", "0.1").last("x"), lag_at(2, 0.1, 2), 1e-7);
  EXPECT_NEAR(runs({}).last("x"), lag_at(2, 0.5, 2), 1e-7) << "a setting holds for its run only";
}

TEST(Settings, OfATunableNumberDoNotCompileAgain) {
  Runs runs(lag());
  const double first = runs.set("k", "3").whole().timing.compile;
  double least = 1;
  for (int i = 0; i < 20; ++i) least = std::min(least, runs.set("k", std::to_string(i)).whole().timing.compile);
  EXPECT_LT(least, first / 3);
}

TEST(Settings, ThatShapeTheStructureCompileAgainAsOftenAsNeeded) {
  Runs runs(lag());
  for (const int n : {2, 4, 2, 7}) {
    const Signals r = runs.set("n", std::to_string(n));
    EXPECT_EQ(r.recording().find("v." + std::to_string(n + 1)), -1);
    EXPECT_NEAR(r.last("v." + std::to_string(n)), 4, 1e-9);
  }
}

TEST(Settings, OfWhatTheSimulationSectionReadsChangeIt) {
  Runs runs(lag());
  for (const double t : {1.0, 2.0, 0.5, 1.0}) {
    const Signals r = runs.set("T", std::to_string(t));
    EXPECT_EQ(r.recording().time().back(), 2 * t);
    EXPECT_EQ(r.samples("z").size(), 21u);
  }
}

TEST(Settings, OfABlockAreTheNearestToTheRun) {
  Runs runs(lag());
  EXPECT_NEAR(runs.set("x.k", "8").last("x"), 8 + (0.5 - 8) * std::exp(-4.0), 1e-7);
  EXPECT_EQ(runs.set("x.initial", "7").column("x").front(), 7);
  EXPECT_NEAR(runs.set("x.k", "4*k").last("x"), 8 + (0.5 - 8) * std::exp(-4.0), 1e-7);
}

TEST(Settings, OfARunComeBeforeThoseOfTheFile) {
  Runs runs(lag());
  const Signals fixed = runs({.step = 0.001, .solver = "rk4"});
  EXPECT_NEAR(fixed.last("x"), lag_at(2, 0.5, 2), 1e-9);
  EXPECT_EQ(fixed.whole().options.solver, "rk4");
  EXPECT_EQ(runs({.stop = 1}).recording().time().back(), 1);
  EXPECT_EQ(runs({.output_interval = 0.5}).recording().rows(), 5u);
  const Signals euler = runs({.step = 0.001, .solver = "euler"});
  EXPECT_GT(std::fabs(euler.last("x") - lag_at(2, 0.5, 2)), 1e-6);
  EXPECT_NEAR(runs({.step = 0.002, .solver = "rk4"}).last("x"), fixed.last("x"), 1e-9);
}

TEST(Settings, AreRunFromAFreshStateEachTime) {
  Runs runs(R"(
blocks:
  u: {type: square, period: 0.3}
  x: {type: integrator, in: u, reset: {when: y > 0.5, to: 0}}
  y: {type: transport_delay, in: x + time, delay: 0.2}
  r: {type: random_levels, rate: 0.1}
  d: {type: unit_delay, in: r, rate: 0.1}
simulation: {stop: 1}
)");
  const std::string first = to_csv(runs({}).recording());
  runs({.stop = 0.5});
  EXPECT_EQ(to_csv(runs({}).recording()), first);
}

}  // namespace
}  // namespace plantloop::testing_diagrams
