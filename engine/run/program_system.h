// The Program's derivatives as a solver sees them.

#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "engine/run/frame.h"
#include "engine/solve/integrator.h"

namespace plantloop {

class ProgramSystem final : public OdeSystem {
 public:
  // `step` (s) is that of a fixed-step run, which the Program's step list was made for; else 0. The states at the
  // places `still` do not move.
  ProgramSystem(Frame& frame, double step, const std::vector<std::uint32_t>& still);

  int size() const override { return static_cast<int>(frame_.state_count()); }
  double* state() override { return frame_.states(); }
  const double* derivatives(double t) override;
  const SparsityPattern* pattern() const override { return pattern_.size > 0 ? &pattern_ : nullptr; }
  const double* jacobian(double t) override;
  bool fixed_step(std::string_view method, double t, double h) override;
  int algebraic_size() const override { return static_cast<int>(unknowns_.size()); }
  const double* algebraic() override;
  void take_algebraic(const double* z) override;
  const double* equations(double t, const double* z) override;
  const SparsityPattern* equations_pattern() const override { return dae_pattern_.size > 0 ? &dae_pattern_ : nullptr; }
  const double* equations_jacobian(double t, const double* z) override;

  // While true, modes are those of the present values and not those of the step's start.
  bool follows_modes = false;

 private:
  void follow_modes();
  void put_algebraic(const double* z);

  Frame& frame_;
  const Program& program_;
  KernelFrame kernels_;
  double step_;
  const std::vector<std::uint32_t>& still_;
  SparsityPattern pattern_;
  std::vector<double> entries_;
  // As a system of equations with the unknowns of loops: their slots, and their places in the Frame's loop values.
  SparsityPattern dae_pattern_;
  std::vector<SlotIndex> unknowns_;
  std::vector<std::uint32_t> values_;
  std::vector<double> algebraic_, dae_entries_;
};

}  // namespace plantloop
