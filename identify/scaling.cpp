// Normalisations from data and from model files.

#include "identify/scaling.h"

#include <fmt/format.h>

#include <cmath>

namespace plantloop::identify {

using Eigen::Index;
using Eigen::VectorXd;

Scaling no_scaling(Index columns) { return {VectorXd::Zero(columns), VectorXd::Ones(columns)}; }

Scaling standard_scaling(const Eigen::MatrixXd& x) {
  Scaling result = no_scaling(x.cols());
  for (Index c = 0; c < x.cols(); ++c) {
    result.offset[c] = x.col(c).mean();
    const double deviation = std::sqrt((x.col(c).array() - result.offset[c]).square().mean());
    // What rounding makes of a constant column is no deviation.
    if (deviation > 1e-13 * std::fabs(result.offset[c])) {
      result.scale[c] = deviation;
    } else {
      result.offset[c] = x.col(c).minCoeff();
    }
  }
  return result;
}

Scaling range_scaling(const Eigen::MatrixXd& x) {
  Scaling result = no_scaling(x.cols());
  for (Index c = 0; c < x.cols(); ++c) {
    result.offset[c] = x.col(c).minCoeff();
    const double range = x.col(c).maxCoeff() - result.offset[c];
    if (range > 0) result.scale[c] = range;
  }
  return result;
}

void write_scaling(Item& item, const std::string& key, const Scaling& scaling) {
  item.set(key, Item().set("offset", scaling.offset).set("scale", scaling.scale));
}

Scaling read_scaling(const Item& item, const std::string& key, Index columns) {
  if (!item.has(key)) return no_scaling(columns);
  const Item& section = item.at(key);
  section.only({"offset", "scale"});
  Scaling result{section.vector("offset", columns), section.vector("scale", columns)};
  if (!result.offset.allFinite() || !result.scale.allFinite() || !(result.scale.array() > 0).all())
    section.wrong("offsets must be finite and scales greater than 0");
  return result;
}

}  // namespace plantloop::identify
