// Student's distribution, from Boost.Math.

#include "engine/analysis/quantiles.h"

#include <boost/math/distributions/students_t.hpp>
#include <limits>

namespace plantloop {

double student_quantile(double p, double degrees) {
  if (!(degrees > 0)) return std::numeric_limits<double>::infinity();
  return boost::math::quantile(boost::math::students_t(degrees), 0.5 + 0.5 * p);
}

}  // namespace plantloop
