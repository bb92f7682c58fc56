// What a fit found, for people.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engine/analysis/fit.h"

namespace plantloop {

std::string to_text(const FitResult& result, double confidence) {
  std::string text = fmt::format("{} after {} iterations and {} runs: {}\n", result.converged ? "fitted" : "NOT fitted",
                                 result.iterations, result.runs, result.why);
  text += fmt::format("derivatives: {}\n", result.gradient);
  if (result.costs.size() > 1) {
    const auto near = std::count_if(result.costs.begin(), result.costs.end(),
                                    [&](double cost) { return cost <= result.cost * (1 + 1e-6) + 1e-300; });
    text += fmt::format("{} of {} starts end here\n", near, result.costs.size());
  }
  std::size_t width = 9;
  for (const FitResult::Estimate& e : result.parameters) width = std::max(width, e.path.size());
  text += fmt::format("{:<{}}  {:>16}  {:>11}  {:g} % interval\n", "parameter", width, "value", "deviation",
                      100 * confidence);
  for (const FitResult::Estimate& e : result.parameters) {
    text += fmt::format("{:<{}}  {:>16.10g}  ", e.path, width, e.value);
    text += e.on_bound                ? fmt::format("{:>11}\n", "on a bound")
            : std::isnan(e.deviation) ? fmt::format("{:>11}\n", "unknown")
                                      : fmt::format("{:>11.4g}  {:.9g} ... {:.9g}\n", e.deviation, e.lower, e.upper);
  }
  if (result.parameters.size() > 1) {
    text += "correlation:\n";
    for (std::size_t i = 0; i < result.parameters.size(); ++i) {
      text += fmt::format("{:<{}}", result.parameters[i].path, width);
      for (std::size_t j = 0; j <= i; ++j) text += fmt::format("  {:6.3f}", result.correlation(i, j));
      text += "\n";
    }
  }
  for (const FitResult::Column& column : result.columns) {
    if (result.experiments > 1) text += fmt::format("experiment {}: ", column.experiment + 1);
    text += fmt::format("'{}' is met within {:.4g} (root mean square of {} values)\n", column.signal, column.rms,
                        column.values);
  }
  return text;
}

}  // namespace plantloop
