// Steps of identify::UncertainRun on the state in the frame.

#include "learned/uncertain_kernel.h"

#include <algorithm>

namespace plantloop {

UncertainKernel::UncertainKernel(const std::shared_ptr<const identify::GpMap>& map, identify::RegressorSet regressors,
                                 identify::Propagation method, bool feed_noise)
    : run_(map, std::move(regressors), method, feed_noise), inputs_(map->inputs()) {}

void UncertainKernel::initialise(const KernelCall& call) const {
  std::fill(call.state, call.state + state_size(), 0.0);
  for (int i = 0; i < run_.depth(); ++i)
    std::copy_n(call.in + inputs_, run_.outputs(), call.state + i * run_.outputs());
}

void UncertainKernel::evaluate(const KernelCall& call) const {
  const identify::UncertainRun::Step step = run_.predict(call.in, call.state);
  std::copy_n(step.mean.data(), step.mean.size(), call.out);
  std::copy_n(step.covariance.data(), step.covariance.size(), call.out + step.mean.size());
}

void UncertainKernel::advance(const KernelCall& call) const {
  run_.advance(run_.predict(call.in, call.state), call.state, call.scratch);
  std::copy(call.scratch, call.scratch + state_size(), call.state);
}

}  // namespace plantloop
