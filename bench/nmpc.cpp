// bench_nmpc FOLDER: predictive control against loops written for one controller.
//
//   evaluation  cost and gradient of the book's network of 5 neurons over 8 samples and 3 moves, against a loop written
//   for
//               just that; the goal is below 20 microseconds
//   loop        a closed loop of this controller, against the same with scipy's SLSQP and exact gradients; left out
//   where
//               python3 has no scipy
//   ph          10 000 samples of the neutralisation under control with its network of 10 neurons, plant included; the
//   goal
//               is below 2 s
//
// Exit status 1 when two sides compute different numbers; times decide nothing. PLANTLOOP_BENCH_QUICK: short runs.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <string>
#include <vector>

#include "control/load_predictor.h"
#include "control/move_problem.h"
#include "engine/run/diagram.h"

namespace plantloop::bench {
namespace {

const std::string sources = PLANTLOOP_BENCH_SOURCES;

double processor_time() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

constexpr int horizon = 8, moves = 3;
constexpr double beta = 0.02;

// Cost at moves v from output y; its gradient beside it.
double by_hand(const std::array<double, moves>& v, double y, double w, double before,
               std::array<double, moves>& gradient) {
  constexpr std::array<std::array<double, 3>, 5> W1{{{-0.5588, -2.0621, -1.953},
                                                     {0.5155, 0.0499, -0.867},
                                                     {-1.5149, 0.319, 0.4768},
                                                     {0.3366, -1.2029, 1.8379},
                                                     {0.8411, 1.3841, 1.7123}}};
  constexpr std::array<double, 5> W2{1.2054, 1.7784, 0.081, 1.1704, 1.4048};
  double cost = 0;
  gradient = {};
  std::array<double, moves> slope{};
  for (std::size_t i = 0; i < moves; ++i) {
    const double step = v[i] - (i == 0 ? before : v[i - 1]);
    cost += beta * step * step;
    gradient[i] += 2 * beta * step;
    if (i > 0) gradient[i - 1] -= 2 * beta * step;
  }
  for (int j = 0; j < horizon; ++j) {
    const auto move = static_cast<std::size_t>(std::min(j, moves - 1));
    double next = -0.058, by_y = 0, by_u = 0;
    for (std::size_t n = 0; n < W1.size(); ++n) {
      const double h = std::tanh(W1[n][0] * y + W1[n][1] * v[move] + W1[n][2]);
      next += W2[n] * h;
      const double d = W2[n] * (1 - h * h);
      by_y += d * W1[n][0];
      by_u += d * W1[n][1];
    }
    y = next;
    for (double& s : slope) s *= by_y;
    slope[move] += by_u;
    cost += (y - w) * (y - w);
    for (std::size_t i = 0; i < moves; ++i) gradient[i] += 2 * (y - w) * slope[i];
  }
  return cost;
}

bool evaluation(bool quick) {
  const LoadedPredictor loaded =
      load_predictor({.path = sources + "/../diagrams/book/models/first_order_mlp.yaml", .inputs = {}, .outputs = {}});
  if (!loaded.predictor) return fmt::print("{}\n", loaded.error), false;
  const MoveBlocks blocks = MoveBlocks::make({1, 1, 1}, horizon);
  const SearchOptions options;
  Room counting;
  { MoveSearch counted(*loaded.predictor, blocks, options, counting); }
  std::vector<double> memory(counting.taken());
  Room room(memory.data());
  MoveSearch search(*loaded.predictor, blocks, options, room);

  const double none = 0, before = 0.1, low = -1.5, high = 1.5, free = 1e300, least = -1e300, most = 1e300, y = 0.3,
               w = 0.8;
  const std::vector<double> target(horizon, w), alpha(horizon, 1.0), betas(moves, beta);
  const MoveNumbers numbers{&y,   &none, target.data(), alpha.data(), betas.data(), &before,
                            &low, &high, &free,         &least,       &most,        1};
  const int calls = quick ? 1000 : 100000;
  std::array<double, moves> v{-0.2, -0.5, -0.4}, gradient{}, by_hand_gradient{};
  double ours = HUGE_VAL, theirs = HUGE_VAL, cost = 0, by_hand_cost = 0;
  for (int pair = 0; pair < (quick ? 1 : 5); ++pair) {
    double began = processor_time();
    for (int i = 0; i < calls; ++i) {
      v[0] = -0.2 + 1e-6 * i;
      cost = search.cost_and_gradient(numbers, v.data(), gradient.data());
    }
    ours = std::min(ours, (processor_time() - began) / calls);
    began = processor_time();
    for (int i = 0; i < calls; ++i) {
      v[0] = -0.2 + 1e-6 * i;
      by_hand_cost = by_hand(v, y, w, before, by_hand_gradient);
    }
    theirs = std::min(theirs, (processor_time() - began) / calls);
  }
  bool agree = std::abs(cost - by_hand_cost) < 1e-12 * cost;
  for (std::size_t i = 0; i < moves; ++i) agree = agree && std::abs(gradient[i] - by_hand_gradient[i]) < 1e-11;
  fmt::print("{:<11} {:10.3f} us {:10.3f} us {:8.2f}  by hand, below 20 us{}\n", "evaluation", 1e6 * ours, 1e6 * theirs,
             ours / theirs, agree ? "" : "  VALUES DIFFER");
  return agree;
}

// A diagram's run: its seconds, and the sum of squares of a sampled column.
struct Ran {
  double seconds = HUGE_VAL, squares = 0;
};
Ran run(const std::string& text, const std::string& column) {
  Report report;
  const auto diagram = Diagram::from_text("plantloop: 1\n" + text, sources + "/bench.yaml", report);
  const auto done = diagram ? diagram->run({}, report) : std::nullopt;
  if (!done) {
    for (const Finding& finding : report.findings()) fmt::print("{}\n", finding.message);
    return {};
  }
  Ran ran{done->timing.simulate, 0};
  const int at = done->recording.find(column);
  const auto column_index = static_cast<std::size_t>(at);
  for (const std::size_t row :
       done->recording.hits[static_cast<std::size_t>(done->recording.columns[column_index].rate)])
    ran.squares += std::pow(done->recording.at(row, column_index), 2);
  return ran;
}

// Runs the script; false when there is no scipy.
bool scipy(const std::string& folder, int samples, Ran& ran) {
  const std::string file = folder + "/nmpc_scipy.txt";
  for (const char* const python : {"python3", "/usr/bin/python3"}) {
    const std::string command = fmt::format("{} {}/nmpc_scipy.py {} > {} 2> /dev/null", python, sources, samples, file);
    if (std::system(command.c_str()) != 0) continue;
    if (std::ifstream answer(file); answer >> ran.seconds >> ran.squares) return true;
  }
  return false;
}

bool loop(const std::string& folder, bool quick) {
  const int samples = quick ? 80 : 400;
  std::vector<double> times, values;
  for (int k = 0; k < samples; k += 20) {
    times.push_back(0.5 * k);
    values.push_back(std::array{0.4, 0.7, 0.2, 0.5}[static_cast<std::size_t>(k / 20 % 4)]);
  }
  const std::string text = fmt::format(
      "blocks:\n"
      "  w: {{type: staircase, times: [{}], values: [{}], rate: 0.5}}\n"
      "  c: {{type: nmpc, model: ../diagrams/book/models/first_order_mlp.yaml, in: {{w: w, y: y}}, horizon: 8, "
      "control_horizon: 3, move_weight: 0.02, lower: -1.5, upper: 1.5, initial_u: -0.7}}\n"
      "  y: {{type: unit_delay, in: y - 0.5*tanh(y + c.u^3), rate: 0.5}}\n"
      "simulation: {{stop: {}}}\nrecord: [y]\n",
      fmt::join(times, ", "), fmt::join(values, ", "), 0.5 * (samples - 1));
  Ran ours, theirs;
  for (int i = 0; i < (quick ? 1 : 5); ++i) {
    const Ran once = run(text, "y");
    ours.seconds = std::min(ours.seconds, once.seconds);
    ours.squares = once.squares;
  }
  if (!scipy(folder, samples, theirs)) {
    fmt::print("{:<11} {:10.3f} ms             left out: python3 has no scipy\n", "loop", 1e3 * ours.seconds);
    return true;
  }
  const bool agree = std::abs(ours.squares - theirs.squares) < 1e-3 * theirs.squares;
  fmt::print("{:<11} {:10.3f} ms {:10.3f} ms {:8.4f}  scipy, below 0.05{}\n", "loop", 1e3 * ours.seconds,
             1e3 * theirs.seconds, ours.seconds / theirs.seconds,
             agree ? "" : fmt::format("  VALUES DIFFER: {} and {}", ours.squares, theirs.squares));
  return agree;
}

bool ph(bool quick) {
  const int samples = quick ? 100 : 10000;
  const Ran ran = run(
      fmt::format("import: [../diagrams/parts/ph_neutralisation.yaml]\n"
                  "blocks:\n"
                  "  w: {{type: random_levels, lower: 6.5, upper: 9, hold: 40, seed: 5, generator: lcg, rate: 25}}\n"
                  "  plant: {{type: ph_neutralisation, in: c.u}}\n"
                  "  y: {{type: zero_order_hold, in: plant.sensor, rate: 25}}\n"
                  "  c: {{type: nmpc, model: ../diagrams/book/models/ph_mlp.yaml, in: {{w: w, y: y}}, horizon: 8, "
                  "control_horizon: 3, move_weight: 0.02, lower: 13.2, upper: 17.6, initial_u: 15.6}}\n"
                  "simulation: {{stop: {}}}\nrecord: [y]\n",
                  25 * (samples - 1)),
      "y");
  fmt::print("{:<11} {:10.3f} s  for {} samples, below 2 s for 10000\n", "ph", ran.seconds, samples);
  return ran.squares > 0;
}

int run_all(const std::string& folder) {
  const bool quick = std::getenv("PLANTLOOP_BENCH_QUICK") != nullptr;
  fmt::print("{:<11} {:>13} {:>13} {:>8}\n", "least of runs", "plantloop", "other", "ratio");
  const bool evaluations = evaluation(quick), loops = loop(folder, quick), neutralisations = ph(quick);
  return evaluations && loops && neutralisations ? 0 : 1;
}

}  // namespace
}  // namespace plantloop::bench

int main(int argc, char** argv) { return plantloop::bench::run_all(argc > 1 ? argv[1] : "."); }
