// Threads that take the next piece until none is left.

#include "engine/base/parallel.h"

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <exception>
#include <thread>
#include <vector>

namespace plantloop {

std::size_t thread_count(std::size_t asked) {
  if (asked > 0) return asked;
  if (const char* const given = std::getenv("LP_NUM_THREADS")) {  // NOLINT(concurrency-mt-unsafe): nobody sets it
    const long number = std::strtol(given, nullptr, 10);
    if (number > 0) return static_cast<std::size_t>(number);
  }
  return std::max(1U, std::thread::hardware_concurrency());
}

void in_parallel(std::size_t count, std::size_t threads, const std::function<void(std::size_t)>& work) {
  std::vector<std::exception_ptr> failures(count);
  std::atomic<std::size_t> next{0};
  std::atomic<bool> failed{false};
  const auto take = [&] {
    for (std::size_t i = next++; i < count && !failed; i = next++) {
      try {
        work(i);
      } catch (...) {
        failures[i] = std::current_exception();
        failed = true;
      }
    }
  };
  std::vector<std::thread> pool;
  for (std::size_t i = 1; i < std::min(threads, count); ++i) pool.emplace_back(take);
  take();
  for (std::thread& thread : pool) thread.join();
  for (const std::exception_ptr& failure : failures) {
    if (failure) std::rethrow_exception(failure);
  }
}

}  // namespace plantloop
