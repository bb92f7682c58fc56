// Counts what the process allocates: linking plantloop::counting_allocator replaces the global operator new.

#pragma once

namespace plantloop::testing {

// How often memory has been allocated since the process began, by any thread.
long allocations();

}  // namespace plantloop::testing
