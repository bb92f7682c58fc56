// The feedback of shift registers that give binary sequences of the greatest length.

#pragma once

#include <array>
#include <cstddef>

namespace plantloop::identify {

inline constexpr int fewest_prbs_bits = 2;
inline constexpr int most_prbs_bits = 20;

// The bits, counted from 1, whose exclusive or is fed to the first one of a register of `bits` bits, filled up with 0:
// primitive polynomials (P. Alfke, Xilinx XAPP 052). bits: fewest_prbs_bits ... most_prbs_bits.
inline std::array<int, 4> prbs_taps(int bits) {
  // clang-format off
  static constexpr std::array<std::array<int, 4>, most_prbs_bits - fewest_prbs_bits + 1> taps{
      {{2, 1},        {3, 2},        {4, 3},        {5, 3},   {6, 5},          {7, 6},   {8, 6, 5, 4}, {9, 5},        {10, 7}, {11, 9},
       {12, 6, 4, 1}, {13, 4, 3, 1}, {14, 5, 3, 1}, {15, 14}, {16, 15, 13, 4}, {17, 14}, {18, 11},     {19, 6, 2, 1}, {20, 17}}};
  // clang-format on
  return taps[static_cast<std::size_t>(bits - fewest_prbs_bits)];
}

}  // namespace plantloop::identify
