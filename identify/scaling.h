// A normalisation that remembers itself: z = (x - offset)/scale, column by column.

#pragma once

#include <Eigen/Core>

#include "identify/model_file/item.h"

namespace plantloop::identify {

struct Scaling {
  Eigen::VectorXd offset, scale;  // all scales greater than 0

  Eigen::Index size() const { return offset.size(); }
  Eigen::MatrixXd normalised(const Eigen::MatrixXd& x) const {
    return (x.rowwise() - offset.transpose()) * scale.cwiseInverse().asDiagonal();
  }
  Eigen::MatrixXd original(const Eigen::MatrixXd& z) const {
    return (z * scale.asDiagonal()).rowwise() + offset.transpose();
  }
};

// Leaves numbers as they are.
Scaling no_scaling(Eigen::Index columns);
// To mean 0 and standard deviation 1; to the range from 0 to 1. A constant column is only moved.
Scaling standard_scaling(const Eigen::MatrixXd& x);
Scaling range_scaling(const Eigen::MatrixXd& x);

// The mapping `{offset: [...], scale: [...]}` of a model file under the key, and back; a missing key is no scaling.
// Raises IdentifyError.
void write_scaling(Item& item, const std::string& key, const Scaling& scaling);
Scaling read_scaling(const Item& item, const std::string& key, Eigen::Index columns);

}  // namespace plantloop::identify
