// What predictive controllers have in common: where the reference goes, and how far an input can go.

#pragma once

#include <algorithm>
#include <cmath>

namespace plantloop {

// w(k+h) - lambda^h (w(k) - base): h samples ahead, from `base` towards the set point.
inline double reference_at(int h, double set_point_then, double set_point_now, double lambda, double base) {
  return set_point_then - std::pow(lambda, h) * (set_point_now - base);
}

// The reference's own state at the next sample, r(k+1) = w - lambda (w - r).
inline double next_reference(double set_point, double lambda, double reference) {
  return set_point - lambda * (set_point - reference);
}

// Where an input may be one sample after `before`: the limits count more than the greatest change.
struct Span {
  double least, most;
  double nearest(double value) const { return std::clamp(value, least, most); }
};
inline Span reachable(double before, double change, double lower, double upper) {
  return {std::min(std::max(lower, before - change), upper), std::max(std::min(upper, before + change), lower)};
}

}  // namespace plantloop
