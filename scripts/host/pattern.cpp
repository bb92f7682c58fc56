// Matching with going back, after the manual's definition; each comparison counts as one step of work.

#include "scripts/host/pattern.h"

#include <fmt/format.h>

#include <cctype>
#include <cstring>

#include "scripts/host/stack.h"

namespace plantloop::lua {
namespace {

constexpr char escape = '%';
constexpr int most_depth = 200;
constexpr int report_interval = 4000;

bool in_class(int c, char name) {
  bool result = false;
  switch (std::tolower(static_cast<unsigned char>(name))) {
    case 'a':
      result = std::isalpha(c) != 0;
      break;
    case 'c':
      result = std::iscntrl(c) != 0;
      break;
    case 'd':
      result = std::isdigit(c) != 0;
      break;
    case 'g':
      result = std::isgraph(c) != 0;
      break;
    case 'l':
      result = std::islower(c) != 0;
      break;
    case 'p':
      result = std::ispunct(c) != 0;
      break;
    case 's':
      result = std::isspace(c) != 0;
      break;
    case 'u':
      result = std::isupper(c) != 0;
      break;
    case 'w':
      result = std::isalnum(c) != 0;
      break;
    case 'x':
      result = std::isxdigit(c) != 0;
      break;
    default:
      return name == static_cast<char>(c);
  }
  return std::isupper(static_cast<unsigned char>(name)) != 0 ? !result : result;
}

}  // namespace

Pattern::Pattern(std::string_view subject, std::string_view pattern, std::function<void(double)> count_work)
    : begin_(subject.data()),
      end_(begin_ + subject.size()),
      p_begin_(pattern.data()),
      p_end_(p_begin_ + pattern.size()),
      count_work_(std::move(count_work)),
      anchored_(pattern.starts_with('^')) {
  if (anchored_) ++p_begin_;
}

const Capture& Pattern::capture(int index) const {
  const Capture& c = captures_[static_cast<std::size_t>(index)];
  if (c.length == Capture::open) throw ScriptError("the pattern has a '(' that is not closed");
  return c;
}

void Pattern::step() {
  if (++steps_ < report_interval) return;
  count_work_(steps_);
  steps_ = 0;
}

const char* Pattern::match_at(const char* start) {
  level_ = 0;
  depth_ = 0;
  return match(start, p_begin_);
}

const char* Pattern::find_from(const char* from) {
  for (const char* s = from; s <= end_; ++s) {
    step();
    last_end_ = match_at(s);
    if (last_end_ != nullptr) return s;
    if (anchored_) break;
  }
  return nullptr;
}

const char* Pattern::class_end(const char* p) const {
  const char first = *p++;
  if (first == escape) {
    if (p == p_end_) throw ScriptError("the pattern ends with '%'");
    return p + 1;
  }
  if (first != '[') return p;
  if (p != p_end_ && *p == '^') ++p;
  do {
    if (p == p_end_) throw ScriptError("the pattern has a '[' that is not closed");
    if (*p++ == escape) {
      if (p == p_end_) throw ScriptError("the pattern ends with '%'");
      ++p;
    }
  } while (p == p_end_ || *p != ']');
  return p + 1;
}

// p is at '[', last at ']'.
bool Pattern::in_set(unsigned char c, const char* p, const char* last) const {
  bool wanted = true;
  if (p[1] == '^') {
    wanted = false;
    ++p;
  }
  while (++p < last) {
    if (*p == escape) {
      ++p;
      if (in_class(c, *p)) return wanted;
    } else if (p[1] == '-' && p + 2 < last) {
      p += 2;
      if (static_cast<unsigned char>(p[-2]) <= c && c <= static_cast<unsigned char>(*p)) return wanted;
    } else if (static_cast<unsigned char>(*p) == c) {
      return wanted;
    }
  }
  return !wanted;
}

bool Pattern::single_match(const char* s, const char* p, const char* after) const {
  if (s >= end_) return false;
  const auto c = static_cast<unsigned char>(*s);
  if (*p == '.') return true;
  if (*p == escape) return in_class(c, p[1]);
  if (*p == '[') return in_set(c, p, after - 1);
  return static_cast<unsigned char>(*p) == c;
}

const char* Pattern::longest(const char* s, const char* p, const char* after) {
  std::ptrdiff_t count = 0;
  while (single_match(s + count, p, after)) {
    ++count;
    step();
  }
  for (; count >= 0; --count) {
    if (const char* found = match(s + count, after + 1)) return found;
  }
  return nullptr;
}

const char* Pattern::shortest_first(const char* s, const char* p, const char* after) {
  for (;; ++s) {
    step();
    if (const char* found = match(s, after + 1)) return found;
    if (!single_match(s, p, after)) return nullptr;
  }
}

const char* Pattern::balance(const char* s, const char* p) {
  if (p_end_ - p < 2) throw ScriptError("'%b' in a pattern needs two characters after it");
  if (s >= end_ || *s != *p) return nullptr;
  int open = 1;
  while (++s < end_) {
    step();
    if (*s == p[1]) {
      if (--open == 0) return s + 1;
    } else if (*s == p[0]) {
      ++open;
    }
  }
  return nullptr;
}

const char* Pattern::start_capture(const char* s, const char* p, std::ptrdiff_t kind) {
  if (level_ >= most_captures) throw ScriptError("the pattern has more than 32 captures");
  captures_[static_cast<std::size_t>(level_)] = {s, kind};
  ++level_;
  const char* found = match(s, p);
  if (found == nullptr) --level_;
  return found;
}

const char* Pattern::end_capture(const char* s, const char* p) {
  int last = level_ - 1;
  while (last >= 0 && captures_[static_cast<std::size_t>(last)].length != Capture::open) --last;
  if (last < 0) throw ScriptError("the pattern has a ')' without its '('");
  Capture& capture = captures_[static_cast<std::size_t>(last)];
  capture.length = s - capture.start;
  const char* found = match(s, p);
  if (found == nullptr) capture.length = Capture::open;
  return found;
}

const char* Pattern::same_again(const char* s, char digit) const {
  const int index = digit - '1';
  if (index < 0 || index >= level_ || captures_[static_cast<std::size_t>(index)].length == Capture::open) {
    throw ScriptError(fmt::format("the pattern has no capture %{}", digit));
  }
  const Capture& c = captures_[static_cast<std::size_t>(index)];
  const std::ptrdiff_t size = c.length < 0 ? 0 : c.length;
  if (end_ - s < size || std::memcmp(c.start, s, static_cast<std::size_t>(size)) != 0) return nullptr;
  return s + size;
}

const char* Pattern::match(const char* s, const char* p) {
  struct Depth {
    int& depth;
    ~Depth() { --depth; }
  } const guard{depth_};
  if (++depth_ > most_depth) throw ScriptError("the pattern is too complex");
  while (p != p_end_) {
    step();
    if (*p == '(') {
      const bool position = p + 1 != p_end_ && p[1] == ')';
      return position ? start_capture(s, p + 2, Capture::position) : start_capture(s, p + 1, Capture::open);
    }
    if (*p == ')') return end_capture(s, p + 1);
    if (*p == '$' && p + 1 == p_end_) return s == end_ ? s : nullptr;
    if (*p == escape && p + 1 != p_end_ && p[1] == 'b') {
      s = balance(s, p + 2);
      if (s == nullptr) return nullptr;
      p += 4;
      continue;
    }
    if (*p == escape && p + 1 != p_end_ && p[1] == 'f') {
      p += 2;
      if (p == p_end_ || *p != '[') throw ScriptError("'%f' in a pattern needs a set after it, as in %f[%w]");
      const char* after = class_end(p);
      const auto before = static_cast<unsigned char>(s == begin_ ? '\0' : s[-1]);
      const auto here = static_cast<unsigned char>(s == end_ ? '\0' : *s);
      if (in_set(before, p, after - 1) || !in_set(here, p, after - 1)) return nullptr;
      p = after;
      continue;
    }
    if (*p == escape && p + 1 != p_end_ && std::isdigit(static_cast<unsigned char>(p[1])) != 0) {
      s = same_again(s, p[1]);
      if (s == nullptr) return nullptr;
      p += 2;
      continue;
    }
    const char* after = class_end(p);
    const char suffix = after == p_end_ ? '\0' : *after;
    if (suffix == '-') return shortest_first(s, p, after);
    if (suffix == '*') return longest(s, p, after);
    const bool one = single_match(s, p, after);
    if (suffix == '+') return one ? longest(s + 1, p, after) : nullptr;
    if (suffix == '?') {
      if (one) {
        if (const char* found = match(s + 1, after + 1)) return found;
      }
      p = after + 1;
      continue;
    }
    if (!one) return nullptr;
    ++s;
    p = after;
  }
  return s;
}

}  // namespace plantloop::lua
