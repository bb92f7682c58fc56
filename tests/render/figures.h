// The figures that the tests of render draw: ordinary ones and those at the edge of what can be drawn.

#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "render/figure.h"

namespace plantloop {

struct NamedFigure {
  std::string name;
  Figure figure;
};

std::vector<NamedFigure> test_figures();

// The figure the speed goals speak of: five noisy step responses of 10 000 samples.
Figure noisy_steps();

// A figure of any kind and size, the same for the same seed.
Figure random_figure(std::uint32_t seed);

}  // namespace plantloop
