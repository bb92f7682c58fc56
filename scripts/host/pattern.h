// Lua's patterns, matched by us so that the work can be counted: a short pattern can ask for years of going back.

#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <optional>
#include <string_view>

namespace plantloop::lua {

struct Capture {
  const char* start = nullptr;
  std::ptrdiff_t length = 0;  // or one of the two below
  static constexpr std::ptrdiff_t open = -1;
  static constexpr std::ptrdiff_t position = -2;
};

// As chapter 6.4.1 of the Lua 5.4 manual. Throws ScriptError for a pattern that is none.
class Pattern {
 public:
  static constexpr int most_captures = 32;

  // `count_work` is called now and then with the steps done since the last call; it may throw to end the match. Both
  // texts must outlive the pattern.
  Pattern(std::string_view subject, std::string_view pattern, std::function<void(double)> count_work);

  bool is_anchored() const { return anchored_; }
  // The end of a match that begins at `start`, or null. Captures are those of the last match.
  const char* match_at(const char* start);
  // The first match that begins at `from` or later: where it begins; its end is last_end().
  const char* find_from(const char* from);
  const char* last_end() const { return last_end_; }
  int captures() const { return level_; }
  const Capture& capture(int index) const;

 private:
  const char* match(const char* s, const char* p);
  const char* class_end(const char* p) const;
  bool single_match(const char* s, const char* p, const char* after) const;
  bool in_set(unsigned char c, const char* p, const char* last) const;
  const char* longest(const char* s, const char* p, const char* after);
  const char* shortest_first(const char* s, const char* p, const char* after);
  const char* balance(const char* s, const char* p);
  const char* start_capture(const char* s, const char* p, std::ptrdiff_t kind);
  const char* end_capture(const char* s, const char* p);
  const char* same_again(const char* s, char digit) const;
  void step();

  const char* begin_;
  const char* end_;
  const char* p_begin_;
  const char* p_end_;
  std::function<void(double)> count_work_;
  bool anchored_ = false;
  int level_ = 0;
  int depth_ = 0;
  int steps_ = 0;
  std::array<Capture, most_captures> captures_{};
  const char* last_end_ = nullptr;
};

}  // namespace plantloop::lua
