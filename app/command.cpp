// How commands talk: results to standard output, everything else to standard error.

#include "app/command.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

namespace plantloop::app {

std::atomic<bool> interrupted{false};

bool is_terminal(int descriptor) { return isatty(descriptor) == 1; }

bool print(const Report& report) {
  if (!report.findings().empty()) {
    const std::string text = to_text(report, is_terminal(STDERR_FILENO));
    std::fwrite(text.data(), 1, text.size(), stderr);
  }
  return report.has_errors();
}

void complain(const std::string& message) { fmt::print(stderr, "plantloop: {}\n", message); }

bool write_out(const std::string& text) {
  if (std::fwrite(text.data(), 1, text.size(), stdout) == text.size() && std::fflush(stdout) == 0) return true;
  if (errno == EPIPE) return false;  // the reader has what it wanted, as head does
  complain(fmt::format("cannot write to standard output: {}", std::strerror(errno)));
  return false;
}

}  // namespace plantloop::app
