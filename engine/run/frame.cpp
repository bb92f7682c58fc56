// A Frame's arena starts on a cache line, wherever the allocator put it.

#include "engine/run/frame.h"

#include <algorithm>
#include <utility>

namespace plantloop {

namespace {

constexpr std::size_t alignment = 64;

double* aligned(std::vector<double>& storage, std::size_t size) {
  storage.assign(size + alignment / sizeof(double), 0.0);
  void* start = storage.data();
  std::size_t room = storage.size() * sizeof(double);
  return static_cast<double*>(std::align(alignment, size * sizeof(double), start, room));
}

}  // namespace

Frame::Frame(std::shared_ptr<const Program> compiled)
    : program(std::move(compiled)),
      arena(aligned(storage, program->arena.size())),
      kernel_states(program->kernel_state_size + 1, 0.0),
      histories(program->history_count),
      loop_values(program->loop_value_count, 0.0),
      loop_room(program->loop_room_size, 0.0),
      scratch(program->scratch_size + 1, 0.0),
      next_hit(program->rates.size(), 0),
      next_instant(program->schedules.size(), 0) {
  std::copy(program->arena.begin(), program->arena.end(), arena);
}

Frame::Frame(const Frame& other)
    : program(other.program),
      arena(aligned(storage, program->arena.size())),
      kernel_states(other.kernel_states),
      histories(other.histories),
      loop_values(other.loop_values),
      loop_room(other.loop_room),
      scratch(other.scratch),
      next_hit(other.next_hit),
      next_instant(other.next_instant) {
  std::copy(other.arena, other.arena + program->arena.size(), arena);
}

KernelFrame Frame::kernel_frame(bool left) {
  KernelFrame frame;
  frame.program = program.get();
  frame.states = kernel_states.data();
  frame.scratch = scratch.data();
  frame.histories = histories.data();
  frame.loop_values = loop_values.data();
  frame.loop_room = loop_room.data();
  frame.left = left;
  return frame;
}

}  // namespace plantloop
