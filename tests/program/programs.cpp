// Record to numbers in a few calls.

#include "tests/program/programs.h"

#include <bit>
#include <cmath>

namespace plantloop::testing_programs {

StateIn add_state(Recorder& recorder, const std::string& name, Value initial) {
  recorder.record.states.push_back({name, recorder.site, 0, initial, {}});
  const auto index = static_cast<std::uint32_t>(recorder.record.states.size() - 1);
  return {recorder.state(index), index};
}

StateIn add_discrete(Recorder& recorder, const std::string& name, RateIndex rate, Value initial) {
  recorder.record.discretes.push_back({name, recorder.site, rate, 0, initial, {}});
  const auto index = static_cast<std::uint32_t>(recorder.record.discretes.size() - 1);
  return {recorder.discrete(index), index};
}

std::shared_ptr<const Program> compiled(const Recorder& recorder, std::vector<Value> watches,
                                        std::vector<Value> numbers, const std::string& unroll_method,
                                        double unroll_step) {
  Report report;
  CompileOptions options;
  options.watches = std::move(watches);
  options.numbers = std::move(numbers);
  options.unroll_method = unroll_method;
  options.unroll_step = unroll_step;
  auto program = compile(recorder.record, options, report);
  EXPECT_TRUE(program != nullptr) << to_text(report);
  return program;
}

std::string findings_of(const Recorder& recorder, bool solve_loops) {
  Report report;
  CompileOptions options;
  options.loops_are_errors = !solve_loops;
  compile(recorder.record, options, report);
  std::string text;
  for (const Finding& finding : report.findings()) text += finding.message + "\n";
  return text;
}

void Evaluation::settle() {
  KernelFrame kernels = frame_.kernel_frame(false);
  const Program& program = *frame_.program;
  execute(program.parameter_list, frame_.arena, &kernels);
  for (int pass = 0; pass < 20; ++pass) {
    execute(program.held_list, frame_.arena, &kernels);
    execute(program.mode_list, frame_.arena, &kernels);
    bool stays = true;
    for (std::size_t m = 0; m < program.modes.size(); ++m) {
      double& mode = frame_.arena[program.modes[m]];
      const double now = frame_.arena[program.mode_list.roots[m]];
      stays = stays && mode == now;
      mode = now;
    }
    if (stays) return;
  }
}

std::vector<double> Evaluation::roots(const List& list) {
  KernelFrame kernels = frame_.kernel_frame(false);
  execute(list, frame_.arena, &kernels);
  std::vector<double> values;
  for (const auto slot : list.roots) values.push_back(frame_.arena[slot]);
  return values;
}

std::vector<double> Evaluation::watches() { return roots(frame_.program->watch_list); }

std::vector<double> Evaluation::derivatives() {
  const std::vector<double> by_place = roots(frame_.program->derivative_list);
  std::vector<double> values;
  for (const auto place : frame_.program->place_of_state) values.push_back(by_place[place]);
  return values;
}

std::vector<std::vector<double>> Evaluation::jacobian() {
  const Program& program = *frame_.program;
  const std::vector<double> entries = roots(program.jacobian_list);
  const std::size_t n = program.state_at.size();
  std::vector<std::vector<double>> result(n, std::vector<double>(n, 0));
  for (std::size_t column = 0; column < n; ++column) {
    const auto first = static_cast<std::size_t>(program.jacobian_column_start[column]);
    const auto last = static_cast<std::size_t>(program.jacobian_column_start[column + 1]);
    for (std::size_t e = first; e < last; ++e) {
      result[program.state_at[static_cast<std::size_t>(program.jacobian_row[e])]][program.state_at[column]] =
          entries[e];
    }
  }
  return result;
}

bool same_bits(double a, double b) {
  return (std::isnan(a) && std::isnan(b)) || std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

}  // namespace plantloop::testing_programs
