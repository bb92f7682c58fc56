// The problem of one sample of a predictive controller, and the search for its solution.
//
// Variables v are the moves: values of the inputs, each held for a block of samples, the last to the end of the
// horizon.
//
//   min  sum over j = N1..N2 and outputs of alpha (y(k+j) + e - r(k+j))^2 + sum over moves of beta (v - v before)^2
//
// with limits on the moves, on the change from move to move and on the signals of the samples 1..N2. It is a problem of
// least squares: each iteration solves the quadratic program of the linearised signals (Gauss and Newton's method with
// constraints) and goes along its solution as far as the exact penalty function (S. P. Han 1977) goes down. Where that
// takes long, since large errors remain, the curvature of the Lagrangian is added, from differences of exact gradients.
// The limits of the inputs are linear, so every iterate keeps them.

#pragma once

#include <chrono>
#include <vector>

#include "control/quadratic_program.h"
#include "learned/predictor.h"

namespace plantloop {

// How the inputs of the horizon follow from the moves.
struct MoveBlocks {
  std::vector<int> move_at;  // of each sample of the horizon
  int moves = 1;
  // Lengths of the blocks; the last one goes on to the end.
  static MoveBlocks make(const std::vector<int>& lengths, int horizon);
  int horizon() const { return static_cast<int>(move_at.size()); }
};

// The numbers of one sample. Arrays run with time; a limit beyond `no_limit` is none.
struct MoveNumbers {
  static constexpr double no_limit = 1e299;
  const double* state;
  const double* error;   // outputs: added to what is predicted
  const double* target;  // horizon x outputs
  const double* alpha;   // horizon x outputs; 0 before N1
  const double* beta;    // moves x inputs
  const double* before;  // inputs: what was applied at the sample before
  const double* lower;   // inputs
  const double* upper;
  const double* change;  // inputs: greatest one
  const double* least;   // signals
  const double* most;
  double slack_weight;
};

struct SearchOptions {
  bool soft = false;  // limits of signals may be exceeded at a cost: slack_weight (s + s^2) for each signal's greatest
                      // excess s
  int candidates = 11;
  int max_iterations = 50;
  double max_time = 0;      // s by the clock; 0: no limit, and results that do not depend on the machine
  double tolerance = 1e-9;  // of the last step, relative
  friend bool operator==(const SearchOptions&, const SearchOptions&) = default;
};

class MoveSearch {
 public:
  static constexpr double feasibility = 1e-8;  // by how much a kept limit may be exceeded, relative to its width
  enum Status { solved = 0, soft_exceeded = 1, used_up = 2, infeasible = 3, no_prediction = 4 };
  struct Result {
    Status status = no_prediction;
    double cost = 0;    // without penalties
    double excess = 0;  // the greatest of all signals
    int iterations = 0;
  };

  // Takes what it needs from the room.
  MoveSearch(const Predictor& predictor, const MoveBlocks& blocks, const SearchOptions& options, Room& room);

  // From the moves `plan` on, which become the solution: moves x inputs.
  Result solve(const MoveNumbers& numbers, double* plan);
  // The signals of the last solution, horizon x signals, with the extras.
  const double* signals(const double* plan);
  // Cost and its gradient by the moves; for measurements and tests.
  double cost_and_gradient(const MoveNumbers& numbers, const double* plan, double* gradient);

 private:
  struct Value {
    double cost = 0, penalty = 0, excess = 0, violation = 0;
    bool is_finite = false;
    double whole() const { return cost + penalty; }
  };
  Value evaluate(const double* v);
  void inputs_of(const double* v);
  void differentiate();
  void take_multipliers();
  void gradient_of_lagrangian(double* gradient) const;
  void curve(const double* v);
  void objective(const double* v);
  int input_rows(const double* v, int variables);
  template <typename Each>
  void for_each_limit(const Each& each) const;
  int signal_rows(int row, int variables);
  void stiffen(double stiffness, int variables);
  bool is_limited(int signal) const;
  void set_slopes_of_inputs();
  double scale_of(int signal) const;
  double limited(int sample, int signal) const;
  QuadraticProgram::Outcome quadratic(const double* v, bool slack, double weight);
  void keep_best(const double* v, const Value& value);
  bool is_better(const Value& a, const Value& b) const;
  bool is_out_of_time() const;
  bool is_feasible(const Value& value) const { return value.violation <= 1; }
  void clip(double* v) const;
  bool search(double* v, Value value);
  bool try_candidates(double* v, Value* value);

  const Predictor& predictor_;
  const MoveBlocks& blocks_;
  const SearchOptions& options_;
  int horizon_, inputs_, outputs_, signals_count_, variables_, slacks_ = 0;
  bool with_extras_ = false;
  const MoveNumbers* n_ = nullptr;
  QuadraticProgram program_;
  double *by_moves_, *u_, *signals_, *slopes_, *trial_, *best_, *start_, *room_;
  double* was_active_;  // by row of the last program, where is_known_active_
  bool is_known_active_ = false;
  double *multipliers_, *curvature_, *slope_here_;  // of the signals' limits; what Gauss and Newton leave out
  Value best_value_;
  bool has_best_ = false;
  int iterations_ = 0;
  std::chrono::steady_clock::time_point began_;
  bool is_curved_ = false;               // curvature_ counts
  int first_signal_row_ = 0, rows_ = 0;  // of the last program
};

}  // namespace plantloop
