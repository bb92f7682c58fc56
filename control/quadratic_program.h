// Small dense convex quadratic programs, solved exactly: min x'H x/2 + g'x with A x >= b.

#pragma once

#include <cstddef>

#include "learned/predictor.h"

namespace plantloop {

// The dual method of D. Goldfarb and A. Idnani (Mathematical Programming 27, 1983): it begins at the minimum without
// constraints and takes them in one by one, so it needs no feasible start, ends after finitely many steps, and finds
// out for certain when there is no x that keeps them all. Nothing is allocated.
class QuadraticProgram {
 public:
  // Takes its matrices from the room: up to `variables` x and `constraints` rows.
  QuadraticProgram(int variables, int constraints, Room& room);

  // To be filled before solve(). H is symmetric, row by row; the lower part is read.
  double* H;  // variables x variables
  double* g;
  double* A;  // constraints x variables
  double* b;

  enum class Outcome { solved, infeasible, not_convex, stopped };
  // For the first n variables and m constraints, with rows of n numbers. H must be positive definite. `x` and, of each
  // constraint, its multiplier (>= 0) are left in the fields below.
  Outcome solve(int n, int m);

  double* x;
  double* multiplier;

 private:
  bool factor(int n);
  int most_violated(int n, int m, double* excess) const;
  void direction(int n, const double* normal);
  bool take_in(int n, int constraint);
  void drop(int n, int place);

  double* J_;  // L^-T times a rotation
  double* R_;  // triangle of the active constraints
  double* d_;
  double* z_;
  double* r_;
  double* u_;       // multipliers of the active constraints and of the one that comes in
  double* active_;  // their numbers
  double* scale_;   // length of each row of A
  int size_;        // of R
  int count_ = 0;   // active constraints
};

}  // namespace plantloop
