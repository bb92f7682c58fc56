// The exact Jacobian of every block equals a difference quotient.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "engine/graph/record.h"
#include "engine/run/simulation.h"
#include "tests/family/samples.h"

namespace plantloop::family {
namespace {

// The block between states: each input is a state, and each output drives one, so that every partial derivative of the
// block is an entry of df/dx.
std::string between_states(const Sample& sample) {
  std::string text = "plantloop: 1\nblocks:\n";
  for (std::size_t i = 0; i < sample.inputs.size(); ++i) {
    text += fmt::format("  in{}: {{type: integrator, in: 0.3 - 0.5*in{}, initial: {}}}\n", i + 1, i + 1,
                        0.35 + 0.2 * static_cast<double>(i));
  }
  text += sample.instance("it");
  const auto outputs = sample.outputs("it");
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    text += fmt::format("  out{}: {{type: integrator, in: \"sum({})\"}}\n", i + 1, outputs[i]);
  }
  return text + "simulation: {stop: 0.37}\n";
}

TEST(EveryBlock, HasTheJacobianOfADifferenceQuotient) {
  int entries = 0;
  for (const Sample& sample : samples()) {
    SCOPED_TRACE(sample.type->name);
    Report report;
    const auto model = read_model_text(between_states(sample), "test.yaml", report);
    ASSERT_TRUE(model) << to_text(report);
    const auto graph = elaborate(model, {}, report);
    ASSERT_TRUE(graph) << to_text(report);
    const RecordedGraph recorded = record(*graph);
    const auto program = compile(recorded.record, {}, report);
    ASSERT_TRUE(program) << to_text(report);
    if (!program->jacobian_is_exact) continue;
    Frame frame(program);
    SimulationOptions options;
    options.stop = 0.37;
    Recording recording;
    simulate(frame, options, {}, recording);  // leaves modes and held values as they are at the end

    KernelFrame kernels = frame.kernel_frame(true);
    const std::size_t n = frame.state_count();
    std::vector<double> jacobian(n * n);
    if (!program->jacobian_list.empty()) execute(program->jacobian_list, frame.arena, &kernels);
    for (std::size_t column = 0; column < n; ++column) {
      for (int k = program->jacobian_column_start[column]; k < program->jacobian_column_start[column + 1]; ++k) {
        const auto at = static_cast<std::size_t>(k);
        jacobian[static_cast<std::size_t>(program->jacobian_row[at]) * n + column] =
            frame.arena[program->jacobian_list.roots[at]];
        ++entries;
      }
    }
    const auto rates = [&] {
      execute(program->derivative_list, frame.arena, &kernels);
      const double* const first = frame.arena + program->derivative_list.roots.front();
      return std::vector<double>(first, first + n);
    };
    for (std::size_t column = 0; column < n; ++column) {
      double* const x = frame.states() + column;
      const double at = *x, h = 1e-5;
      *x = at + h;
      const std::vector<double> above = rates();
      *x = at - h;
      const std::vector<double> below = rates();
      *x = at;
      for (std::size_t row = 0; row < n; ++row) {
        const double quotient = (above[row] - below[row]) / (2 * h);
        // The central quotient is wrong by h^2 times a third derivative, and by rounding/h.
        EXPECT_NEAR(jacobian[row * n + column], quotient, 1e-6 * (1 + std::fabs(quotient)))
            << program->state_names[row] << " by " << program->state_names[column];
      }
    }
  }
  EXPECT_GT(entries, 100);
}

}  // namespace
}  // namespace plantloop::family
