// Quantiles of the distributions that confidence intervals are made with.

#pragma once

namespace plantloop {

// P(|T| <= t) for Student's distribution with `degrees` degrees of freedom.
double student_within(double t, double degrees);
// The t with P(|T| <= t) = p, 0 < p < 1: 12.706 for 0.95 and one degree of freedom; infinite without any.
double student_quantile(double p, double degrees);

}  // namespace plantloop
