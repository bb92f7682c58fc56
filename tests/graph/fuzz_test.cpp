// Whatever a diagram says, elaboration ends with a graph or a finding, and a graph can be recorded.

#include <gtest/gtest.h>

#include <random>

#include "engine/diagram/model.h"
#include "tests/graph/helpers.h"

namespace plantloop {
namespace {

const std::string diagrams[] = {
    R"(plantloop: 1
parameters: {k: 2, v: [1, 2, 3], A: [[1, 2], [3, 4]], n: 3, T: 0.1, name: {text: "+-"}}
blocks:
  u: {type: step, time: 1, before: k, after: v.2}
  x: {type: integrator, in: k*u - x, initial: u, lower: -1, upper: k + 5, reset: {when: x > 3, to: v.1}}
  y: {type: sum, in: [x, u], signs: $name}
  z: {type: integrator, in: "mul(A, z) + [u, y]", initial: zeros(2)}
  d: {type: unit_delay, in: z.1 + d, rate: T, initial: plant.tau}
  w: {type: zero_order_hold, in: z, rate: {period: 2*T, offset: T}}
  plant: {type: plant, in: {u: d, e: z.2}, tau: n/2, reset: {when: u >= 1}}
  e: where(u > 0 and not (x < 1), plant.y, plant.z.2)
  c: {type: lag, repeat: n, in: previous + index, first: u, tau: index}
  b: {type: bus, in: {u: u, x: "[x, y]"}}
  f: b.x.2 + c.2 + sum(c)
  s: {type: saturation, in: v*x, lower: -k, upper: k, zero_crossing: off}
types:
  plant:
    parameters: {tau: 1, gain: 2*tau}
    inputs: {u: {default: 0}, e: {default: 1, unit: m}}
    blocks:
      inner: {type: lag, in: gain*u, tau: tau}
      y: inner + e
      z: "[inner, y, e]"
    outputs: [y, z]
  lag:
    parameters: {tau: 1}
    inputs: [u]
    blocks: {x: {type: first_order, in: u, tau: tau}}
    outputs: {x: x}
simulation: {stop: 10*T}
record: {y: y, p: plant.inner.x, q: "[z, 2*w]"}
expect:
  - {signal: q.2, max: k}
  - {signal: p, at: T, value: v.3}
)"};

const std::vector<std::string>& words() {
  static const std::vector<std::string> list{
      "u",          "x",        "y",           "z",         "d",         "w",       "plant", "k",
      "v",          "A",        "n",           "T",         "1",         "0",       "-1",    "1e9",
      "0.5",        "time",     "inf",         "plant.y",   "plant.z",   "v.2",     "z.1:2", "A.1.2",
      "[u, x]",     "zeros(n)", "eye(2)",      "mul(A, z)", "dot(v, v)", "sum",     "gain",  "integrator",
      "unit_delay", "lag",      "type",        "in",        "rate",      "initial", "reset", "plant.tau",
      "c.1",        "b.u",      "previous",    "next",      "index",     "repeat",  "bus",   "first",
      "$name",      "step",     "first_order", "{}",        "[]",        "x.1",     "tau"};
  return list;
}

bool is_word(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '.';
}

// Replaces, removes or doubles a word, or swaps two.
std::string mutated(std::string text, std::mt19937& random) {
  const auto pick = [&](std::size_t n) { return std::uniform_int_distribution<std::size_t>(0, n - 1)(random); };
  for (std::size_t times = 1 + pick(2); times > 0; --times) {
    std::size_t at = pick(text.size());
    while (at < text.size() && !is_word(text[at])) ++at;
    std::size_t begin = at, end = at;
    while (begin > 0 && is_word(text[begin - 1])) --begin;
    while (end < text.size() && is_word(text[end])) ++end;
    if (end - begin == 0 || begin < 13) continue;
    const std::string word = text.substr(begin, end - begin);
    switch (pick(5)) {
      case 0:
        text.erase(begin, end - begin);
        break;
      case 1:
        text.insert(end, " + " + word);
        break;
      default:
        text.replace(begin, end - begin, words()[pick(words().size())]);
        break;
    }
  }
  return text;
}

TEST(Fuzz, NeverCrashesAndAlwaysSaysWhy) {
  std::mt19937 random(20261123);
  int graphs = 0;
  for (const std::string& diagram : diagrams) {
    Report clean;
    ASSERT_TRUE(elaborate(read_model_text(diagram, "fuzz.yaml", clean), {}, clean)) << to_text(clean);
    for (int turn = 0; turn < 1500; ++turn) {
      const std::string text = mutated(diagram, random);
      Report report;
      const auto model = read_model_text(text, "fuzz.yaml", report);
      if (!model) {
        ASSERT_TRUE(report.has_errors()) << text;
        continue;
      }
      const auto graph = elaborate(model, {{"k", "3"}}, report);
      ASSERT_EQ(graph == nullptr, report.has_errors()) << text << to_text(report);
      if (!graph) continue;
      ++graphs;
      const RecordedGraph recorded = record(*graph);
      for (std::size_t i = 0; i < recorded.record.wires.size(); ++i) ASSERT_TRUE(recorded.record.wire_bound[i]) << text;
      ASSERT_EQ(recorded.uses.size(), recorded.record.parameters.size());
    }
  }
  EXPECT_GT(graphs, 100);
}

}  // namespace
}  // namespace plantloop
