// The door to SUNDIALS: CVODE's Adams and BDF methods behind the Integrator interface.

#pragma once

#include "engine/solve/integrator.h"

namespace plantloop {

const std::vector<SolverInfo>& cvode_solvers();

// Throws std::invalid_argument for a name that cvode_solvers() does not list.
std::unique_ptr<Integrator> make_cvode(OdeSystem& system, const SolverOptions& options);

}  // namespace plantloop
