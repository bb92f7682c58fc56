// The prediction error of a linear model, its derivative by the parameters, and what the unknown past adds to it.
//
//   v = (D/C) s,     s = A y - sum_i w_i - offset - free,      w_i = q^-d_i (B_i/F_i) u_i
//
// with filters from rest. `free` is what the past before the record leaves in the process: from the first sample that
// knows all of y and u that it looks back to, response of 1/(F_1 F_2 ...) to as many impulses as its order.
//   dv/da_i = (D/C) y(k-i)     dv/db_i = -(D/(C F)) u(k-d-i)    dv/df_i = (D/(C F)) (w + free)(k-i)
//   dv/dc_i = -(1/C) v(k-i)    dv/dd_i = (1/C) s(k-i)           dv/doffset = -(D/C) 1

#pragma once

#include "identify/linear/polynomial_model.h"

namespace plantloop::identify {

// The first sample of a record, from 0, whose error is not a matter of values before the record alone.
Eigen::Index first_determined(const PolynomialModel& model);
// How many values of a record's past are estimated: those of `free`, and as many errors as are left out.
Eigen::Index values_of_the_past(const PolynomialModel& model, Eigen::Index samples);

// v of one experiment whose signals are about the operating point (u - u0, y - y0; `output` is the column of y), and in
// `jacobian`, when given, samples x parameters.
//
// At rest, free = 0 and the output was at the offset's level. Of an estimated past, errors before the first determined
// one are 0, the noise before it is its mean, 0, and free is the one with the least sum of v^2. It is eliminated (G.
// Golub and V. Pereyra 1973), and the Jacobian is what of the derivative no other free response can make good, so that
// J'v is the exact gradient of the least sum, and J'J what is left of the whole problem's when free is eliminated (L.
// Kaufman 1975). Samples without v do not count.
Eigen::VectorXd errors_of(const PolynomialModel& model, const Experiment& experiment, std::size_t output,
                          Initial initial, Eigen::MatrixXd* jacobian);

}  // namespace plantloop::identify
