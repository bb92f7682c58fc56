// Quadratic programs along the horizon, a line search on the exact penalty, and candidates to begin with.

#include "control/move_problem.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "learned/reference_trajectory.h"

namespace plantloop {
namespace {

int most_rows(const Predictor& predictor, const MoveBlocks& blocks) {
  return 2 * blocks.moves * predictor.inputs() + 2 * (blocks.moves - 1) * predictor.inputs() +
         2 * blocks.horizon() * predictor.signals() + predictor.signals();
}

bool is_limit(double value) { return std::abs(value) < MoveNumbers::no_limit; }

}  // namespace

MoveBlocks MoveBlocks::make(const std::vector<int>& lengths, int horizon) {
  MoveBlocks blocks;
  blocks.moves = static_cast<int>(lengths.size());
  int move = 0, left = lengths.empty() ? 0 : lengths.front();
  for (int j = 0; j < horizon; ++j) {
    if (left == 0 && move + 1 < blocks.moves) left = lengths[static_cast<std::size_t>(++move)];
    blocks.move_at.push_back(move);
    if (left > 0) --left;
  }
  return blocks;
}

MoveSearch::MoveSearch(const Predictor& predictor, const MoveBlocks& blocks, const SearchOptions& options, Room& room)
    : predictor_(predictor),
      blocks_(blocks),
      options_(options),
      horizon_(blocks.horizon()),
      inputs_(predictor.inputs()),
      outputs_(predictor.outputs()),
      signals_count_(predictor.signals()),
      variables_(blocks.moves * predictor.inputs()),
      program_(blocks.moves * predictor.inputs() + predictor.signals(), most_rows(predictor, blocks), room) {
  by_moves_ = room.take(horizon_ * inputs_ * variables_);
  u_ = room.take(horizon_ * inputs_);
  signals_ = room.take(horizon_ * signals_count_);
  slopes_ = room.take(horizon_ * signals_count_ * variables_);
  trial_ = room.take(variables_);
  best_ = room.take(variables_);
  start_ = room.take(variables_);
  was_active_ = room.take(most_rows(predictor, blocks));
  multipliers_ = room.take(horizon_ * signals_count_);
  curvature_ = room.take(variables_ * variables_);
  slope_here_ = room.take(variables_);
  room_ = room.take(predictor.room(horizon_, variables_));
}

bool MoveSearch::is_limited(int s) const { return is_limit(n_->least[s]) || is_limit(n_->most[s]); }

double MoveSearch::scale_of(int s) const {
  if (is_limit(n_->least[s]) && is_limit(n_->most[s]) && n_->most[s] > n_->least[s]) return n_->most[s] - n_->least[s];
  const double limit = is_limit(n_->most[s]) ? n_->most[s] : n_->least[s];
  return std::max(std::abs(limit), 1e-6);
}

// A signal as its limits see it: outputs with the error (4.1).
double MoveSearch::limited(int sample, int signal) const {
  return signals_[sample * signals_count_ + signal] + (signal < outputs_ ? n_->error[signal] : 0);
}

void MoveSearch::inputs_of(const double* v) {
  for (int j = 0; j < horizon_; ++j)
    std::copy_n(v + blocks_.move_at[static_cast<std::size_t>(j)] * inputs_, inputs_, u_ + j * inputs_);
}

MoveSearch::Value MoveSearch::evaluate(const double* v) {
  inputs_of(v);
  predictor_.predict(n_->state, u_, horizon_, with_extras_, signals_, room_);
  Value value;
  for (int j = 0; j < horizon_; ++j) {
    for (int o = 0; o < outputs_; ++o) {
      const double miss = limited(j, o) - n_->target[j * outputs_ + o];
      value.cost += n_->alpha[j * outputs_ + o] * miss * miss;
    }
  }
  for (int i = 0; i < variables_; ++i) {
    const double step = v[i] - (i < inputs_ ? n_->before[i] : v[i - inputs_]);
    value.cost += n_->beta[i] * step * step;
  }
  value.is_finite = std::isfinite(value.cost);
  for (int s = 0; s < signals_count_; ++s) {
    if (!is_limited(s)) continue;
    double excess = 0;
    for (int j = predictor_.dead_samples(s); j < horizon_; ++j) {
      const double at = limited(j, s);
      excess = std::max({excess, at - n_->most[s], n_->least[s] - at});
      value.is_finite = value.is_finite && std::isfinite(at);
    }
    value.excess = std::max(value.excess, excess);
    if (options_.soft) {
      value.penalty += n_->slack_weight * (excess + excess * excess);
    } else {
      value.violation = std::max(value.violation, excess / (feasibility * scale_of(s)));
    }
  }
  return value;
}

void MoveSearch::differentiate() {
  predictor_.sensitivities(u_, horizon_, with_extras_, by_moves_, variables_, slopes_, room_);
}

// All limits of signals in the order of their rows: sample, signal, 1 for the lower and -1 for the upper one. With
// slacks each signal ends with a call for its slack, of sample -1.
template <typename Each>
void MoveSearch::for_each_limit(const Each& each) const {
  for (int s = 0; s < signals_count_; ++s) {
    if (!is_limited(s)) continue;
    for (int j = predictor_.dead_samples(s); j < horizon_; ++j) {
      if (is_limit(n_->least[s])) each(j, s, 1.0);
      if (is_limit(n_->most[s])) each(j, s, -1.0);
    }
    if (slacks_ > 0) each(-1, s, 1.0);
  }
}

// Of the limits of the signals, as they act on each: those of the lower less those of the upper one.
void MoveSearch::take_multipliers() {
  int row = first_signal_row_;
  std::fill_n(multipliers_, horizon_ * signals_count_, 0.0);
  for_each_limit([&](int j, int s, double sign) {
    if (j >= 0) multipliers_[j * signals_count_ + s] += sign * program_.multiplier[row];
    ++row;
  });
}

void MoveSearch::gradient_of_lagrangian(double* gradient) const {
  std::copy_n(program_.g, variables_, gradient);
  for (int k = 0; k < horizon_ * signals_count_; ++k) {
    if (multipliers_[k] == 0) continue;
    for (int i = 0; i < variables_; ++i) gradient[i] -= multipliers_[k] * slopes_[k * variables_ + i];
  }
}

// The Hessian of the Lagrangian at v, less that of Gauss and Newton. The multipliers are those of the last program.
void MoveSearch::curve(const double* v) {
  slacks_ = 0;
  const int n = variables_;
  objective(v);
  gradient_of_lagrangian(slope_here_);
  double* const C = curvature_;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) C[i * n + j] = -program_.H[std::max(i, j) * n + std::min(i, j)];
  }
  double* const moved = trial_;
  double* const slope = program_.x;
  for (int i = 0; i < n; ++i) {
    std::copy_n(v, n, moved);
    const double step = 1e-8 * (1 + std::abs(v[i]));  // small: weak directions hide behind strong ones
    moved[i] += step;
    evaluate(moved);
    differentiate();
    objective(moved);
    gradient_of_lagrangian(slope);
    for (int j = 0; j < n; ++j) {
      const double second = 0.5 * (slope[j] - slope_here_[j]) / step;
      C[i * n + j] += second;
      C[j * n + i] += second;
    }
  }
  is_curved_ = true;
  for (int k = 0; k < n * n; ++k) is_curved_ = is_curved_ && std::isfinite(C[k]);
  evaluate(v);
  differentiate();
}

// H and g of the cost around v, for the signals and slopes as they stand.
void MoveSearch::objective(const double* v) {
  const int n = variables_ + slacks_;
  double* const H = program_.H;
  double* const g = program_.g;
  std::fill_n(H, n * n, 0.0);
  std::fill_n(g, n, 0.0);
  for (int j = 0; j < horizon_; ++j) {
    for (int o = 0; o < outputs_; ++o) {
      const double weight = 2 * n_->alpha[j * outputs_ + o];
      if (weight == 0) continue;
      const double miss = limited(j, o) - n_->target[j * outputs_ + o];
      const double* const slope = slopes_ + (j * signals_count_ + o) * variables_;
      for (int a = 0; a < variables_; ++a) {
        if (slope[a] == 0) continue;
        g[a] += weight * miss * slope[a];
        for (int b = 0; b <= a; ++b) H[a * n + b] += weight * slope[a] * slope[b];
      }
    }
  }
  for (int i = 0; i < variables_; ++i) {
    const double weight = 2 * n_->beta[i];
    const double step = v[i] - (i < inputs_ ? n_->before[i] : v[i - inputs_]);
    g[i] += weight * step;
    H[i * n + i] += weight;
    if (i < inputs_) continue;
    const int earlier = i - inputs_;
    g[earlier] -= weight * step;
    H[earlier * n + earlier] += weight;
    H[i * n + earlier] -= weight;
  }
}

// Limits of the moves and of their changes; the number of rows.
int MoveSearch::input_rows(const double* v, int n) {
  int row = 0;
  const auto add = [&](int i, double factor, int j, double bound) {
    if (!(std::abs(bound) < MoveNumbers::no_limit)) return;
    double* const a = program_.A + row * n;
    std::fill_n(a, n, 0.0);
    a[i] = factor;
    if (j >= 0) a[j] = -factor;
    program_.b[row++] = bound;
  };
  for (int i = 0; i < variables_; ++i) {
    const int input = i % inputs_;
    Span span{n_->lower[input], n_->upper[input]};
    if (i < inputs_) span = reachable(n_->before[input], n_->change[input], span.least, span.most);
    add(i, 1, -1, span.least - v[i]);
    add(i, -1, -1, v[i] - span.most);
    if (i < inputs_ || !is_limit(n_->change[input])) continue;
    const double step = v[i] - v[i - inputs_];
    add(i, 1, i - inputs_, -n_->change[input] - step);
    add(i, -1, i - inputs_, step - n_->change[input]);
  }
  return row;
}

// Limits of the signals, linearised, behind the rows there are; the number of all.
int MoveSearch::signal_rows(int row, int n) {
  int k = variables_;
  for_each_limit([&](int j, int s, double sign) {
    double* const a = program_.A + row * n;
    std::fill_n(a, n, 0.0);
    if (slacks_ > 0) a[k] = 1;
    if (j < 0) {  // the slack itself, >= 0
      program_.b[row++] = 0;
      ++k;
      return;
    }
    const double* const slope = slopes_ + (j * signals_count_ + s) * variables_;
    for (int i = 0; i < variables_; ++i) a[i] = sign * slope[i];
    program_.b[row++] = sign * ((sign > 0 ? n_->least[s] : n_->most[s]) - limited(j, s));
  });
  return row;
}

// Adds stiffness/2 (a x - b)^2 for each limit that was active. Where it is so again this is nothing, but the curvature
// along its normal, which is often negative at an optimum, is gone.
void MoveSearch::stiffen(double stiffness, int n) {
  for (int r = 0; r < rows_; ++r) {
    if (was_active_[r] == 0) continue;
    const double* const a = program_.A + r * n;
    double length = 0;
    for (int i = 0; i < n; ++i) length += a[i] * a[i];
    if (length == 0) continue;
    for (int i = 0; i < n; ++i) {
      if (a[i] == 0) continue;
      const double scaled = stiffness / length * a[i];
      program_.g[i] -= scaled * program_.b[r];
      for (int j = 0; j <= i; ++j) program_.H[i * n + j] += scaled * a[j];
    }
  }
}

// Around v, for the signals and slopes as they stand. With slacks, `weight` is that of hard limits, which are exceeded
// as little as possible then.
QuadraticProgram::Outcome MoveSearch::quadratic(const double* v, bool slack, double weight) {
  slacks_ = 0;
  for (int s = 0; slack && s < signals_count_; ++s) slacks_ += is_limited(s) ? 1 : 0;
  const int n = variables_ + slacks_;
  double damping = 0, curvature = is_curved_ ? 1 : 0, stiffness = 0;
  const int rows_before = rows_, first_row_before = first_signal_row_;
  for (int attempt = 0;; ++attempt) {
    objective(v);
    double greatest = 0;
    for (int i = 0; i < variables_; ++i) greatest = std::max(greatest, program_.H[i * n + i]);
    for (int i = 0; i < variables_; ++i) {
      program_.H[i * n + i] += damping;
      for (int j = 0; j <= i && curvature > 0; ++j) program_.H[i * n + j] += curvature * curvature_[i * variables_ + j];
    }
    for (int s = 0, k = variables_; s < signals_count_ && slack; ++s) {
      if (!is_limited(s)) continue;
      const double of_slack = options_.soft ? n_->slack_weight : weight;
      program_.g[k] = of_slack;
      program_.H[k * n + k] = options_.soft ? 2 * of_slack : 1e-3 * of_slack / scale_of(s);
      ++k;
    }
    first_signal_row_ = input_rows(v, n);
    rows_ = signal_rows(first_signal_row_, n);
    is_known_active_ = is_known_active_ && rows_ == rows_before && first_signal_row_ == first_row_before;
    if (stiffness > 0 && is_known_active_) stiffen(stiffness, n);
    const auto outcome = program_.solve(n, rows_);
    constexpr int most_attempts = 16;
    if (outcome != QuadraticProgram::Outcome::not_convex || attempt == most_attempts) {
      is_known_active_ = outcome == QuadraticProgram::Outcome::solved;
      for (int r = 0; r < rows_ && is_known_active_; ++r) was_active_[r] = program_.multiplier[r] > 0 ? 1 : 0;
      return outcome;
    }
    if (stiffness == 0 && curvature > 0 && is_known_active_) {
      stiffness = 10 * greatest;
    } else if (curvature > 0) {  // as much of it as leaves the program convex
      stiffness = 0;
      curvature = curvature > 0.1 ? curvature / 2 : 0;
      is_known_active_ = false;
    } else {  // moves that the cost does not see stay where they are
      damping = std::max(damping * 100, greatest > 0 ? 1e-10 * greatest : 1.0);
    }
  }
}

bool MoveSearch::is_better(const Value& a, const Value& b) const {
  if (is_feasible(a) != is_feasible(b)) return is_feasible(a);
  return is_feasible(a) ? a.whole() < b.whole() : a.violation < b.violation;
}

void MoveSearch::keep_best(const double* v, const Value& value) {
  if (!value.is_finite || (has_best_ && !is_better(value, best_value_))) return;
  std::copy_n(v, variables_, best_);
  best_value_ = value;
  has_best_ = true;
}

// The nearest moves, one after the other, that keep the limits of the inputs.
void MoveSearch::clip(double* v) const {
  for (int i = 0; i < variables_; ++i) {
    const int input = i % inputs_;
    const double before = i < inputs_ ? n_->before[input] : v[i - inputs_];
    v[i] = reachable(before, n_->change[input], n_->lower[input], n_->upper[input]).nearest(v[i]);
  }
}

bool MoveSearch::is_out_of_time() const {
  if (options_.max_time <= 0) return false;
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - began_).count() > options_.max_time;
}

// From v, whose value is given and whose signals stand; true when an optimum, or the least violation, was found.
bool MoveSearch::search(double* v, Value value) {
  double weight = 0;  // of the violation of hard limits in the merit
  const bool soft = options_.soft;
  bool is_slow = false;
  is_curved_ = false;
  is_known_active_ = false;
  constexpr int quick = 5;
  for (int iteration = 0; iterations_ < options_.max_iterations && !is_out_of_time(); ++iteration) {
    ++iterations_;
    differentiate();
    if (is_slow || iteration >= quick) curve(v);
    auto outcome = quadratic(v, soft, 0);
    bool is_elastic = false;
    if (outcome == QuadraticProgram::Outcome::infeasible) {
      double g = 0, h = 0, size = 1, slope = 0;
      for (int i = 0; i < variables_; ++i) {
        g = std::max(g, std::abs(program_.g[i]));
        h = std::max(h, program_.H[i * (variables_ + slacks_) + i]);
        size = std::max(size, std::abs(v[i]));
      }
      for (int k = 0; k < horizon_ * signals_count_ * variables_; ++k) slope = std::max(slope, std::abs(slopes_[k]));
      const double elastic = std::max(1e4 * (g + h * size) / std::max(slope, 1e-300), 1e-6);
      weight = std::max(weight, elastic);
      outcome = quadratic(v, true, weight);
      is_elastic = true;
    }
    if (outcome != QuadraticProgram::Outcome::solved) return false;
    take_multipliers();

    const int n = variables_ + slacks_;
    double descent = 0, step = 0, size = 1, curved = 0;
    for (int i = 0; i < variables_; ++i) {
      const double d = program_.x[i];
      descent -= program_.g[i] * d;
      for (int j = 0; j < variables_; ++j)
        curved += 0.5 * d * program_.H[std::max(i, j) * n + std::min(i, j)] * program_.x[j];
      step = std::max(step, std::abs(d));
      size = std::max(size, std::abs(v[i]));
    }
    descent -= curved;
    double excess_then = 0;
    for (int k = variables_; k < n; ++k) {
      if (soft) descent -= n_->slack_weight * (program_.x[k] + program_.x[k] * program_.x[k]);
      if (!soft) excess_then = std::max(excess_then, program_.x[k]);
    }
    if (soft) descent += value.penalty;
    if (!soft && !is_elastic) {
      double sum = 0;
      for (int r = first_signal_row_; r < rows_; ++r) sum += program_.multiplier[r];
      weight = std::max(weight, 2 * sum);
    }
    if (!soft) descent += weight * (value.excess - excess_then);
    const double merit = value.whole() + (soft ? 0 : weight * value.excess);
    if (predictor_.is_linear() && step > 0) {  // the program was the problem itself
      for (int i = 0; i < variables_; ++i) v[i] += program_.x[i];
      clip(v);
      keep_best(v, evaluate(v));
      return true;
    }
    if (step <= options_.tolerance * size || descent <= 1e-15 * std::abs(merit)) return true;

    double part = 1;
    constexpr int halvings = 20;
    bool improved = false;
    for (int i = 0; i < halvings && !improved; ++i, part *= 0.5) {
      if (i > 0 && is_out_of_time()) break;
      for (int a = 0; a < variables_; ++a) trial_[a] = v[a] + part * program_.x[a];
      clip(trial_);  // of rounding
      const Value then = evaluate(trial_);
      const double merit_then = then.whole() + (soft ? 0 : weight * then.excess);
      if (!then.is_finite || !(merit_then < merit - 1e-4 * part * descent)) continue;
      improved = true;
      std::copy_n(trial_, variables_, v);
      value = then;
      keep_best(v, value);
    }
    if (improved) continue;
    if (is_out_of_time()) return false;
    if (is_curved_) return descent <= 1e-8 * (std::abs(merit) + 1e-12);
    is_slow = true;
    evaluate(v);
  }
  return false;
}

// Constant inputs between the limits, one input at a time; into v the best of those that are better than the best so
// far.
bool MoveSearch::try_candidates(double* v, Value* value) {
  bool found = false;
  Value reference = best_value_;
  for (int input = 0; input < inputs_; ++input) {
    const double reach = std::max(1.0, std::abs(n_->before[input]));
    const double from = is_limit(n_->lower[input]) ? n_->lower[input] : n_->before[input] - reach;
    const double to = is_limit(n_->upper[input]) ? n_->upper[input] : n_->before[input] + reach;
    for (int c = 0; c < options_.candidates && !is_out_of_time(); ++c) {
      const double level =
          options_.candidates == 1 ? 0.5 * (from + to) : from + (to - from) * c / (options_.candidates - 1);
      std::copy_n(start_, variables_, trial_);
      for (int m = 0; m < blocks_.moves; ++m) trial_[m * inputs_ + input] = level;
      clip(trial_);
      const Value here = evaluate(trial_);
      if (!here.is_finite) continue;
      const bool better = !has_best_ || is_better(here, reference);
      if (!better) continue;
      reference = here;
      keep_best(trial_, here);
      std::copy_n(trial_, variables_, v);
      *value = here;
      found = true;
    }
  }
  return found;
}

void MoveSearch::set_slopes_of_inputs() {
  std::fill_n(by_moves_, horizon_ * inputs_ * variables_, 0.0);
  for (int j = 0; j < horizon_; ++j) {
    for (int i = 0; i < inputs_; ++i)
      by_moves_[(j * inputs_ + i) * variables_ + blocks_.move_at[static_cast<std::size_t>(j)] * inputs_ + i] = 1;
  }
}

MoveSearch::Result MoveSearch::solve(const MoveNumbers& numbers, double* plan) {
  n_ = &numbers;
  with_extras_ = false;
  for (int s = outputs_; s < signals_count_; ++s) with_extras_ = with_extras_ || is_limited(s);
  set_slopes_of_inputs();
  has_best_ = false;
  iterations_ = 0;
  if (options_.max_time > 0) began_ = std::chrono::steady_clock::now();
  clip(plan);
  std::copy_n(plan, variables_, start_);
  bool converged = false;
  Value value = evaluate(plan);
  keep_best(plan, value);
  if (value.is_finite) converged = search(plan, value);
  if (!predictor_.is_linear() && options_.candidates > 0) {
    const bool had_best = has_best_;
    if (try_candidates(plan, &value)) {
      value = evaluate(plan);
      converged = search(plan, value) || (had_best && converged);
    }
  }
  Result result;
  result.iterations = iterations_;
  std::copy_n(has_best_ ? best_ : start_, variables_, plan);
  if (!has_best_) return result;
  result.cost = best_value_.cost;
  result.excess = best_value_.excess;
  result.status = !is_feasible(best_value_)                  ? infeasible
                  : !converged                               ? used_up
                  : options_.soft && best_value_.penalty > 0 ? soft_exceeded
                                                             : solved;
  return result;
}

const double* MoveSearch::signals(const double* plan) {
  inputs_of(plan);
  predictor_.predict(n_->state, u_, horizon_, true, signals_, room_);
  return signals_;
}

double MoveSearch::cost_and_gradient(const MoveNumbers& numbers, const double* plan, double* gradient) {
  n_ = &numbers;
  with_extras_ = false;
  set_slopes_of_inputs();
  const Value value = evaluate(plan);
  differentiate();
  slacks_ = 0;
  objective(plan);
  std::copy_n(program_.g, variables_, gradient);
  return value.cost;
}

}  // namespace plantloop
