// The order in which blocks are recorded changes no bit of what they compute.

#include <algorithm>
#include <numeric>

#include "tests/program/random_equations.h"

namespace plantloop::testing_programs {
namespace {

// A ring of n coupled oscillators with limits, recorded block by block in the order given.
std::vector<double> ring(const std::vector<int>& order) {
  const auto n = order.size();
  Recorder recorder;
  std::vector<Value> force, speed(n), place(n);
  for (std::size_t i = 0; i < n; ++i) force.push_back(recorder.wire());
  const auto name = [](std::size_t i) { return std::to_string(1000 + i); };
  for (std::size_t i = 0; i < n; ++i) {
    speed[i] = add_state(recorder, "v" + name(i)).value;
    place[i] = add_state(recorder, "x" + name(i)).value;
  }
  for (const int at : order) {
    const auto i = static_cast<std::size_t>(at);
    const std::size_t left = (i + n - 1) % n, right = (i + 1) % n;
    recorder.bind(force[i], sin(place[left] - place[i]) + min(place[right] - place[i], Value(0.5)) * 1.25);
    recorder.record.states[2 * i].derivative = force[i] - 0.1 * speed[i];
    recorder.record.states[2 * i + 1].derivative = speed[i] + force[left] * 0.01;
  }
  Evaluation evaluation(compiled(recorder, force));
  std::mt19937 random(5);
  for (std::uint32_t i = 0; i < 2 * n; ++i)
    evaluation.set_state(i, std::uniform_real_distribution<double>(-2, 2)(random));
  evaluation.settle();
  std::vector<double> all = evaluation.derivatives();
  const std::vector<double> watches = evaluation.watches();
  all.insert(all.end(), watches.begin(), watches.end());
  return all;
}

TEST(RecordingOrder, ChangesNoBit) {
  std::vector<int> order(64);
  std::iota(order.begin(), order.end(), 0);
  const std::vector<double> first = ring(order);
  std::mt19937 random(11);
  for (int trial = 0; trial < 10; ++trial) {
    std::shuffle(order.begin(), order.end(), random);
    const std::vector<double> again = ring(order);
    for (std::size_t i = 0; i < first.size(); ++i) ASSERT_TRUE(same_bits(first[i], again[i]));
  }
}

TEST(States, KeepTheirNamesWhereverTheyStandInTheArena) {
  Recorder recorder;
  std::vector<StateIn> states;
  for (int i = 0; i < 30; ++i) states.push_back(add_state(recorder, "x" + std::to_string(i)));
  for (std::size_t i = 0; i < 30; ++i)
    recorder.record.states[i].derivative = states[(i * 7 + 3) % 30].value * static_cast<double>(i + 1);
  Evaluation evaluation(compiled(recorder));
  for (std::uint32_t i = 0; i < 30; ++i) evaluation.set_state(i, i);
  evaluation.settle();
  const auto derivatives = evaluation.derivatives();
  for (std::size_t i = 0; i < 30; ++i) {
    EXPECT_EQ(derivatives[i], static_cast<double>((i * 7 + 3) % 30) * static_cast<double>(i + 1));
    const Program& program = *evaluation.frame().program;
    EXPECT_EQ(program.state_names[program.place_of_state[i]], "x" + std::to_string(i));
  }
}

}  // namespace
}  // namespace plantloop::testing_programs
