// S14, for every block: a run that goes on from a checkpoint gives the bytes of the run that was never stopped.

#include <gtest/gtest.h>

#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "engine/run/checkpoint.h"
#include "engine/run/diagram.h"
#include "tests/family/samples.h"

namespace plantloop::family {
namespace {

struct Rows {
  std::vector<double> time;
  std::vector<std::vector<double>> values;
};

// The rows after a time.
Rows after(const Recording& recording, double time) {
  Rows rows;
  for (std::size_t row = 0; row < recording.rows(); ++row) {
    if (recording.time()[row] <= time) continue;
    rows.time.push_back(recording.time()[row]);
    for (std::size_t c = 0; c < recording.columns.size(); ++c) {
      if (rows.values.size() <= c) rows.values.emplace_back();
      rows.values[c].push_back(recording.at(row, c));
    }
  }
  return rows;
}

bool same_bits(const std::vector<double>& a, const std::vector<double>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0);
}

DiagramRun run(Diagram& diagram, const RunRequest& request, const RunControl& control = {}) {
  Report report;
  auto result = diagram.run(request, report, control);
  if (!result) throw std::runtime_error(to_text(report));
  return std::move(*result);
}

void expect_exact(const std::string& text, RunRequest request, double save_at, double stop) {
  Report report;
  const auto diagram = Diagram::from_text("plantloop: 1\n" + text, "test.yaml", report);
  ASSERT_TRUE(diagram) << to_text(report);
  request.save_at = {save_at};
  request.stop = stop;
  const DiagramRun whole = run(*diagram, request);
  if (!whole.statistics.ended_by.empty() && whole.recording.time().back() < save_at) return;  // it stopped by itself

  RunRequest first = request;
  first.stop = save_at;
  std::string saved;
  RunControl saving;
  saving.save = [&](const Checkpoint& c) { saved = to_json(c); };
  run(*diagram, first, saving);
  ASSERT_FALSE(saved.empty());
  const CheckpointResult read = checkpoint_from_json(saved);
  ASSERT_TRUE(read.ok()) << read.error;

  RunRequest second = request;
  second.save_at.clear();
  RunControl going_on;
  going_on.from = std::make_shared<const Checkpoint>(read.checkpoint);
  const DiagramRun rest = run(*diagram, second, going_on);
  EXPECT_EQ(rest.recording.time().front(), save_at);
  const Rows a = after(whole.recording, save_at), b = after(rest.recording, save_at);
  EXPECT_TRUE(same_bits(a.time, b.time));
  ASSERT_EQ(a.values.size(), b.values.size());
  for (std::size_t c = 0; c < a.values.size(); ++c)
    EXPECT_TRUE(same_bits(a.values[c], b.values[c])) << whole.recording.columns[c].name;
}

TEST(S14EveryBlock, GoesOnFromACheckpointToTheLastBit) {
  for (const Sample& sample : samples()) {
    SCOPED_TRACE(sample.type->name);
    // A diagram without states steps by a part of the whole run when it is not told, and the first run is shorter.
    const RunRequest request{.max_step = 0.004};
    expect_exact(diagram(sample), request, 1, 2);     // on a hit
    expect_exact(diagram(sample), request, 0.77, 2);  // between hits
  }
}

TEST(S14EverySolver, GoesOnFromACheckpointToTheLastBit) {
  const std::string text = R"(
blocks:
  u: {type: square, amplitude: 1, period: 0.7}
  s: {type: zero_order_hold, in: y, rate: 0.13}
  x: {type: integrator, in: "clamp(3*(u - s), -1, 1) - x^3"}
  y: {type: integrator, in: x - 0.5*y, reset: {when: x - 0.4, to: 0.9*y}}
  d: {type: transport_delay, in: y, delay: 0.31}
simulation: {stop: 4}
)";
  for (const SolverInfo& solver : solvers()) {
    SCOPED_TRACE(solver.name);
    RunRequest request;
    request.solver = std::string(solver.name);
    if (!solver.adaptive) request.step = 0.01;
    expect_exact(text, request, 1.7, 4);
    request.output_interval = 0.05;
    expect_exact(text, request, 1.7, 4);
  }
}

// What a delay that varies keeps meets edges, hits, resets and what comes out of it, and a delay that goes to 0.
TEST(S14EverySolver, GoesOnWithDelaysThatVaryThroughEventsToTheLastBit) {
  const std::string text = R"(
blocks:
  u: {type: pulse, amplitude: 1, period: 0.7, width: 0.15}
  r: {type: relay, in: y - 0.5, on: 0.2, off: -0.2}
  s: {type: unit_delay, in: y, initial: 0, rate: 0.13}
  z: {type: integrator, in: 1, reset: {when: z - 0.61, to: 0}}
  d: {type: variable_delay, in: {u: u + x, delay: 0.4 + 0.3*sin(3*time)}, initial: 0, shortest: 0.05}
  e: {type: variable_delay, in: {u: r, delay: 0.5*z}, initial: 0}
  x: {type: integrator, in: d - x + 0.2*s}
  y: {type: integrator, in: x - 0.5*y + 0.3*e + 0.5, reset: {when: y - 0.7, to: 0.1*y}}
simulation: {stop: 6}
)";
  for (const SolverInfo& solver : solvers()) {
    SCOPED_TRACE(solver.name);
    RunRequest request;
    request.solver = std::string(solver.name);
    if (!solver.adaptive) request.step = 0.01;
    expect_exact(text, request, 3, 6);
    expect_exact(text, request, 2.217, 6);
  }
}

// What has hits at events only has none when a run goes on, and goes on to count those that it had.
TEST(S14EveryCondition, GoesOnFromACheckpointToTheLastBit) {
  for (const std::string condition :
       {"trigger: {when: \"cos(4.1*time)\"}", "trigger: {when: \"cos(4.1*time)\", edge: falling}",
        "trigger: {when: \"cos(4.1*time)\", edge: either}", "enable: {when: \"cos(4.1*time) > 0\", initial: 0}"}) {
    SCOPED_TRACE(condition);
    const std::string text = R"(
blocks:
  x: {type: integrator, in: cos(3*time), initial: 1}
  a: {type: discrete_integrator, in: x, RATE CONDITION}
  b: {type: lag_of, in: x, CONDITION}
simulation: {stop: 6}
)";
    std::string whole = text;
    const bool triggered = condition.starts_with("trigger");
    const auto put = [&](const std::string& name, const std::string& with) {
      for (std::size_t at; (at = whole.find(name)) != std::string::npos;) whole.replace(at, name.size(), with);
    };
    put("CONDITION", condition);
    put("RATE ", triggered ? "" : "rate: 0.1, ");
    put("lag_of", triggered ? "discrete_integrator" : "first_order");
    expect_exact(whole, {}, 3, 6);
    expect_exact(whole, {}, 2.217, 6);
  }
}

// States that a Zeno policy holds at the save point are still held by the run that goes on.
TEST(S14Checkpoint, KeepsWhatAZenoPolicyHolds) {
  const std::string text = R"(
blocks:
  h: {type: integrator, in: v, initial: 1, reset: {when: h, edge: falling, to: 0}}
  v: {type: integrator, in: -9.81, reset: {when: h, edge: falling, to: -0.5*v}}
  u: {type: sine}
simulation: {stop: 4, zeno: hold}
)";
  expect_exact(text, {}, 3, 4);
}

}  // namespace
}  // namespace plantloop::family
