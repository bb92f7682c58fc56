// Signals that do not vary, and inputs that follow each other.

#include "identify/data/undetermined.h"

#include <algorithm>
#include <cmath>

#include "identify/error.h"

namespace plantloop::identify {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

std::vector<std::string> undetermined(const DataSet& data) {
  std::vector<std::string> list;
  const auto look = [&](const MatrixXd& values, const std::vector<Channel>& channels) {
    for (Index c = 0; c < values.cols(); ++c) {
      double least = HUGE_VAL, greatest = -HUGE_VAL;
      for (const double v : values.col(c)) {
        if (std::isnan(v)) continue;
        least = std::min(least, v);
        greatest = std::max(greatest, v);
      }
      if (!(least < greatest))
        list.push_back(fmt::format("'{}' does not vary", channels[static_cast<std::size_t>(c)].name));
    }
  };
  const MatrixXd u = data.all_u();
  look(u, data.inputs);
  look(data.all_y(), data.outputs);
  for (Index a = 0; a < u.cols(); ++a) {
    for (Index b = a + 1; b < u.cols(); ++b) {
      // Equal but for scale and offset, to rounding.
      const VectorXd p = u.col(a).array() - u.col(a).mean(), q = u.col(b).array() - u.col(b).mean();
      const double product = p.stableNorm() * q.stableNorm();
      if (product > 0 && std::fabs(p.dot(q)) > (1 - 1e-12) * product)
        list.push_back(fmt::format("'{}' and '{}' carry the same signal: their effects cannot be told apart",
                                   data.inputs[static_cast<std::size_t>(a)].name,
                                   data.inputs[static_cast<std::size_t>(b)].name));
    }
  }
  return list;
}

}  // namespace plantloop::identify
