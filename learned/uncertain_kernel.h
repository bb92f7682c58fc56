// Gaussian processes that carry uncertainty along, as kernels: at a point, and in free run.

#pragma once

#include <memory>
#include <string>

#include "engine/program/kernel.h"
#include "identify/gp/gp_map.h"

namespace plantloop {

// A Gaussian process at an uncertain point. Inputs: the D means, the D x D covariances row by row. Outputs: the means,
// then the covariances row by row.
class UncertainMapKernel final : public Kernel {
 public:
  // Raises IdentifyError as identify::Propagator does.
  UncertainMapKernel(std::shared_ptr<const identify::GpMap> map, identify::Propagation method)
      : map_(std::move(map), method) {}
  std::string name() const override { return "Gaussian process at an uncertain point"; }
  int outputs() const override { return map_.map().outputs() * (1 + map_.map().outputs()); }
  void evaluate(const KernelCall& call) const override;

 private:
  identify::UncertainMap map_;
};

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
