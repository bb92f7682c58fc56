// The Program's derivatives as a solver sees them.

#pragma once

#include <string_view>
#include <vector>

#include "engine/run/frame.h"
#include "engine/solve/integrator.h"

namespace plantloop {

class ProgramSystem final : public OdeSystem {
 public:
  // `step` (s) is that of a fixed-step run, which the Program's step list was made for; else 0.
  ProgramSystem(Frame& frame, double step);

  int size() const override { return static_cast<int>(frame_.state_count()); }
  double* state() override { return frame_.states(); }
  const double* derivatives(double t) override;
  const SparsityPattern* pattern() const override { return pattern_.size > 0 ? &pattern_ : nullptr; }
  const double* jacobian(double t) override;
  bool fixed_step(std::string_view method, double t, double h) override;

  // While true, modes are those of the present values and not those of the step's start.
  bool follows_modes = false;

 private:
  void follow_modes();

  Frame& frame_;
  const Program& program_;
  KernelFrame kernels_;
  double step_;
  SparsityPattern pattern_;
  std::vector<double> entries_;
};

}  // namespace plantloop
