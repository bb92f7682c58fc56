// Quantiles of the distributions that confidence intervals are made with.

#pragma once

namespace plantloop {

// The t >= 0 with P(|T| <= t) = p, 0 < p < 1, of Student's distribution with `degrees` degrees of freedom: 12.706 for
// 0.95 and one of them; infinite without any.
double student_quantile(double p, double degrees);

}  // namespace plantloop
