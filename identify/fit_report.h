// What a fit tells about itself: what was tried, what was reached, why it stopped; and how it is watched and cancelled.

#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "identify/error.h"
#include "identify/model_file/item.h"

namespace plantloop::identify {

struct FitReport {
  std::string method;              // "least squares", "prediction error method, Levenberg-Marquardt"
  std::vector<std::string> tried;  // one line for each start, structure or size
  long long samples = 0;           // rows that the criterion is made of
  long long parameters = 0;
  double reached = 0;
  // What `reached` is, in words.
  std::string measure = "mean square of the prediction error";
  long long iterations = 0;           // 0: none were needed
  std::string stopped;                // "the gradient vanished", "the limit of 100 iterations"
  std::vector<std::string> warnings;  // ill-conditioned, unexcited, unstable, ...
  std::uint64_t seed = 0;             // of random starts; 0: nothing is random
  std::string data;                   // hash() of the data of the fit; "" when they are plain matrices
  std::vector<std::string> options;   // what was asked for where it is not the default: "ridge 0.1"
};

// The lines for people, and the section `fit` of a model file and back.
std::string to_text(const FitReport& report);
Item to_item(const FitReport& report);
FitReport fit_report_of(const Item& item);

// How a long fit is watched. All may be empty.
struct FitControl {
  std::function<void(double fraction)> progress;  // 0 to 1, called from the thread that called the fit
  const std::atomic<bool>* cancel = nullptr;      // set from anywhere: the fit raises Cancelled
  std::optional<std::chrono::steady_clock::time_point> deadline{};  // from then on the fit raises Cancelled
  void step(double fraction) const;
  void look() const;  // raises Cancelled when the fit is to end; from any thread
};
class Cancelled : public IdentifyError {
 public:
  using IdentifyError::IdentifyError;
};

}  // namespace plantloop::identify
