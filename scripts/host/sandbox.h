// The limits of a script: instructions, time and memory. Once one is passed, every further step of the script fails.
//
// Invariants. Every thread of Lua (coroutine) carries the hook, as it inherits it from its maker. The hook is called at
// least every 1000 instructions; when a limit is passed it raises, and from then on at every single instruction, so
// that no `pcall` gets further than one. Functions of ours that take long report their work with `work`. Finalizers
// (`__gc`), inside which Lua calls no hook, cannot be made by a script.

#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>

#include "scripts/host/host.h"
#include "scripts/host/stack.h"

namespace plantloop::lua {

enum class Limit { none, instructions, time, memory, cancelled };

class Sandbox {
 public:
  explicit Sandbox(const ScriptOptions& options);

  // For lua_newstate: counts bytes, refuses beyond the limit.
  static void* allocate(void* sandbox, void* block, std::size_t old_size, std::size_t new_size);
  // Puts the hook on the main thread.
  void watch(lua_State* L);

  // Work of our own functions, in instructions; raises when a limit is passed.
  void work(lua_State* L, double instructions);
  // Raises unless that many bytes are free, if need be after collecting garbage.
  void make_room(lua_State* L, std::size_t bytes);
  // Collects garbage when more than half of the memory is taken.
  void tidy(lua_State* L) const;
  // Bytes outside Lua that live as long as an object of the script: `hold` raises when they do not fit.
  void hold(lua_State* L, std::size_t bytes);
  void release(std::size_t bytes) { bytes_ -= bytes < bytes_ ? bytes : bytes_; }

  Limit exceeded() const { return exceeded_; }
  void exceed(Limit limit);
  // Asks clock and Ctrl-C.
  void look_around();
  // Raises when a limit has been passed.
  void check(lua_State* L);
  // The error that ends a script, onto the stack.
  void push_end(lua_State* L);

  double elapsed() const;       // s since the start
  double seconds_left() const;  // infinite without a limit; at least 0
  std::size_t bytes_left() const { return bytes_ < most_bytes_ ? most_bytes_ - bytes_ : 0; }
  // "it ran for 60 s, the limit; ..." and where it was then; "" when no limit was passed.
  std::string why_it_ended() const;

 private:
  static void hook(lua_State* L, lua_Debug* frame);
  using Clock = std::chrono::steady_clock;

  const ScriptOptions& options_;
  Clock::time_point start_ = Clock::now();
  Clock::time_point last_look_ = start_;
  double instructions_ = 0;
  double unseen_work_ = 0;
  std::size_t bytes_ = 0, most_bytes_ = 0;
  std::size_t refused_ = 0;  // size of the request that was refused last
  Limit exceeded_ = Limit::none;
  std::string place_;  // "script.lua:12"
};

}  // namespace plantloop::lua
