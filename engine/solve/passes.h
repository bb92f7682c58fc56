// Single passes over the state, each doing all that one stage of a method needs.
//
// Sums go from left to right for every width, so the bits of a result do not depend on the path taken.

#pragma once

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include "engine/base/vectors.h"

namespace plantloop {

// Below this width loops stay scalar: derivatives are then stored one by one, and a vector load over fresh scalar
// stores stalls longer than the whole pass takes.
inline constexpr std::size_t narrow_width = 16;

#if defined(__clang__)
#define PLANTLOOP_INDEPENDENT _Pragma("clang loop vectorize(assume_safety)")
#else
#define PLANTLOOP_INDEPENDENT _Pragma("GCC ivdep")
#endif

template <typename Body>
PLANTLOOP_WIDE void for_each_wide(std::size_t n, Body body) {
  PLANTLOOP_INDEPENDENT
  for (std::size_t i = 0; i < n; ++i) body(i);
}

// body(i) for i = 0 ... n - 1, which do not depend on each other.
template <typename Body>
inline void for_each_state(std::size_t n, Body body) {
  if (n < narrow_width) {
    for (std::size_t i = 0; i < n; ++i) {
      body(i);
      asm volatile("" ::: "memory");  // no instruction; keeps the compiler from joining neighbours into vectors
    }
    return;
  }
  if (has_wide_vectors) {
    for_each_wide(n, body);
    return;
  }
  PLANTLOOP_INDEPENDENT
  for (std::size_t i = 0; i < n; ++i) body(i);
}

// A linear combination of derivatives: weights and where they stand.
inline constexpr std::size_t most_terms = 8;
struct Terms {
  std::size_t count = 0;
  std::array<const double*, most_terms> k{};
  std::array<double, most_terms> weight{};
  void add(const double* derivative, double w) {
    k[count] = derivative;
    weight[count++] = w;
  }
};

// Calls body(sum) for one term or more, with sum(i, start) = start + w_1 k_1[i] + w_2 k_2[i] + ..., the number of terms
// known to the compiler.
template <typename Body, std::size_t... J>
inline void with_terms(const Terms& terms, std::index_sequence<J...>, Body body) {
  const std::array<const double*, sizeof...(J)> k{terms.k[J]...};
  const std::array<double, sizeof...(J)> w{terms.weight[J]...};
  body([k, w](std::size_t i, double sum) {
    ((sum += w[J] * k[J][i]), ...);
    return sum;
  });
}
template <typename Body>
inline void with_terms(const Terms& terms, Body body) {
  assert(terms.count > 0);
  switch (terms.count) {
    case 1:
      return with_terms(terms, std::make_index_sequence<1>(), body);
    case 2:
      return with_terms(terms, std::make_index_sequence<2>(), body);
    case 3:
      return with_terms(terms, std::make_index_sequence<3>(), body);
    case 4:
      return with_terms(terms, std::make_index_sequence<4>(), body);
    case 5:
      return with_terms(terms, std::make_index_sequence<5>(), body);
    case 6:
      return with_terms(terms, std::make_index_sequence<6>(), body);
    case 7:
      return with_terms(terms, std::make_index_sequence<7>(), body);
    default:
      return with_terms(terms, std::make_index_sequence<most_terms>(), body);
  }
}

// True when every entry is a finite number.
inline bool all_finite(std::size_t n, const double* x) {
  double total = 0;
  std::size_t i = 0;
  if (n >= narrow_width) {
    std::array<double, 8> sum{};
    for (; i + 8 <= n; i += 8) {
      for (std::size_t lane = 0; lane < 8; ++lane) sum[lane] += x[i + lane];
    }
    total = sum[0] + sum[1] + sum[2] + sum[3] + sum[4] + sum[5] + sum[6] + sum[7];
  }
  for (; i < n; ++i) total += x[i];
  if (std::isfinite(total)) return true;
  return std::all_of(x, x + n, [](double value) { return std::isfinite(value); });  // a finite sum may overflow
}

// Index of the first entry that is not finite; n when all are.
inline std::size_t first_not_finite(std::size_t n, const double* x) {
  return static_cast<std::size_t>(std::find_if(x, x + n, [](double value) { return !std::isfinite(value); }) - x);
}

// The root of the mean of body(i)^2: eight interleaved sums, added in order. 0 for no states.
template <typename Body>
inline double root_mean_square(std::size_t n, Body body) {
  if (n == 0) return 0;
  std::array<double, 8> sum{};
  std::size_t i = 0;
  for (; i + 8 <= n; i += 8) {
    for (std::size_t lane = 0; lane < 8; ++lane) {
      const double entry = body(i + lane);
      sum[lane] += entry * entry;
    }
  }
  double total = ((sum[0] + sum[1]) + (sum[2] + sum[3])) + ((sum[4] + sum[5]) + (sum[6] + sum[7]));
  for (; i < n; ++i) {
    const double entry = body(i);
    total += entry * entry;
  }
  return std::sqrt(total / static_cast<double>(n));
}

}  // namespace plantloop
