// Everything that changes during a run, as flat arrays: copying a Frame is saving a run.

#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "engine/program/program.h"

namespace plantloop {

struct Frame {
  explicit Frame(std::shared_ptr<const Program> program);

  std::shared_ptr<const Program> program;
  std::vector<double> storage;  // the arena lies in it, aligned to 64 bytes
  double* arena = nullptr;
  std::vector<double> kernel_states;  // of all kernels, one after the other
  std::vector<History> histories;
  std::vector<double> loop_values;         // of all loops' unknowns, as last accepted
  std::vector<double> loop_room;           // of the loops; cleared when parameters change
  std::vector<double> scratch;             // without meaning between calls
  std::vector<std::int64_t> next_hit;      // per rate: number of its next hit
  std::vector<std::int64_t> next_instant;  // per schedule: number of its next instant

  double* states() { return arena + program->states; }
  std::size_t state_count() const { return program->state_at.size(); }
  KernelFrame kernel_frame(bool left);
  // Sets a tunable parameter by its number in Program::parameters.
  void set_parameter(std::size_t index, double value) { arena[program->parameters[index]] = value; }

  Frame(const Frame& other);
  Frame& operator=(const Frame&) = delete;
};

}  // namespace plantloop
