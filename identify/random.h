// Random numbers that are the same on every machine for the same seed.

#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

namespace plantloop::identify {

// SplitMix64 (G. Steele, D. Lea, C. Flood 2014), counted by draws: number k of a seed is a pure function of both.
class Random {
 public:
  explicit Random(std::uint64_t seed) : seed_(mix(seed)) {}

  std::uint64_t bits() { return mix(seed_ + 0x9e3779b97f4a7c15ULL * ++count_); }
  // Evenly distributed on the open interval (0, 1), and on (lower, upper).
  double uniform() { return (static_cast<double>(bits() >> 11) + 0.5) * 0x1p-53; }
  double uniform(double lower, double upper) { return lower + (upper - lower) * uniform(); }
  // One of 0 ... count - 1; `count` is at least 1.
  std::uint64_t index(std::uint64_t count) { return bits() % count; }
  // Of the normal distribution with mean 0 and variance 1 (G. Box and M. Muller 1958; the cosine of each pair).
  double normal() {
    const double radius = std::sqrt(-2 * std::log(uniform()));
    return radius * std::cos(2 * std::numbers::pi * uniform());
  }

 private:
  static std::uint64_t mix(std::uint64_t z) {
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
    return z ^ (z >> 31);
  }
  std::uint64_t seed_;
  std::uint64_t count_ = 0;
};

// x <- 16807 x mod 2147483647 from x = seed, giving x/2147483647 (S. Park and K. Miller 1988): the same numbers in
// every language. `seed` lies in 1 ... 2147483646.
class ParkMiller {
 public:
  explicit ParkMiller(std::uint32_t seed) : x_(seed) {}
  double uniform() {
    x_ = x_ * 16807 % 2147483647;
    return static_cast<double>(x_) / 2147483647.0;
  }
  double normal() {
    const double radius = std::sqrt(-2 * std::log(uniform()));
    return radius * std::cos(2 * std::numbers::pi * uniform());
  }

 private:
  std::uint64_t x_;
};

}  // namespace plantloop::identify
