// Counting instructions, seconds and bytes, and stopping a script that does not want to be stopped.

#include "scripts/host/sandbox.h"

#include <fmt/format.h>

#include <cstdlib>
#include <limits>

#include "scripts/host/session.h"

namespace plantloop::lua {
namespace {

constexpr int usual_interval = 1000;  // instructions between two calls of the hook
constexpr int short_interval = 10;    // the same while single instructions take long
constexpr std::size_t large_block = std::size_t{1} << 20;
constexpr std::size_t reserve = std::size_t{1} << 20;  // for ending in order once the limit is passed

// Its address is the key under which Lua keeps the text of push_end.
const char end_key = 0;

}  // namespace

Sandbox::Sandbox(const ScriptOptions& options)
    : options_(options),
      most_bytes_(options.max_memory > 0 ? options.max_memory : std::numeric_limits<std::size_t>::max() / 2) {}

void* Sandbox::allocate(void* sandbox, void* block, std::size_t old_size, std::size_t new_size) {
  auto& self = *static_cast<Sandbox*>(sandbox);
  if (block == nullptr) old_size = 0;  // Lua passes the kind of the object
  if (new_size == 0) {
    std::free(block);
    self.bytes_ -= old_size;
    return nullptr;
  }
  if (new_size > old_size) {
    const std::size_t after = self.bytes_ - old_size + new_size;
    const bool ended = self.exceeded_ != Limit::none;
    if (after > self.most_bytes_ + (ended ? reserve : 0)) {
      // Lua collects garbage and asks for the same again: only the second refusal in a row is the end.
      if (self.refused_ == new_size) self.exceed(Limit::memory);
      self.refused_ = new_size;
      return nullptr;
    }
    // Texts are made by single instructions: the clock must be asked here, too.
    if (new_size >= large_block) {
      self.unseen_work_ += static_cast<double>(new_size) / 64;
      self.look_around();
      if (self.exceeded_ != Limit::none) return nullptr;
    }
  }
  if (self.refused_ == new_size) self.refused_ = 0;
  void* moved = std::realloc(block, new_size);
  if (moved == nullptr) {
    if (new_size <= old_size) return block;  // Lua relies on shrinking
    self.exceed(Limit::memory);
    return nullptr;
  }
  self.bytes_ = self.bytes_ - old_size + new_size;
  return moved;
}

void Sandbox::watch(lua_State* L) {
  lua_pushliteral(L, "the script was stopped");
  lua_rawsetp(L, LUA_REGISTRYINDEX, &end_key);
  lua_sethook(L, hook, LUA_MASKCOUNT, usual_interval);
}

void Sandbox::hook(lua_State* L, lua_Debug*) {
  Sandbox& self = session_of(L).sandbox;
  const int interval = lua_gethookcount(L);
  self.unseen_work_ += interval;
  const Clock::time_point before = self.last_look_;
  self.look_around();
  if (self.exceeded_ != Limit::none) self.check(L);
  const double took = std::chrono::duration<double>(self.last_look_ - before).count();
  const int wanted = took > 0.02 ? short_interval : usual_interval;
  if (wanted != interval) lua_sethook(L, hook, LUA_MASKCOUNT, wanted);
}

void Sandbox::exceed(Limit limit) {
  if (exceeded_ == Limit::none) exceeded_ = limit;
}

void Sandbox::look_around() {
  last_look_ = Clock::now();
  instructions_ += unseen_work_;
  unseen_work_ = 0;
  if (options_.cancel != nullptr && options_.cancel->load(std::memory_order_relaxed)) exceed(Limit::cancelled);
  if (options_.time_limit > 0 && elapsed() > options_.time_limit) exceed(Limit::time);
  if (options_.max_instructions > 0 && instructions_ > static_cast<double>(options_.max_instructions)) {
    exceed(Limit::instructions);
  }
}

void Sandbox::push_end(lua_State* L) {
  lua_sethook(L, hook, LUA_MASKCOUNT, 1);
  if (place_.empty()) {
    lua_Debug frame;
    for (int level = 0; lua_getstack(L, level, &frame) != 0; ++level) {
      lua_getinfo(L, "Sl", &frame);
      if (frame.currentline <= 0) continue;
      place_ = fmt::format("{}:{}", session_of(L).full_name(frame.short_src), frame.currentline);
      break;
    }
  }
  lua_rawgetp(L, LUA_REGISTRYINDEX, &end_key);
}

void Sandbox::check(lua_State* L) {
  if (exceeded_ == Limit::none) return;
  push_end(L);
  lua_error(L);
}

void Sandbox::work(lua_State* L, double instructions) {
  unseen_work_ += instructions;
  if (unseen_work_ >= usual_interval) look_around();
  check(L);
}

void Sandbox::make_room(lua_State* L, std::size_t bytes) {
  if (bytes > bytes_left()) lua_gc(L, LUA_GCCOLLECT);
  if (bytes > bytes_left()) exceed(Limit::memory);
  check(L);
}

void Sandbox::tidy(lua_State* L) const {
  if (bytes_ > most_bytes_ / 2) lua_gc(L, LUA_GCCOLLECT);
}

void Sandbox::hold(lua_State* L, std::size_t bytes) {
  make_room(L, bytes);
  bytes_ += bytes;
  // Lua does not see these bytes: make it collect as if they were its own.
  lua_gc(L, LUA_GCSTEP, static_cast<int>(bytes >> 10 < 1'000'000 ? bytes >> 10 : 1'000'000));
}

double Sandbox::elapsed() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }

double Sandbox::seconds_left() const {
  if (options_.time_limit <= 0) return std::numeric_limits<double>::infinity();
  return std::max(0.0, options_.time_limit - elapsed());
}

std::string Sandbox::why_it_ended() const {
  const std::string where = place_.empty() ? "" : place_ + ": ";
  switch (exceeded_) {
    case Limit::none:
      return {};
    case Limit::cancelled:
      return where + "stopped on request";
    case Limit::time:
      return fmt::format("{}stopped: the script ran for {:g} s, its limit (--max-time SECONDS gives it more)", where,
                         options_.time_limit);
    case Limit::instructions:
      return fmt::format("{}stopped: the script took {:g} instructions, its limit (--max-instructions gives it more)",
                         where, static_cast<double>(options_.max_instructions));
    case Limit::memory:
      return fmt::format(
          "{}stopped: the script needs more than {:g} MB of memory, its limit (--max-memory gives it more)", where,
          static_cast<double>(most_bytes_) / 1048576.0);
  }
  return {};
}

}  // namespace plantloop::lua
