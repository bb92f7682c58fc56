// Random numbers that are functions of a counter: the same in every run, order and thread, and with the same bits on
// every machine, since they need no library function.

#pragma once

#include <cstdint>
#include <vector>

#include "engine/block.h"

namespace plantloop {

// Number `count` of a stream, evenly distributed in (0, 1): mixed by SplitMix64's finaliser (G. Steele, D. Lea and
// C. Flood, Fast splittable pseudorandom number generators, 2014).
double uniform_number(std::uint64_t seed, std::uint64_t stream, std::uint64_t element, std::uint64_t count);

// The number below which a normal number of mean 0 and variance 1 lies with probability p in (0, 1); relative accuracy
// 1e-15 (M. Wichura, Algorithm AS 241: The percentage points of the normal distribution, 1988).
double normal_quantile(double p);

enum class Distribution { uniform, normal };

// As many numbers as there are elements, each a stream of the block at hand; uniform in (0, 1) or normal with mean 0
// and variance 1. They depend on the seed and on the number `count` only.
std::vector<Value> random_numbers(Now now, Distribution distribution, Value seed, Value count, int elements);

// A finding unless the seed is a whole number.
void check_seed(Checking& checking, const Number& seed);

}  // namespace plantloop
