// What a list reads without computing it itself: the data that its results depend on.

#pragma once

#include <cstdint>
#include <vector>

#include "engine/program/execute.h"

namespace plantloop {

// The slots, ascending. Defined beside the executor, which knows how lists are laid out.
std::vector<std::uint32_t> slots_read(const List& list);

}  // namespace plantloop
