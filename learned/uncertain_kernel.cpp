// What identification predicts, copied into the frame.

#include "learned/uncertain_kernel.h"

#include <algorithm>

namespace plantloop {
namespace {

void put(const identify::UncertainPrediction& found, double* out) {
  std::copy_n(found.mean.data(), found.mean.size(), out);
  std::copy_n(found.covariance.data(), found.covariance.size(), out + found.mean.size());
}

}  // namespace

void UncertainMapKernel::evaluate(const KernelCall& call) const {
  const Eigen::Index d = map_.map().inputs();
  put(map_.predict({Eigen::VectorXd::Map(call.in, d), Eigen::MatrixXd::Map(call.in + d, d, d)}), call.out);
}

UncertainKernel::UncertainKernel(const std::shared_ptr<const identify::GpMap>& map, identify::RegressorSet regressors,
                                 identify::Propagation method, bool feed_noise)
    : run_(map, std::move(regressors), method, feed_noise), inputs_(map->inputs()) {}

void UncertainKernel::initialise(const KernelCall& call) const {
  std::fill(call.state, call.state + state_size(), 0.0);
  for (int i = 0; i < run_.depth(); ++i)
    std::copy_n(call.in + inputs_, run_.outputs(), call.state + i * run_.outputs());
}

void UncertainKernel::evaluate(const KernelCall& call) const { put(run_.predict(call.in, call.state), call.out); }

void UncertainKernel::advance(const KernelCall& call) const {
  run_.advance(run_.predict(call.in, call.state), call.state, call.scratch);
  std::copy(call.scratch, call.scratch + state_size(), call.state);
}

}  // namespace plantloop
