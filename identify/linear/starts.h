// Where searches for linear models begin.

#pragma once

#include <string>
#include <vector>

#include "identify/linear/fit_linear.h"

namespace plantloop::identify {

// The same without roots of C and F outside of the unit circle: those are mirrored.
PolynomialModel mirrored(PolynomialModel model);

struct StartModel {
  std::string name;
  PolynomialModel model;
};
// Estimates that cost little and fail in different places. `empty`: the task's model without values.
std::vector<StartModel> starts_of(const LinearTask& task, const LinearOptions& options, const PolynomialModel& empty,
                                  const FitControl& control);

}  // namespace plantloop::identify
