// Starts of a fit are pieces of work as any others.

#include "identify/fit/parallel.h"

#include "engine/base/parallel.h"

namespace plantloop::identify {

void parallel_for(int count, int threads, const std::function<void(int)>& work) {
  in_parallel(static_cast<std::size_t>(std::max(count, 0)),
              thread_count(static_cast<std::size_t>(std::max(threads, 0))),
              [&work](std::size_t i) { work(static_cast<int>(i)); });
}

}  // namespace plantloop::identify
