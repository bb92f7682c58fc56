// Linear ways to move a state, with which the fit of a neural state-space model begins.

#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "identify/data/data_set.h"

namespace plantloop::identify {

// x(k+1) = A x + B u in the basis in which the mean square of its states over the data is the unit matrix.
struct Beginning {
  std::string what;
  Eigen::MatrixXd A, B;
  std::vector<Eigen::VectorXd> x0;  // of each experiment
  Eigen::MatrixXd states;           // samples of all experiments x order
};

// By the subspace method, of output error models, and of chains of equal lags with several time constants. The data
// are normalised and have no missing values; what some of the methods do not allow is left out. Raises IdentifyError
// when nothing is left.
std::vector<Beginning> beginnings(const DataSet& data, int order);

// What the outputs grow by until the next sample; the last one grows as the one before it.
DataSet increments(DataSet data);

// The rows at which the first state of their experiment has decayed to a tenth, or two thirds of them.
std::vector<Eigen::Index> settled_rows(const DataSet& data, const Eigen::MatrixXd& A);

}  // namespace plantloop::identify
