// bench_compare FOLDER: times each diagram against its hand-written counterpart, in five interleaved pairs.
//
// Diagrams are written to FOLDER. With PLANTLOOP_BENCH_QUICK set, one short pair each: a check that everything runs.
// Exit status 1 when the two sides compute different values; times decide nothing.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include "bench/workloads.h"

namespace plantloop::bench {
namespace {

struct Case {
  std::string name;
  double goal;  // times the hand-written program
  std::function<Measured()> handwritten;
  std::string yaml;
};

std::vector<Case> make_cases(bool quick) {
  const long shorten = quick ? 100 : 1;
  Pendulum pendulum;
  pendulum.steps /= shorten;
  Chain chain = make_chain(1000, 100'000);
  chain.steps /= shorten;
  Chain long_chain = make_chain(3333, 30'000);
  long_chain.steps /= shorten;
  const auto run = [](const auto& workload) { return [workload] { return run_handwritten(workload); }; };
  return {
      {"pendulum", 1.7, run(pendulum), to_yaml(pendulum)},
      {"chain_1000", 1.2, run(chain), to_yaml(chain, Order::declared)},
      {"chain_1000_random", 1.2, run(chain), to_yaml(chain, Order::random)},
      {"chain_3333", 1.6, run(long_chain), to_yaml(long_chain, Order::declared)},
      {"chain_3333_random", 1.6, run(long_chain), to_yaml(long_chain, Order::random)},
  };
}

double median(std::vector<double> values) {
  std::ranges::sort(values);
  return values[values.size() / 2];
}

// True when both sides agree on the last value.
bool compare(const Case& item, const std::string& path, int pairs) {
  std::vector<double> by_hand;
  std::vector<double> by_engine;
  std::vector<double> ratios;
  bool agree = true;
  for (int i = 0; i < pairs; ++i) {
    const Measured hand = item.handwritten();
    const Measured engine = run_plantloop(path);
    by_hand.push_back(hand.seconds);
    by_engine.push_back(engine.seconds);
    ratios.push_back(engine.seconds / hand.seconds);
    agree = agree && std::abs(engine.value - hand.value) <= 1e-6 * (1 + std::abs(hand.value));
  }
  fmt::print("{:<18} {:9.4f} s {:9.4f} s {:7.2f} {:7.2f}{}\n", item.name, median(by_hand), median(by_engine),
             median(ratios), item.goal, agree ? "" : "  VALUES DIFFER");
  return agree;
}

int run(const std::string& folder) {
  const bool quick = std::getenv("PLANTLOOP_BENCH_QUICK") != nullptr;
  fmt::print("{:<18} {:>11} {:>11} {:>7} {:>7}\n", "median of pairs", "by hand", "diagram", "ratio", "goal");
  bool agree = true;
  for (const Case& item : make_cases(quick)) {
    const std::string path = folder + "/" + item.name + ".yaml";
    std::ofstream(path) << item.yaml;
    agree = compare(item, path, quick ? 1 : 5) && agree;
    std::fflush(stdout);
  }
  return agree ? 0 : 1;
}

}  // namespace
}  // namespace plantloop::bench

int main(int argc, char** argv) { return plantloop::bench::run(argc > 1 ? argv[1] : "."); }
