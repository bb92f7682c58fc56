// How fast the equations themselves move, at one point of a run.

#pragma once

#include "engine/run/frame.h"

namespace plantloop {

// An estimate (1/s) of the greatest absolute eigenvalue of the derivatives' Jacobian at the frame's states and time: by
// power iteration with differences of the derivatives, measured against atol + rtol |x|. 0 when they are not finite.
double fastest_eigenvalue(const Frame& frame, double rtol, double atol);

}  // namespace plantloop
