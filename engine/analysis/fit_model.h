// A diagram as a function of some of its parameters: in each experiment the fitted signals at the times of the data,
// and their derivatives.

#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/analysis/fit.h"
#include "engine/graph/record.h"
#include "engine/program/sensitivities.h"

namespace plantloop {

class FitModel {
 public:
  // Of one experiment of the request; null after reporting what is wrong.
  static std::unique_ptr<FitModel> make(const std::shared_ptr<const Model>& model, const FitRequest& request,
                                        const FitExperiment& experiment, Report& report);

  std::size_t parameters() const { return slots_.size(); }
  std::size_t outputs() const { return data().time.size() * data().columns.size(); }
  const std::vector<double>& start() const { return start_; }
  const FitData& data() const { return experiment_.data; }

  struct Answer {
    std::vector<double> y;  // by columns of the data: all times of the first, then of the second, ...
    DenseMatrix slopes;     // dy/dp: outputs() x parameters()
  };
  // Throws RunError when the run fails or a bound of the diagram's own is not met. May be called from several threads.
  // `moved` becomes true when an event had a time that moves with a parameter: from then on slopes are differences.
  Answer answer(const std::vector<double>& p, bool slopes, const std::atomic<bool>* cancel, bool& moved) const;
  // Why derivatives are differences; "" while they are exact.
  std::string differences(bool moved) const;
  int runs() const { return runs_; }

 private:
  FitModel(const FitRequest& request, const FitExperiment& experiment) : request_(request), experiment_(experiment) {}
  bool compile(const std::shared_ptr<const Model>& model, Report& report);
  bool find_parameters(const Overrides& set, Report& report);
  bool find_signals(Report& report);
  void set(Frame& frame, const std::vector<double>& p) const;
  std::vector<double> run(const Program& program, const std::vector<double>& p, std::size_t watches,
                          const std::atomic<bool>* cancel, bool& moved) const;
  Answer by_sensitivities(const std::vector<double>& p, const std::atomic<bool>* cancel, bool& moved) const;
  Answer by_differences(const std::vector<double>& p, const std::atomic<bool>* cancel) const;

  const FitRequest& request_;
  const FitExperiment& experiment_;
  std::shared_ptr<const Graph> graph_;
  RecordedGraph recorded_;
  SimulationOptions options_;
  std::vector<std::uint32_t> slots_;                      // parameters of the Record
  std::vector<double> start_, scale_;                     // of the parameters
  std::vector<std::pair<std::uint32_t, double>> others_;  // tunable numbers that the request sets
  CompileOptions compiling_;
  std::shared_ptr<const Program> plain_, exact_;
  SensitivityLimits limits_;
  mutable std::atomic<int> runs_{0};
};

}  // namespace plantloop
