// A bar on a terminal once something takes longer than a second; nothing in a pipe.

#pragma once

#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <string>

#include "app/command.h"

namespace plantloop::app {

class Progress {
 public:
  explicit Progress(bool wanted) : wanted_(wanted && is_terminal(STDERR_FILENO)), start_(now()) {}
  ~Progress() { clear(); }
  void operator()(double fraction) {
    if (!wanted_ || now() - start_ < 1) return;
    const int percent = static_cast<int>(fraction * 100);
    if (shown_ && percent == percent_) return;
    percent_ = percent;
    constexpr int width = 40;
    const int full = static_cast<int>(fraction * width);
    fmt::print(stderr, "\r[{}{}] {:3.0f} %", std::string(static_cast<std::size_t>(full), '#'),
               std::string(static_cast<std::size_t>(width - full), ' '), fraction * 100);
    std::fflush(stderr);
    shown_ = true;
  }
  void clear() {
    if (shown_) fmt::print(stderr, "\r{}\r", std::string(50, ' '));
    shown_ = false;
  }
  // For what comes next.
  void restart() {
    clear();
    start_ = now();
  }

 private:
  static double now() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
  }
  bool wanted_;
  bool shown_ = false;
  int percent_ = 0;
  double start_;
};

}  // namespace plantloop::app
