// The list of solvers, and which class stands behind each name.

#include "engine/solve/integrator.h"

#include <fmt/format.h>

#include <stdexcept>

#include "engine/solve/adaptive.h"
#include "engine/solve/cvode.h"
#include "engine/solve/fixed_step.h"
#include "engine/solve/ida.h"
#include "engine/solve/tableau.h"

namespace plantloop {

const std::vector<SolverInfo>& solvers() {
  static const std::vector<SolverInfo> list = [] {
    std::vector<SolverInfo> all;
    for (const Tableau& tableau : tableaus()) {
      all.push_back({tableau.name, tableau.summary, tableau.order, true, tableau.adaptive()});
    }
    const std::vector<SolverInfo>& more = cvode_solvers();
    all.insert(all.end(), more.begin(), more.end());
    all.push_back(ida_solver());
    return all;
  }();
  return list;
}

std::unique_ptr<Integrator> make_integrator(OdeSystem& system, const SolverOptions& options) {
  if (const Tableau* tableau = find_tableau(options.solver)) {
    if (options.step > 0) return std::make_unique<FixedStep>(system, *tableau, options);
    if (tableau->adaptive()) return std::make_unique<Adaptive>(system, *tableau, options);
    throw std::invalid_argument(fmt::format("solver '{}' needs a step", options.solver));
  }
  if (options.solver == ida_solver().name) return make_ida(system, options);
  return make_cvode(system, options);
}

}  // namespace plantloop
