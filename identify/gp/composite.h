// Sums and products of covariances.

#pragma once

#include <memory>
#include <vector>

#include "identify/gp/covariance.h"

namespace plantloop::identify {

// The hyperparameters of the parts, one part after the other, each name preceded by the number of its part: "1.v1",
// "2.v1".
std::shared_ptr<const Covariance> make_sum(std::vector<std::shared_ptr<const Covariance>> parts);
std::shared_ptr<const Covariance> make_product(std::vector<std::shared_ptr<const Covariance>> parts);

}  // namespace plantloop::identify
