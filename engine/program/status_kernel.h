// Kernels that say how they fared: the run counts it.

#pragma once

#include <string>
#include <vector>

namespace plantloop {

// A base beside Kernel, for kernels of a discrete rate.
class StatusKernel {
 public:
  virtual ~StatusKernel() = default;
  // Which of the kernel's outputs is the status, a number from 0 on.
  virtual int status_output() const = 0;
  // What the numbers mean, as one would say it of a sample: "optimum found". The first one is as it should be.
  virtual std::vector<std::string> status_words() const = 0;
};

}  // namespace plantloop
