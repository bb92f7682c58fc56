// The numbers of one sample from the kernel's inputs, and what follows from its solution.

#include "control/predictive_control.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "learned/reference_trajectory.h"

namespace plantloop {

PredictiveControlKernel::PredictiveControlKernel(std::shared_ptr<const Predictor> predictor, PredictiveControl how)
    : predictor_(std::move(predictor)), how_(std::move(how)), blocks_(MoveBlocks::make(how_.blocks, how_.horizon)) {}

std::vector<std::string> PredictiveControlKernel::status_words() const {
  return {"optimum found", "optimum found with a soft limit exceeded", "iterations or time used up",
          "limits that no input keeps", "no prediction"};
}

struct PredictiveControlKernel::Work {
  Work(const PredictiveControlKernel& k, double* scratch)
      : room(scratch), search(*k.predictor_, k.blocks_, k.how_.search, room) {
    const Predictor& p = *k.predictor_;
    state = room.take(p.prediction_size());
    error = room.take(p.outputs());
    target = room.take(k.how_.horizon * p.outputs());
    alpha = room.take(k.how_.horizon * p.outputs());
    most = room.take(p.signals());
    model = room.take(p.room(k.how_.horizon, 0));
  }
  Room room;
  MoveSearch search;
  double *state, *error, *target, *alpha, *most, *model;
};

int PredictiveControlKernel::scratch_size() const { return static_cast<int>(Work(*this, nullptr).room.taken()); }

void PredictiveControlKernel::evaluate(const KernelCall& call) const {
  Work work(*this, call.scratch);
  const Predictor& p = *predictor_;
  const int horizon = how_.horizon, outputs = p.outputs(), inputs = p.inputs();
  const double* in = call.in;
  const auto take = [&](int count) { return std::exchange(in, in + count); };
  const double* const w = take((how_.knows_set_points ? horizon + 1 : 1) * outputs);
  const double* const y = take(outputs);
  const double* const measured = take(how_.measures_state ? p.state_size() : 0);
  MoveNumbers numbers{};
  numbers.lower = take(inputs);
  numbers.upper = take(inputs);
  numbers.change = take(inputs);
  const double* const alpha = take((horizon - how_.first + 1) * outputs);
  numbers.beta = take(variables());
  numbers.least = take(p.signals());
  const double* const most = take(p.signals());
  numbers.slack_weight = *take(1);
  const double lambda = *take(1);
  const double* const reference = take(outputs);
  numbers.before = take(inputs);
  const double* const plan = take(variables());
  const double* const in_parallel = take(p.state_size());

  std::copy_n(how_.measures_state ? measured : in_parallel, p.state_size(), work.state);
  // What the measured state misses of the last prediction goes on to be missed.
  if (!p.is_made_of_outputs()) {
    for (int i = 0; i < p.state_size(); ++i)
      work.state[p.state_size() + i] = how_.measures_state && how_.correction ? measured[i] - in_parallel[i] : 0;
  }
  if (!how_.correction) p.measure(y, work.state);
  p.output(work.state, work.error, work.model);
  for (int o = 0; o < outputs; ++o) work.error[o] = how_.correction ? y[o] - work.error[o] : 0;
  std::fill_n(work.alpha, horizon * outputs, 0.0);
  std::copy_n(alpha, (horizon - how_.first + 1) * outputs, work.alpha + (how_.first - 1) * outputs);
  for (int j = 0; j < horizon; ++j) {
    for (int o = 0; o < outputs; ++o) {
      const double then = how_.knows_set_points ? w[(j + 1) * outputs + o] : w[o];
      work.target[j * outputs + o] = reference_at(j + 1, then, w[o], lambda, how_.from_reference ? reference[o] : y[o]);
    }
  }
  numbers.state = work.state;
  numbers.error = work.error;
  numbers.target = work.target;
  numbers.alpha = work.alpha;
  // A limit counts as kept within a tolerance; a variance shall never exceed its own.
  for (int i = 0; i < p.signals(); ++i)
    work.most[i] = p.has_variances() && i >= outputs ? most[i] * (1 - 2 * MoveSearch::feasibility) : most[i];
  numbers.most = work.most;

  // The moves of the sample before, seen from this one.
  double* const moves = call.out + at_moves();
  for (int j = horizon - 1; j >= 0; --j) {
    const int now = blocks_.move_at[static_cast<std::size_t>(j)];
    const int then = blocks_.move_at[static_cast<std::size_t>(std::min(j + 1, horizon - 1))];
    std::copy_n(plan + then * inputs, inputs, moves + now * inputs);
  }
  const MoveSearch::Result found = work.search.solve(numbers, moves);
  std::copy_n(moves, inputs, call.out);
  call.out[at(status)] = found.status;
  call.out[at(cost)] = found.cost;
  call.out[at(excess)] = found.excess;
  call.out[at(iterations)] = found.iterations;
  double* const deviation = call.out + at_deviation();
  std::fill_n(deviation, outputs, 0.0);
  if (p.has_variances()) {
    const double* const last = work.search.signals(moves) + (horizon - 1) * p.signals();
    for (int o = 0; o < outputs; ++o) deviation[o] = std::sqrt(std::max(last[outputs + o], 0.0));
  }
  for (int o = 0; o < outputs; ++o) call.out[at_reference() + o] = next_reference(w[o], lambda, reference[o]);
  p.advance(work.state, call.out, call.out + at_state(), work.model);
}

}  // namespace plantloop
