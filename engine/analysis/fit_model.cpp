// One run gives signals and sensitivities: they are watched side by side and sampled at the times of the data.

#include "engine/analysis/fit_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engine/analysis/linear_program.h"
#include "engine/base/error.h"
#include "engine/base/numbers.h"

namespace plantloop {

namespace {

constexpr double fit_rtol = 1e-10;
// Of a central difference, in units of the parameter: the error of a run, some 1e-10, over the step, and its square are
// then alike.
constexpr double difference = 5e-4;

std::string list_of(const std::vector<std::string>& names) { return fmt::format("{}", fmt::join(names, ", ")); }

}  // namespace

std::unique_ptr<FitModel> FitModel::make(const std::shared_ptr<const Model>& model, const FitRequest& request,
                                         const FitExperiment& experiment, Report& report) {
  if (model->is_library) {
    report.error({}, "{} is a library: it has types, but no blocks to fit", model->path);
    return nullptr;
  }
  std::unique_ptr<FitModel> fit(new FitModel(request, experiment));
  return fit->compile(model, report) ? std::move(fit) : nullptr;
}

bool FitModel::compile(const std::shared_ptr<const Model>& model, Report& report) {
  const std::size_t errors = report.error_count();
  Overrides set = request_.run.set;
  for (const Override& own : experiment_.set) {
    std::erase_if(set, [&](const Override& o) { return o.path == own.path; });
    set.push_back(own);
  }
  graph_ = elaborate(model, set, report);
  if (!graph_ || report.error_count() > errors) return false;
  recorded_ = record(*graph_);
  // What the diagram writes as an expression, or leaves at its default, becomes a number by being set to one.
  const auto is_number = [&](const std::string& path) {
    const auto& all = recorded_.record.parameters;
    return std::any_of(all.begin(), all.end(), [&](const auto& p) { return p.name == path; });
  };
  bool again = false;
  for (const FitParameter& p : request_.parameters) {
    if (is_number(p.path) || !p.start) continue;
    set.push_back({p.path, shortest(*p.start)});
    again = true;
  }
  if (again) {
    graph_ = elaborate(model, set, report);
    if (!graph_ || report.error_count() > errors) return false;
    recorded_ = record(*graph_);
  }
  options_ = read_settings(*model, *graph_, report);
  if (!find_parameters(set, report) || !find_signals(report) || report.error_count() > errors) return false;

  const RunRequest& run = request_.run;
  if (run.solver) options_.solver = *run.solver;
  if (run.start) options_.start = *run.start;
  if (run.step) options_.step = *run.step;
  if (options_.solver == "ida") options_.solver = "bdf";  // the same equations, their unknowns found inside
  options_.rtol = run.rtol.value_or(fit_rtol);
  options_.atol = run.atol.value_or(1e-3 * options_.rtol);
  if (run.max_step) options_.max_step = *run.max_step;
  options_.sample_times = data().time;
  if (data().time.front() < options_.start) {
    report.error({}, "the data begin at {} s, before the run, which starts at {} s", data().time.front(),
                 options_.start);
    return false;
  }
  options_.stop = std::max(data().time.back(), std::nextafter(options_.start, unbounded));
  options_.output_interval = options_.stop - options_.start;  // the samples are all that is wanted

  for (const RecordedBound& bound : recorded_.bounds) compiling_.numbers.push_back(bound.value);
  compiling_.jacobian = options_.solver == "bdf";
  plain_ = plantloop::compile(recorded_.record, compiling_, report);
  if (!plain_) return false;
  if (request_.differences) {
    limits_.missing = {"they were asked for"};
    return true;
  }
  SensitivityRequest sensitivities;
  for (std::size_t k = 0; k < slots_.size(); ++k) sensitivities.parameters.push_back({slots_[k], scale_[k]});
  Report repeated;  // what it says has been said
  exact_ = compile_with_sensitivities(recorded_.record, compiling_, sensitivities, limits_, repeated);
  if (!exact_) report.append(std::move(repeated));
  return exact_ != nullptr;
}

bool FitModel::find_parameters(const Overrides& set, Report& report) {
  const std::size_t errors = report.error_count();
  if (request_.parameters.empty()) report.error({}, "the fit has no parameters");
  const auto& all = recorded_.record.parameters;
  std::vector<std::string> names;
  for (const RecordedParameter& p : all) names.push_back(p.name);
  for (const FitParameter& p : request_.parameters) {
    const auto at = static_cast<std::size_t>(std::find(names.begin(), names.end(), p.path) - names.begin());
    if (at == names.size()) {
      Finding& finding = report.error({}, "'{}' is no number of the diagram that can be fitted", p.path);
      if (const std::string near = nearest(p.path, names); !near.empty())
        finding.hint(fmt::format("did you mean '{}'?", near));
      if (!p.start) finding.hint("a default, or what the diagram writes as an expression, needs a start value");
      continue;
    }
    if (std::find(slots_.begin(), slots_.end(), at) != slots_.end()) {
      report.error({}, "the fit has '{}' twice", p.path);
      continue;
    }
    if (recorded_.uses[at] == ParameterUse::structural) {
      report.error({}, "'{}' shapes the diagram, as a size or a period does: it cannot be fitted", p.path);
      continue;
    }
    const double start = p.start.value_or(all[at].value);
    if (!(p.lower < p.upper))
      report.error({}, "'{}' has the bounds {} and {}: the lower one must be less", p.path, p.lower, p.upper);
    else if (!(start >= p.lower && start <= p.upper))
      report.error({}, "'{}' starts at {}, outside of its bounds {} and {}", p.path, start, p.lower, p.upper);
    slots_.push_back(static_cast<std::uint32_t>(at));
    start_.push_back(start);
    const double width = p.upper - p.lower;
    scale_.push_back(start != 0 ? std::fabs(start) : std::isfinite(width) ? 0.1 * width : 1);
  }
  for (const Override& o : set) {
    const auto value = parse_number(o.text);
    for (std::uint32_t i = 0; value && i < names.size(); ++i) {
      if (names[i] == o.path) others_.emplace_back(i, *value);
    }
  }
  return report.error_count() == errors;
}

bool FitModel::find_signals(Report& report) {
  const std::size_t errors = report.error_count();
  if (data().time.empty() || data().columns.empty()) {
    report.error({}, "there are no data to fit to");
    return false;
  }
  for (std::size_t i = 1; i < data().time.size(); ++i) {
    if (data().time[i] > data().time[i - 1]) continue;
    report.error({}, "the times of the data must ascend: {} s comes after {} s", data().time[i], data().time[i - 1]);
    break;
  }
  for (const FitData::Column& column : data().columns) {
    if (column.values.size() != data().time.size())
      report.error({}, "the data of '{}' have {} values, but there are {} times", column.signal, column.values.size(),
                   data().time.size());
    if (!(column.weight > 0) || !std::isfinite(column.weight))
      report.error({}, "the weight of '{}' is {}: it must be greater than 0", column.signal, column.weight);
    const auto found = signals_at(*graph_, recorded_.record, column.signal, "the signal", report);
    if (found.size() > 1)
      report.error({}, "'{}' has {} elements: each has data of its own, as '{}'", column.signal, found.size(),
                   found.front()->name);
    if (found.size() == 1) compiling_.watches.push_back(found.front()->value);
  }
  return report.error_count() == errors;
}

std::string FitModel::differences(bool moved) const {
  if (!limits_.missing.empty()) return list_of(limits_.missing);
  if (moved) return "events have times that move with a parameter: " + list_of(limits_.moving_guards);
  return {};
}

void FitModel::set(Frame& frame, const std::vector<double>& p) const {
  for (const auto& [slot, value] : others_) frame.set_parameter(slot, value);
  for (std::size_t k = 0; k < slots_.size(); ++k) frame.set_parameter(slots_[k], p[k]);
  execute(frame.program->parameter_list, frame.arena);
  for (std::size_t b = 0; b < recorded_.bounds.size(); ++b) {
    const RecordedBound& bound = recorded_.bounds[b];
    const double value = frame.arena[frame.program->numbers[b]];
    if (value >= bound.min && value <= bound.max && (value > bound.above || bound.above == -unbounded)) continue;
    throw RunError(fmt::format("'{}' is {}, outside of what it may be", bound.name, value));
  }
}

// The watched values at the times of the data, by watches.
std::vector<double> FitModel::run(const Program& program, const std::vector<double>& p, std::size_t watches,
                                  const std::atomic<bool>* cancel, bool& moved) const {
  ++runs_;
  Frame frame(&program == plain_.get() ? plain_ : exact_);
  set(frame, p);
  Recording recording;
  RunControl control;
  control.cancel = cancel;
  const RunStatistics statistics = simulate(frame, options_, std::vector<RecordedColumn>(watches), recording, control);
  moved = statistics.events > 0 && !limits_.moving_guards.empty();
  const std::size_t times = data().time.size();
  std::vector<double> values(watches * times, std::nan(""));
  auto sample = recording.samples.begin();
  for (std::size_t i = 0; i < times; ++i) {
    while (sample != recording.samples.end() && sample->time < data().time[i]) ++sample;
    if (sample == recording.samples.end() || sample->time != data().time[i] || sample->right.empty())
      throw RunError(fmt::format("the run ended before {} s, where there are data", data().time[i]));
    for (std::size_t w = 0; w < watches; ++w) values[w * times + i] = sample->right[w];
  }
  return values;
}

FitModel::Answer FitModel::by_sensitivities(const std::vector<double>& p, const std::atomic<bool>* cancel,
                                            bool& moved) const {
  const std::size_t n = outputs(), watches = data().columns.size();
  std::vector<double> values = run(*exact_, p, watches * (1 + slots_.size()), cancel, moved);
  Answer answer{{values.begin(), values.begin() + static_cast<std::ptrdiff_t>(n)}, DenseMatrix(n, slots_.size())};
  for (std::size_t k = 0; k < slots_.size(); ++k) {
    for (std::size_t i = 0; i < n; ++i) answer.slopes(i, k) = values[n * (k + 1) + i] / scale_[k];
  }
  return answer;
}

FitModel::Answer FitModel::by_differences(const std::vector<double>& p, const std::atomic<bool>* cancel) const {
  const std::size_t n = outputs(), watches = data().columns.size();
  bool moved = false;
  Answer answer{run(*plain_, p, watches, cancel, moved), DenseMatrix(n, slots_.size())};
  for (std::size_t k = 0; k < slots_.size(); ++k) {
    const FitParameter& parameter = request_.parameters[k];
    const double h = difference * std::max(std::fabs(p[k]), 1e-3 * scale_[k]);
    const auto at = [&](double change) {
      std::vector<double> q = p;
      q[k] += change;
      return run(*plain_, q, watches, cancel, moved);
    };
    const bool up = p[k] + h <= parameter.upper, down = p[k] - h >= parameter.lower;
    const double side = up ? h : -h;
    const std::vector<double> far = up && down ? at(-h) : at(2 * side), near = at(side);
    for (std::size_t i = 0; i < n; ++i) {
      answer.slopes(i, k) =
          up && down ? (near[i] - far[i]) / (2 * h) : (4 * near[i] - 3 * answer.y[i] - far[i]) / (2 * side);
    }
  }
  return answer;
}

FitModel::Answer FitModel::answer(const std::vector<double>& p, bool slopes, const std::atomic<bool>* cancel,
                                  bool& moved) const {
  if (limits_.missing.empty() && !moved) {
    Answer exact = by_sensitivities(p, cancel, moved);
    if (!moved) return exact;
  }
  if (slopes) return by_differences(p, cancel);
  bool ignored = false;
  return {run(*plain_, p, data().columns.size(), cancel, ignored), {}};
}

}  // namespace plantloop
