// A free run of a Gaussian process that carries its uncertainty along, as a kernel.

#pragma once

#include <memory>
#include <string>

#include "engine/program/kernel.h"
#include "identify/gp/gp_map.h"

namespace plantloop {

// Inputs: the regressors (those of outputs are not read), then the outputs before the start. Outputs: the means, then
// the covariances row by row. The state is that of identify::UncertainRun.
class UncertainKernel final : public Kernel {
 public:
  UncertainKernel(const std::shared_ptr<const identify::GpMap>& map, identify::RegressorSet regressors,
                  identify::Propagation method, bool feed_noise);
  std::string name() const override { return "Gaussian process in free run"; }
  int outputs() const override { return run_.outputs() * (1 + run_.outputs()); }
  int state_size() const override { return run_.state_size(); }
  int scratch_size() const override { return run_.state_size(); }
  bool starts_with_inputs() const override { return true; }
  void initialise(const KernelCall& call) const override;
  void evaluate(const KernelCall& call) const override;
  void advance(const KernelCall& call) const override;

 private:
  identify::UncertainRun run_;
  int inputs_;
};

}  // namespace plantloop
