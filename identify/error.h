// What data or options do not allow: an error in the words of the user who identifies.

#pragma once

#include <fmt/format.h>

#include <stdexcept>
#include <string>
#include <utility>

namespace plantloop::identify {

// Thrown by every function of identify/ for data and options that allow no result: what is wrong, what was expected,
// what would be right. `what()` is the whole message.
class IdentifyError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

template <typename... Args>
[[noreturn]] void fail(fmt::format_string<Args...> text, Args&&... args) {
  throw IdentifyError(fmt::format(text, std::forward<Args>(args)...));
}

}  // namespace plantloop::identify
