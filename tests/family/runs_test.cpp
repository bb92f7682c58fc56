// What every block does in a run: it goes through, whatever the order of the file, the solver and the sizes.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "engine/run/recording.h"
#include "tests/blocks/diagrams.h"
#include "tests/family/samples.h"

namespace plantloop::family {
namespace {

using testing_diagrams::run;
using testing_diagrams::Signals;

std::string csv(const std::string& text, const RunRequest& request = {}) {
  return to_csv(run(text, request).recording());
}

// A run ends with an error when anything it records is not finite.
TEST(EveryBlock, RunsWithItsDefaults) {
  for (const Sample& sample : samples()) {
    SCOPED_TRACE(sample.type->name);
    const Signals r = run(diagram(sample));
    EXPECT_GE(r.recording().columns.size(), sample.type->block->outputs_declared.size());
    if (r.whole().statistics.ended_by != "it") {
      EXPECT_EQ(r.recording().time().back(), 2);
    }
  }
}

TEST(EveryBlock, GivesTheSameBytesTwice) {
  for (const Sample& sample : samples()) EXPECT_EQ(csv(diagram(sample)), csv(diagram(sample))) << sample.type->name;
}

TEST(EveryBlock, DoesNotCareForTheOrderOfTheFile) {
  for (const Sample& sample : samples()) {
    const std::string text = diagram(sample);
    // The instance before its signals.
    const std::size_t first = text.find("blocks:\n") + 8, instance = text.find("  it:\n"),
                      end = text.find("simulation:");
    const std::string turned = text.substr(0, first) + text.substr(instance, end - instance) +
                               text.substr(first, instance - first) + text.substr(end);
    EXPECT_EQ(csv(text), csv(turned)) << sample.type->name;
  }
}

// Fixed and adaptive, explicit and implicit solvers meet. The blocks' own states are of order 1; rk4 with 0.005 s and
// bdf with rtol 1e-8 are good to 1e-5 even for a pole at 100 rad/s.
TEST(EveryBlock, GivesTheSameWithEverySolver) {
  for (const Sample& sample : samples()) {
    SCOPED_TRACE(sample.type->name);
    const Signals reference = run(diagram(sample), {.rtol = 1e-9, .atol = 1e-11});
    for (const RunRequest& request :
         {RunRequest{.step = 0.005, .solver = "rk4"}, RunRequest{.rtol = 1e-8, .atol = 1e-10, .solver = "bdf"}}) {
      const Signals other = run(diagram(sample), request);
      for (const RecordedColumn& column : reference.recording().columns) {
        EXPECT_NEAR(other.last(column.name), reference.last(column.name), 1e-4)
            << column.name << " by " << *request.solver;
      }
    }
  }
}

// Where all ports and outputs go element by element, a vector is so many scalars.
bool is_elementwise(const Block& block) {
  if (block.inputs.empty() && block.lists.empty()) return false;
  const auto own = [](const auto& list) {
    return std::all_of(list.begin(), list.end(),
                       [](const auto* d) { return d->spec.size.kind == Size::Kind::elementwise; });
  };
  return own(block.inputs) && own(block.lists) && own(block.outputs_declared);
}

TEST(EveryElementwiseBlock, TreatsAVectorLikeScalars) {
  int count = 0;
  for (const Sample& sample : samples()) {
    if (!is_elementwise(*sample.type->block)) continue;
    ++count;
    SCOPED_TRACE(sample.type->name);
    std::string text = "blocks:\n", record;
    for (std::size_t i = 1; i <= sample.inputs.size(); ++i) {
      for (int e = 1; e <= 3; ++e) text += fmt::format("  e{}_{}: {}*sin({}*time) + 0.4\n", e, i, 0.3 + 0.1 * e, i);
      text += fmt::format("  in{}: [e1_{}, e2_{}, e3_{}]\n", i, i, i, i);
    }
    text += sample.instance("it");
    for (int e = 1; e <= 3; ++e) text += sample.instance(fmt::format("one{}", e), fmt::format("e{}_", e));
    for (const Output* output : sample.type->block->outputs_declared) {
      for (const char* name : {"it", "one1", "one2", "one3"}) record += fmt::format("{}.{}, ", name, output->name);
    }
    text += "simulation: {stop: 2}\nrecord: [" + record.substr(0, record.size() - 2) + "]\n";
    const Signals r = run(text);
    for (const Output* output : sample.type->block->outputs_declared) {
      for (int e = 1; e <= 3; ++e) {
        EXPECT_EQ(r.column(fmt::format("it.{}.{}", output->name, e)),
                  r.column(fmt::format("one{}.{}", e, output->name)));
      }
    }
  }
  EXPECT_GT(count, 15);
}

// A value that is set before a run, without compiling again, does what the same value in the file does.
TEST(EveryParameter, WorksTheSameSetOrWritten) {
  for (const Sample& sample : samples()) {
    for (const Number* n : sample.type->block->numbers) {
      if (std::isnan(n->spec.init) || !std::isfinite(n->spec.init) || n->spec.structural) continue;
      double value = n->spec.init + 1;
      if (!(value <= n->spec.max)) value = n->spec.max;
      SCOPED_TRACE(fmt::format("{}.{} = {}", sample.type->name, n->name, value));
      Sample written = sample;
      written.parameters.emplace_back(n->name, fmt::format("{}", value));
      const std::string text = diagram(written);
      if (!testing_diagrams::findings(text).empty()) continue;  // it does not go with the other defaults
      Sample plain = sample;
      plain.parameters.emplace_back(n->name, fmt::format("{}", n->spec.init));

      Report report;
      const auto compiled = Diagram::from_text("plantloop: 1\n" + diagram(plain), "test.yaml", report);
      ASSERT_TRUE(compiled->run({}, report));
      const auto set = compiled->run({.set = {{fmt::format("it.{}", n->name), fmt::format("{}", value)}}}, report);
      ASSERT_TRUE(set) << to_text(report);
      EXPECT_EQ(to_csv(set->recording), csv(text));
    }
  }
}

}  // namespace
}  // namespace plantloop::family
