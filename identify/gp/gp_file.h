// Gaussian processes in model files.

#pragma once

#include <memory>

#include "identify/gp/posterior.h"

namespace plantloop::identify {

// What all processes say of themselves: covariance, mean, hyperparameters.
void write_process(const GpPosterior& process, Item& entry);
// The process of an entry that GpPosterior::write made. Raises IdentifyError with the place.
std::shared_ptr<const GpPosterior> read_process(const Item& entry);

inline constexpr const char* slopes_need_zero_mean =
    "observations of slopes need the mean zero; '+ linear' in the covariance stands for a linear one";

}  // namespace plantloop::identify
