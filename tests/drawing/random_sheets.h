// Sheets that nobody would draw, the same for the same seed.

#pragma once

#include <cstdint>

#include "render/diagram/sheet.h"

namespace plantloop {

// `blocks` blocks of all shapes, connected at random, with loops.
Sheet random_sheet(std::uint32_t seed, int blocks);

}  // namespace plantloop
