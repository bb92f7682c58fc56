// The door to SUNDIALS: IDA behind the Integrator interface, for diagrams with algebraic loops and constraints.

#pragma once

#include "engine/solve/integrator.h"

namespace plantloop {

const SolverInfo& ida_solver();

// Throws std::invalid_argument when a fixed step is asked for.
std::unique_ptr<Integrator> make_ida(OdeSystem& system, const SolverOptions& options);

}  // namespace plantloop
