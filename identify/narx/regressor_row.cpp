// Products of lagged signals, and their derivatives factor by factor.

#include "identify/narx/regressor_row.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

double power(double base, int exponent) {
  double result = 1;
  for (int i = 0; i < exponent; ++i) result *= base;
  return result;
}

double value_of(const Factor& factor, const MatrixXd& u, const MatrixXd& y, Index k) {
  return (factor.of_output ? y : u)(k - factor.lag, factor.channel);
}

}  // namespace

void fill_row(const RegressorSet& set, const MatrixXd& u, const MatrixXd& y, Index k, double* x) {
  for (const Regressor& regressor : set.list) {
    double product = 1;
    for (const Factor& factor : regressor.factors) product *= power(value_of(factor, u, y, k), factor.power);
    *x++ = product;
  }
}

void row_slopes(const RegressorSet& set, const MatrixXd& u, const MatrixXd& y, Index k, std::vector<RowSlope>& slopes) {
  slopes.clear();
  for (std::size_t r = 0; r < set.list.size(); ++r) {
    const std::vector<Factor>& factors = set.list[r].factors;
    for (const Factor& by : factors) {
      const bool of_error = set.is_error(by);
      if (!by.of_output && !of_error) continue;
      double value = by.power * power(value_of(by, u, y, k), by.power - 1);
      for (const Factor& other : factors) {
        if (&other != &by) value *= power(value_of(other, u, y, k), other.power);
      }
      slopes.push_back(
          {static_cast<Index>(r), of_error ? by.channel - set.data_inputs() : by.channel, by.lag, value, of_error});
    }
  }
}

}  // namespace plantloop::identify
