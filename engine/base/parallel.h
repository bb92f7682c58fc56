// Independent pieces of work on several threads.

#pragma once

#include <cstddef>
#include <functional>

namespace plantloop {

// How many threads to take: what was asked for, else the environment's LP_NUM_THREADS, else one for each processor.
std::size_t thread_count(std::size_t asked);

// Calls work(0), ..., work(count - 1), each once. Each piece writes to a place of its own, so that the result does not
// depend on the number of threads. Of several pieces that throw, the exception of the first one is passed on when all
// have ended; no further ones are begun then.
void in_parallel(std::size_t count, std::size_t threads, const std::function<void(std::size_t)>& work);

}  // namespace plantloop
