// Linear controllers designed at points of one nonlinear system, to be blended along a scheduling variable.

#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "identify/model_file/item.h"

namespace plantloop::identify {

// u = kp e + ki (integral of e) + kd e' - K x, with what is 0 left out.
struct ControllerPoint {
  double at = 0;                  // of the scheduling variable
  double kp = 0, ki = 0, kd = 0;  // 1, 1/s, s, in units of u per unit of e
  Eigen::VectorXd K;              // of each state; empty: the states are not fed back
};

struct ControllerFamily {
  std::string scheduling;               // what `at` is the value of
  std::vector<std::string> states;      // that K belongs to
  std::vector<ControllerPoint> points;  // ascending by `at`
};

// The model file of type controller_family, and back. Raises IdentifyError: sizes that differ, points not ascending.
Item to_item(const ControllerFamily& family);
ControllerFamily controller_family_of(const Item& item);
// The whole file.
std::string to_yaml(const ControllerFamily& family);

}  // namespace plantloop::identify
