// Forward sensitivities: how everything that a diagram computes moves with some of its parameters, as operations beside
// its own. With x' = f(x, p) also S' = f_x S + f_p runs, S = dx/dp; sampled states likewise, hit by hit.

#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "engine/program/program.h"

namespace plantloop {

struct SensitivityRequest {
  struct Parameter {
    std::uint32_t index;  // into Record::parameters
    double scale = 1;     // what is computed is the derivative times this, so that it compares with the states
  };
  std::vector<Parameter> parameters;
};

// What the derivatives leave out: the result is exact while `missing` is empty and no function of `moving_guards` has
// an event.
struct SensitivityLimits {
  std::vector<std::string> missing;        // "the derivative of block 'd' is not known", sorted
  std::vector<std::string> moving_guards;  // events whose time moves with a parameter, by name, sorted
};

// The Program of the diagram with its sensitivities. Watches: first those of the options, then for each parameter the
// derivatives of all of them. States and discrete states likewise. Null after reporting, as compile() does.
std::shared_ptr<const Program> compile_with_sensitivities(const Record& record, const CompileOptions& options,
                                                          const SensitivityRequest& request, SensitivityLimits& limits,
                                                          Report& report);

// The parts of it: the record with room for the states, and what they do.
Record with_sensitivity_states(const Record& record, const SensitivityRequest& request);
void add_sensitivities(struct Resolved& resolved, const Record& record, std::size_t states, std::size_t discretes,
                       const SensitivityRequest& request, SensitivityLimits& limits);

}  // namespace plantloop
