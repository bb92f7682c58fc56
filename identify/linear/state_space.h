// Linear models of any number of inputs and outputs in state space: x(k+1) = A x + B u, y = C x + D u.

#pragma once

#include <Eigen/Core>
#include <limits>
#include <vector>

#include "identify/data/data_set.h"
#include "identify/fit_report.h"
#include "identify/linear/polynomial_model.h"

namespace plantloop::identify {

struct StateSpaceModel {
  std::vector<Channel> inputs, outputs;
  double Ts = 1;                    // s
  Eigen::MatrixXd A, B, C, D;       // n x n, n x inputs, outputs x n, outputs x inputs
  Eigen::VectorXd u0, y0;           // operating point: the model is of u - u0 and y - y0
  std::vector<Eigen::VectorXd> x0;  // the first state of each experiment of the data it was made of
  Eigen::VectorXd singular_values;  // of the projection of outputs of size 1, from which the order was read
  FitReport fit;

  Eigen::Index order() const { return A.rows(); }
  Eigen::VectorXcd poles() const;
  bool is_stable() const;
};

struct SubspaceOptions {
  int order = 0;              // 0: where the ratio of neighbouring singular values is greatest
  int highest = 10;           // order that is chosen from, with order = 0
  int block_rows = 10;        // i, of the Hankel matrices; greater than the order
  bool remove_means = false;  // fit deviations from the means of the data, which become the operating point
  bool offset = false;        // estimate the outputs' operating point y0 with B, D and the first states
  bool feedthrough = true;    // whether D is estimated; else it is 0
};

// The subspace method PO-MOESP (M. Verhaegen 1994): LQ decomposition of [Uf; Up; Yp; Yf], the singular values of the
// part of Yf that the past explains, A and C from the shift invariance of the observability matrix, B, D and x0 by
// least squares of the simulated response. With an offset the projection also takes constants out, so that they do not
// bias A and C. A delay of d samples appears as d further states. Raises IdentifyError.
StateSpaceModel fit_subspace(const DataSet& data, const SubspaceOptions& options = {}, const FitControl& control = {});

// The observer companion form of a polynomial model's free run (its noise is left out). Exact. An offset becomes part
// of y0; where the model integrates, of u0 of the first input that can make up for it. Raises IdentifyError when none
// can.
StateSpaceModel to_state_space(const PolynomialModel& model);

// The state in which each input at 1 leaves the model at rest, (I - A)^-1 B: n x inputs; infinite when it integrates.
Eigen::MatrixXd states_at_rest(const StateSpaceModel& model);

enum class StateStart {
  zero,       // from rest at the operating point
  estimated,  // from the state that fits the measured outputs of the experiment best, in least squares
};
// Free run: samples x outputs of each experiment. `samples`: how many of them an estimated start may use, the first
// ones.
std::vector<Eigen::MatrixXd> simulate(const StateSpaceModel& model, const DataSet& data,
                                      StateStart start = StateStart::estimated,
                                      Eigen::Index samples = std::numeric_limits<Eigen::Index>::max());

Item to_item(const StateSpaceModel& model);
StateSpaceModel state_space_of(const Item& item);

}  // namespace plantloop::identify
