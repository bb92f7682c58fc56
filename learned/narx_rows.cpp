// Products of lagged signals by their places.

#include "learned/narx_rows.h"

#include <algorithm>

namespace plantloop {
namespace {

double power(double value, int exponent) {
  double result = 1;
  for (int i = 0; i < exponent; ++i) result *= value;
  return result;
}

}  // namespace

NarxRows::NarxRows(const identify::RegressorSet& set) {
  const auto inputs = static_cast<int>(set.inputs.size()), outputs = static_cast<int>(set.outputs.size());
  for (const identify::Regressor& regressor : set.list) {
    std::vector<Place>& product = products_.emplace_back();
    for (const identify::Factor& factor : regressor.factors) {
      const int width = factor.of_output ? outputs : inputs;
      product.push_back({factor.of_output, factor.channel - (factor.lag - 1) * width, factor.power});
      int& past = factor.of_output ? past_outputs_ : past_inputs_;
      past = std::max(past, factor.lag);
      if (!factor.of_output && (shortest_input_ == 0 || factor.lag < shortest_input_)) shortest_input_ = factor.lag;
    }
  }
  if (shortest_input_ == 0) shortest_input_ = past_inputs_;
}

void NarxRows::row(const double* u, const double* y, double* x) const {
  for (const std::vector<Place>& product : products_) {
    double value = 1;
    for (const Place& p : product) value *= power((p.of_output ? y : u)[p.offset], p.power);
    *x++ = value;
  }
}

void NarxRows::add_slope(int r, double weight, const double* u, const double* y, const double* by_u, const double* by_y,
                         int variables, double* result) const {
  const std::vector<Place>& product = products_[static_cast<std::size_t>(r)];
  for (const Place& one : product) {
    double rest = weight * one.power * power((one.of_output ? y : u)[one.offset], one.power - 1);
    for (const Place& other : product) {
      if (&other != &one) rest *= power((other.of_output ? y : u)[other.offset], other.power);
    }
    const double* const by = (one.of_output ? by_y : by_u) + one.offset * variables;
    for (int v = 0; v < variables; ++v) result[v] += rest * by[v];
  }
}

}  // namespace plantloop
