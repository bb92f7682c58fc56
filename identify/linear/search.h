// The prediction error method for models that are not linear in their parameters.

#pragma once

#include "identify/linear/fit_linear.h"

namespace plantloop::identify {

PolynomialModel search_linear(const LinearTask& task, const LinearOptions& options, const FitControl& control);

}  // namespace plantloop::identify
