// Velocity-based linearisations of one nonlinear system (D. J. Leith and W. E. Leithead 1998): at each point the linear
// model of the derivatives of its signals, which needs no rest to be linearised at.

#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "identify/data/data_set.h"
#include "identify/model_file/item.h"

namespace plantloop::identify {

// w = x':  w' = A w + B u',  y' = C w + D u'. Of a sampled system: w(t + Ts) = A w(t) + B u'(t), y' as before.
struct VelocityPoint {
  double at = 0;               // of the scheduling variable
  Eigen::MatrixXd A, B, C, D;  // n x n, n x inputs, outputs x n, outputs x inputs
  Eigen::VectorXd x, u, y;     // where it was linearised
};

struct VelocityFamily {
  double Ts = 0;           // s, sampling time of the system; 0: continuous
  std::string scheduling;  // what `at` is the value of
  std::vector<std::string> states;
  std::vector<Channel> inputs, outputs;
  std::vector<VelocityPoint> points;  // ascending by `at`
};

// The model file of type velocity_family, and back. Raises IdentifyError: sizes that differ, points not ascending.
Item to_item(const VelocityFamily& family);
VelocityFamily velocity_family_of(const Item& item);
// The whole file.
std::string to_yaml(const VelocityFamily& family);

}  // namespace plantloop::identify
