// Random small diagrams: findings, a finished run, or an error that says when and where; never a crash or a hang.

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "engine/base/error.h"
#include "engine/run/diagram.h"

namespace plantloop {
namespace {

class RandomDiagram {
 public:
  explicit RandomDiagram(unsigned seed) : random_(seed) {}

  std::string text() {
    const int n = 2 + any(10);
    for (int i = 0; i < n; ++i) names_.push_back("b" + std::to_string(i));
    std::string blocks;
    for (; present_ < n; ++present_)
      blocks += "  " + names_[static_cast<std::size_t>(present_)] + ": " + block() + "\n";
    const char* const solvers[] = {
        "rtol: 1e-5",    "solver: rk4, step: 0.01",  "solver: heun, step: 0.03", "solver: bdf",
        "solver: adams", "solver: bogacki_shampine", "output_interval: 0.07",    "solver: euler, step: 0.25"};
    const char* const stops[] = {"1", "0.3", "2.5", "7"};
    return "plantloop: 1\nparameters: {p: " + number() + ", q: " + number() + "}\nblocks:\n" + blocks +
           "simulation: {stop: " + stops[any(4)] + ", max_steps: 20000, max_rows: 50000, " + solvers[any(8)] + "}\n";
  }

 private:
  int any(int n) { return std::uniform_int_distribution<int>(0, n - 1)(random_); }
  std::string number() {
    const char* const numbers[] = {"0", "1", "-1", "0.5", "2", "3.7", "-0.01", "1e-3", "1e6", "0.1", "10", "-20"};
    return numbers[any(12)];
  }
  std::string positive() {
    const char* const numbers[] = {"1", "0.5", "2", "0.05", "1e-3", "10"};
    return numbers[any(6)];
  }
  // Mostly a block above, so that not every diagram is an algebraic loop.
  std::string signal() {
    if (any(8) == 0) return number();
    if (any(12) == 0) return "time";
    const bool above = present_ > 0 && any(8) != 0;
    return names_[static_cast<std::size_t>(any(above ? present_ : static_cast<int>(names_.size())))];
  }
  std::string expression(int depth = 0) {
    const auto sub = [&] { return depth > 2 ? signal() : expression(depth + 1); };
    switch (any(16)) {
      case 0:
        return "(" + sub() + " + " + sub() + ")";
      case 1:
        return "(" + sub() + " - " + sub() + ")";
      case 2:
        return sub() + "*" + sub();
      case 3:
        return sub() + "/" + sub();
      case 4:
        return "where(" + sub() + " > " + sub() + ", " + sub() + ", " + sub() + ")";
      case 5:
        return "min(" + sub() + ", " + sub() + ")";
      case 6:
        return "mod(" + sub() + ", " + number() + ")";
      case 7: {
        const char* const functions[] = {"sqrt", "log", "exp", "floor", "sign", "abs", "round", "tan", "asin", "ceil"};
        return std::string(functions[any(10)]) + "(" + sub() + ")";
      }
      case 8:
        return "sin(" + sub() + ")";
      case 9:
        return "p";
      case 10:
        return "q*" + signal();
      default:
        return signal();
    }
  }
  std::string rate() {
    const char* const rates[] = {", rate: 0.1", ", rate: 0.05", ", rate: {period: 0.1, offset: 0.02}", ", rate: 1/3",
                                 ""};
    return rates[any(5)];
  }
  std::string in() { return ", in: \"" + expression() + "\""; }
  std::string block() {
    switch (any(34)) {
      case 0:
      case 1:
      case 2:
        return "{type: integrator" + in() + ", initial: " + number() + "}";
      case 3:
        return "{type: integrator" + in() + ", lower: -1, upper: " + positive() + "}";
      case 4:
        return "{type: integrator" + in() + ", reset: {when: \"" + expression() + " > " + number() +
               "\", to: " + number() + "}}";
      case 5:
      case 6:
        return "{type: first_order" + in() + ", tau: " + positive() + "}";
      case 7:
        return "{type: transfer_function" + in() + ", num: [1, " + number() + "], den: [1, 2, " + number() + "]}";
      case 8:
        return "{type: filtered_derivative" + in() + ", N: " + positive() + "}";
      case 9:
      case 10:
        return "{type: transport_delay" + in() + ", delay: " + positive() + "}";
      case 11:
      case 12:
        return "{type: unit_delay" + in() + rate() + ", initial: " + number() + "}";
      case 13:
        return "{type: zero_order_hold" + in() + rate() + "}";
      case 14:
        return "{type: discrete_integrator" + in() + rate() + ", method: trapezoidal}";
      case 15:
        return "{type: tapped_delay" + in() + rate() + ", taps: 3}";
      case 16:
        return "{type: moving_average" + in() + rate() + ", samples: 3}";
      case 17:
        return "{type: saturation" + in() + ", lower: -" + positive() + ", upper: " + positive() + "}";
      case 18:
        return "{type: dead_zone" + in() + ", lower: -" + positive() + ", upper: " + positive() + "}";
      case 19:
        return "{type: relay" + in() + ", on: 0.3, off: -0.3}";
      case 20:
        return "{type: quantiser" + in() + ", interval: " + positive() + "}";
      case 21:
        return "{type: lookup_1d" + in() + ", x: [-1, 0, 2], y: [1, 0, " + number() + "]}";
      case 22:
        return "{type: step, time: " + number() + "}";
      case 23:
        return "{type: square, period: " + positive() + "}";
      case 24:
        return "{type: pulse, period: " + positive() + ", width: 1e-6}";
      case 25:
        return "{type: random_levels" + rate() + "}";
      case 26:
        return "{type: pid, in: {e: \"" + expression() + "\"}, kp: " + number() + ", ki: 1, kd: 0.1" +
               (any(2) == 0 ? ", lower: -1, upper: 1}" : "}");
      case 27:
        return "{type: switch, in: {condition: \"" + expression() + " > 0\", then: \"" + expression() + "\", else: \"" +
               expression() + "\"}}";
      case 28:
        return "{type: staircase, times: [0, 0.3, 1], values: [1, -1, " + number() + "]}";
      case 29:
        return "{type: sum, in: [" + signal() + ", " + signal() + ", \"" + expression() + "\"]}";
      default:
        return "\"" + expression() + "\"";
    }
  }

  std::mt19937 random_;
  std::vector<std::string> names_;
  int present_ = 0;  // the block that is being written
};

enum class Outcome { findings, finished, failed };

Outcome run_once(const std::string& text, Report& report) {
  const auto diagram = Diagram::from_text(text, "fuzz.yaml", report);
  if (!diagram) return Outcome::findings;
  try {
    RunControl control;
    control.time_limit = 5;
    const auto run = diagram->run({}, report, control);
    if (!run) {
      EXPECT_TRUE(report.has_errors()) << text;
      return Outcome::findings;
    }
    const auto& time = run->recording.time();
    for (std::size_t i = 1; i < time.size(); ++i) EXPECT_GE(time[i], time[i - 1]) << text;
    EXPECT_TRUE(run->options.output_interval > 0 || time.back() == run->options.stop) << text;
    for (std::size_t c = 0; c < run->recording.columns.size(); ++c) {
      for (const double v : run->recording.column(c)) EXPECT_TRUE(std::isfinite(v)) << text;
    }
    return Outcome::finished;
  } catch (const RunError& error) {
    EXPECT_STRNE(error.what(), "") << text;
    return Outcome::failed;
  }
}

TEST(RandomDiagrams, GiveFindingsAResultOrAnError) {
  int counts[3] = {};
  for (unsigned seed = 1; seed <= 600; ++seed) {
    const std::string text = RandomDiagram(seed).text();
    SCOPED_TRACE("seed " + std::to_string(seed));
    Report report;
    ++counts[static_cast<int>(run_once(text, report))];
  }
  // The generator is of use only when a good part of its diagrams runs.
  EXPECT_GT(counts[static_cast<int>(Outcome::finished)], 100);
  EXPECT_GT(counts[static_cast<int>(Outcome::findings)], 20);
}

}  // namespace
}  // namespace plantloop
