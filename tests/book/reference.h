// An integrator that shares nothing with the engine: the fourth-order method of Kutta, each step done once whole and
// once in halves, whose difference rules the step size and is extrapolated. Slow, simple, and accurate.

#pragma once

#include <functional>
#include <vector>

namespace plantloop::testing_book {

using State = std::vector<long double>;
using RightSide = std::function<State(long double time, const State& state)>;

// The state at the end, from `state` at the start; f must be smooth in between. The error of each step stays below
// `tolerance` times the greater of 1 and the element's magnitude.
State integrate(const RightSide& f, State state, double start, double end, long double tolerance = 1e-14L);

// The state at each of `times` (ascending), with a restart at each of `edges`, where f may jump. `f` gets the index of
// the last edge passed, -1 before the first one.
using PiecewiseRightSide = std::function<State(int edge, const State& state)>;
std::vector<State> integrate_pieces(const PiecewiseRightSide& f, State state, double start,
                                    const std::vector<double>& edges, const std::vector<double>& times);

}  // namespace plantloop::testing_book
