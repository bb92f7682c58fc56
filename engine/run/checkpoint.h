// A run at one instant, so that another run can go on from there, bit for bit (S14).
//
// A save point is a stop at which the solver starts anew in every run that lists it. It stands behind everything that
// happens at its time: rows, events and the update of sampled states. Before the update, which S14 first had in mind,
// would give the same bits, since what anybody reads of a sampled state is a copy taken at the hit; but the run that
// goes on would have to know which hits it still owes an update.

#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "engine/run/frame.h"

namespace plantloop {

struct Checkpoint {
  double start = 0, time = 0;  // s; of the first run's beginning, and of this
  std::uint64_t structure = 0;
  // By path, for a diagram that has changed.
  std::map<std::string, double> states, sampled;
  // By place, for the same one.
  std::vector<double> arena, kernel_states, loop_values;
  std::vector<History> histories;
  std::vector<std::int64_t> next_hit, next_instant;
  std::vector<std::int8_t> signs;  // of the event functions, and whether they were zero
  std::vector<bool> at_zero;
  std::vector<std::uint8_t> was_open;
  // Per event function: its last event and until when it is not looked at (s), and how many came close together.
  std::vector<double> last_event, quiet_until;
  std::vector<int> in_a_row;
  std::vector<std::int8_t> sign_when_muted;
  std::vector<std::uint32_t> still;  // the states that a Zeno policy holds
};

// A number for everything about a program that gives values their place.
std::uint64_t structure_of(const Program& program);

// The frame's part of a checkpoint, and back. `restore` keeps the frame's parameters.
void save(const Frame& frame, Checkpoint& checkpoint);
void restore(const Checkpoint& checkpoint, Frame& frame);
// Only the states and sampled states that have the same path; what one of both does not have is listed in `missing` and
// `extra`.
void restore_by_path(const Checkpoint& checkpoint, Frame& frame);
std::vector<std::string> missing_in(const Checkpoint& checkpoint, const Program& program);
std::vector<std::string> extra_in(const Checkpoint& checkpoint, const Program& program);

// As JSON; numbers read back exactly.
std::string to_json(const Checkpoint& checkpoint);
struct CheckpointResult {
  Checkpoint checkpoint;
  std::string error;  // in words that follow "cannot read 'x': "
  bool ok() const { return error.empty(); }
};
CheckpointResult checkpoint_from_json(std::string_view text);

}  // namespace plantloop
