// Functions of the distance from a centre.

#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace plantloop::identify {

// With r^2 = sum_j ((x_j - c_j)/rho_j)^2:
//   gaussian exp(-r^2/2), (1.9) of the book   gaussian_list exp(-r^2), its list   logistic 1/(1 + exp(r^2))
//   linear r   quadratic r^2   thin_plate r^2 log r (0 at r = 0)   multiquadric sqrt(r^2 + 1)
// The last four grow without bound.
enum class Radial { gaussian, gaussian_list, logistic, linear, quadratic, thin_plate, multiquadric };
Radial find_radial(std::string_view name);  // raises IdentifyError
std::string name_of(Radial radial);
std::vector<std::string> radial_names();
bool is_bounded(Radial radial);

// The value at s = r^2, and its derivative by s (0 where it has none).
double radial_value(Radial radial, double s);
double radial_slope(Radial radial, double s, double value);

}  // namespace plantloop::identify
