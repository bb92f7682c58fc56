// Levenberg and Marquardt's method with bounds: parameters on a bound that the cost pushes outwards stand still.

#include "engine/analysis/fit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <memory>
#include <set>

#include "engine/analysis/fit_model.h"
#include "engine/analysis/quantiles.h"
#include "engine/base/error.h"
#include "engine/base/parallel.h"
#include "engine/block_random.h"

namespace plantloop {

namespace {

constexpr double nothing = std::numeric_limits<double>::quiet_NaN();
constexpr double same_step = 1e-11;    // relative: the parameters stand
constexpr double same_cost = 1e-15;    // relative: what a step can still gain
constexpr double right_angle = 1e-11;  // cosine between residuals and what a parameter can change of them
constexpr double not_apart = 1e-9;     // of the singular values of the scaled slopes
constexpr double not_apart_by_differences = 1e-6;

struct Point {
  std::vector<double> p;
  std::vector<double> residuals;  // weighted, without those of missing data
  DenseMatrix slopes;             // of them
  double cost = 0;
};

double norm(const std::vector<double>& x) {
  double sum = 0;
  for (const double v : x) sum += v * v;
  return std::sqrt(sum);
}

// The experiments, each with a run of its own, as functions of the parameters that they share.
using Models = std::vector<std::unique_ptr<FitModel>>;

// Of each experiment: events have times that move, see FitModel::answer.
using Moved = std::deque<bool>;

class Search {
 public:
  Search(const Models& models, const FitRequest& request, const FitControl& control)
      : models_(models),
        request_(request),
        control_(control),
        n_(models.front()->parameters()),
        moved_(models.size(), false) {}

  struct Outcome {
    Point best;
    bool converged = false;
    int iterations = 0;
    Moved moved;
    std::string why;
  };

  // Throws RunError when nothing can be computed at the start.
  Outcome run(const std::vector<double>& start, bool tell) {
    Outcome o = from(start, tell);
    o.moved = moved_;
    return o;
  }

 private:
  Outcome from(const std::vector<double>& start, bool tell) {
    Outcome o;
    o.best = at(start);
    scale_.assign(n_, 0);
    double damping = 1e-3;
    for (; o.iterations < request_.most_iterations; ++o.iterations) {
      if (tell && control_.progress) control_.progress(o.iterations, o.best.cost);
      if (o.best.cost == 0) return finished(o, "the data are met exactly");
      choose_free(o.best);
      if (is_stationary(o.best)) return finished(o, "no parameter can lower the sum of squares any more");
      bool better = false;
      for (int attempt = 0; attempt < 40 && !better; ++attempt) {
        const std::vector<double> step = step_from(o.best, damping);
        const double gain = predicted_gain(o.best, step);
        const bool small = is_small(step, o.best.p);
        Point next;
        if (try_at(moved(o.best.p, step), next) && next.cost < o.best.cost) {
          better = true;
          const bool settled = o.best.cost - next.cost <= same_cost * o.best.cost && gain <= same_cost * o.best.cost;
          o.best = std::move(next);
          damping = std::max(damping / 10, 1e-14);
          if (small || settled) {
            ++o.iterations;
            return finished(o, small ? "the parameters stand to 11 digits" : "the sum of squares stands");
          }
        } else {
          if (small || gain <= same_cost * o.best.cost)
            return finished(o, "the parameters stand as exactly as the runs can tell");
          damping *= 10;
        }
      }
      if (!better) {
        o.why = "no step makes the sum of squares smaller, though the slopes promise it: they may not be smooth here";
        return o;
      }
    }
    o.why = fmt::format("{} iterations were not enough", request_.most_iterations);
    return o;
  }

  Outcome finished(Outcome& o, const char* why) {
    if (o.best.cost > 0) polish(o);
    o.converged = true;
    o.why = why;
    return std::move(o);
  }

  // At the minimum the sum of squares is flat: the last digits come from steps that it does not feel any more.
  void polish(Outcome& o) {
    constexpr int most_steps = 4;
    constexpr double rounding = 1e-12;
    for (int i = 0; i < most_steps; ++i) {
      choose_free(o.best);
      const std::vector<double> step = step_from(o.best, 0);
      Point next;
      if (is_small(step, o.best.p) || !try_at(moved(o.best.p, step), next)) return;
      if (!(next.cost <= o.best.cost * (1 + rounding))) return;
      o.best = std::move(next);
    }
  }

  Point at(const std::vector<double>& p) {
    Point point;
    point.p = p;
    std::vector<double> slopes;  // by rows
    for (std::size_t e = 0; e < models_.size(); ++e) {
      const FitModel::Answer answer = models_[e]->answer(p, true, control_.cancel, moved_[e]);
      const FitData& data = models_[e]->data();
      std::size_t row = 0;
      for (const FitData::Column& column : data.columns) {
        for (std::size_t i = 0; i < data.time.size(); ++i, ++row) {
          if (std::isnan(column.values[i])) continue;
          point.residuals.push_back(column.weight * (answer.y[row] - column.values[i]));
          point.cost += point.residuals.back() * point.residuals.back();
          for (std::size_t k = 0; k < n_; ++k) slopes.push_back(column.weight * answer.slopes(row, k));
        }
      }
    }
    point.slopes = DenseMatrix(point.residuals.size(), n_);
    for (std::size_t i = 0; i < point.residuals.size(); ++i)
      for (std::size_t k = 0; k < n_; ++k) point.slopes(i, k) = slopes[i * n_ + k];
    if (!std::isfinite(point.cost)) throw RunError("the fitted signals are not finite");
    return point;
  }

  bool try_at(const std::vector<double>& p, Point& point) {
    try {
      point = at(p);
      return true;
    } catch (const LimitError&) {
      throw;
    } catch (const RunError&) {
      return false;
    }
  }

  std::vector<double> column(const Point& point, std::size_t k) const {
    std::vector<double> values(point.residuals.size());
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = point.slopes(i, k);
    return values;
  }

  double gradient(const Point& point, std::size_t k) const {
    double sum = 0;
    for (std::size_t i = 0; i < point.residuals.size(); ++i) sum += point.slopes(i, k) * point.residuals[i];
    return sum;
  }

  void choose_free(const Point& point) {
    free_.clear();
    for (std::size_t k = 0; k < n_; ++k) {
      const FitParameter& parameter = request_.parameters[k];
      const double g = gradient(point, k);
      if ((point.p[k] <= parameter.lower && g >= 0) || (point.p[k] >= parameter.upper && g <= 0)) continue;
      free_.push_back(k);
      scale_[k] = std::max(scale_[k], norm(column(point, k)));
    }
  }

  bool is_stationary(const Point& point) const {
    const double size = std::sqrt(point.cost);
    for (const std::size_t k : free_) {
      const double length = norm(column(point, k));
      if (length > 0 && std::fabs(gradient(point, k)) > right_angle * length * size) return false;
    }
    return true;
  }

  std::vector<double> step_from(const Point& point, double damping) const {
    DenseMatrix slopes(point.residuals.size(), free_.size());
    std::vector<double> wanted(point.residuals.size()), by;
    for (std::size_t i = 0; i < wanted.size(); ++i) {
      wanted[i] = -point.residuals[i];
      for (std::size_t j = 0; j < free_.size(); ++j) slopes(i, j) = point.slopes(i, free_[j]);
    }
    for (const std::size_t k : free_) by.push_back(std::sqrt(damping) * (scale_[k] > 0 ? scale_[k] : 1));
    const std::vector<double> part = damped_least_squares(slopes, by, wanted);
    std::vector<double> step(n_, 0);
    for (std::size_t j = 0; j < free_.size(); ++j) step[free_[j]] = part[j];
    return step;
  }

  double predicted_gain(const Point& point, const std::vector<double>& step) const {
    double cost = 0;
    for (std::size_t i = 0; i < point.residuals.size(); ++i) {
      double r = point.residuals[i];
      for (std::size_t k = 0; k < n_; ++k) r += point.slopes(i, k) * step[k];
      cost += r * r;
    }
    return point.cost - cost;
  }

  std::vector<double> moved(std::vector<double> p, const std::vector<double>& step) const {
    for (std::size_t k = 0; k < n_; ++k)
      p[k] = std::min(std::max(p[k] + step[k], request_.parameters[k].lower), request_.parameters[k].upper);
    return p;
  }

  bool is_small(const std::vector<double>& step, const std::vector<double>& p) const {
    for (std::size_t k = 0; k < n_; ++k) {
      if (std::fabs(step[k]) > same_step * std::max(std::fabs(p[k]), 1e-3 * std::fabs(models_.front()->start()[k])))
        return false;
    }
    return true;
  }

  const Models& models_;
  const FitRequest& request_;
  const FitControl& control_;
  std::size_t n_;
  Moved moved_;
  std::vector<std::size_t> free_;
  std::vector<double> scale_;  // of the columns of the slopes, the largest so far
};

// Columns of length 1, of these parameters.
DenseMatrix scaled_columns(const Point& point, const std::vector<std::size_t>& of, std::vector<double>& lengths) {
  DenseMatrix scaled(point.residuals.size(), of.size());
  for (std::size_t j = 0; j < of.size(); ++j) {
    double sum = 0;
    for (std::size_t i = 0; i < scaled.rows; ++i) sum += point.slopes(i, of[j]) * point.slopes(i, of[j]);
    lengths.push_back(std::sqrt(sum));
    for (std::size_t i = 0; i < scaled.rows; ++i) scaled(i, j) = point.slopes(i, of[j]) / lengths.back();
  }
  return scaled;
}

// Why derivatives are differences in some experiment; "" while they are exact in all.
std::string differences_of(const Models& models, const Moved& moved) {
  for (std::size_t e = 0; e < models.size(); ++e) {
    if (std::string why = models[e]->differences(moved[e]); !why.empty()) return why;
  }
  return {};
}

// False after reporting parameters that change nothing, or that cannot be told apart.
bool can_be_determined(const Models& models, const FitRequest& request, const Search::Outcome& found, Report& report) {
  const Point& point = found.best;
  const std::size_t errors = report.error_count();
  std::vector<std::size_t> all(request.parameters.size());
  std::set<std::string> signals;
  for (const auto& model : models)
    for (const FitData::Column& column : model->data().columns) signals.insert(column.signal);
  for (std::size_t k = 0; k < all.size(); ++k) {
    all[k] = k;
    bool matters = false;
    for (std::size_t i = 0; i < point.residuals.size(); ++i) matters = matters || point.slopes(i, k) != 0;
    if (!matters)
      report.error({}, "'{}' does not change any of the fitted signals: {}", request.parameters[k].path,
                   fmt::join(signals, ", "));
  }
  if (report.error_count() > errors) return false;
  std::vector<double> lengths;
  const WeakDirection weak = weakest_direction(scaled_columns(point, all, lengths));
  if (weak.ratio > (differences_of(models, found.moved).empty() ? not_apart : not_apart_by_differences)) return true;
  std::vector<std::string> names;
  for (std::size_t k = 0; k < all.size(); ++k) {
    if (std::fabs(weak.direction[k]) > 0.1) names.push_back("'" + request.parameters[k].path + "'");
  }
  report
      .error({}, "the data do not tell {} apart: they can change together without changing the fitted signals",
             fmt::join(names, " and "))
      .hint("leave one of them out, or add data that depend on them in another way");
  return false;
}

void estimate(const FitRequest& request, const Point& best, FitResult& result) {
  const std::size_t n = request.parameters.size();
  std::vector<std::size_t> free;
  for (std::size_t k = 0; k < n; ++k) {
    FitResult::Estimate& e = result.parameters[k];
    e.value = best.p[k];
    e.on_bound = e.value <= request.parameters[k].lower || e.value >= request.parameters[k].upper;
    e.deviation = nothing;
    e.lower = e.upper = e.on_bound ? e.value : nothing;
    if (!e.on_bound) free.push_back(k);
  }
  result.values = best.residuals.size();
  result.degrees = result.values - free.size();
  result.covariance = DenseMatrix(n, n);
  result.correlation = DenseMatrix(n, n);
  std::vector<double> lengths;
  const DenseMatrix covariance = covariance_of(scaled_columns(best, free, lengths));
  const double variance = request.absolute     ? 1
                          : result.degrees > 0 ? best.cost / static_cast<double>(result.degrees)
                                               : nothing;
  const double quantile = request.absolute ? normal_quantile(0.5 + 0.5 * request.confidence)
                                           : student_quantile(request.confidence, static_cast<double>(result.degrees));
  for (std::size_t i = 0; i < free.size(); ++i) {
    for (std::size_t j = 0; j < free.size(); ++j) {
      result.covariance(free[i], free[j]) = variance * covariance(i, j) / (lengths[i] * lengths[j]);
      result.correlation(free[i], free[j]) =
          i == j ? 1 : covariance(i, j) / std::sqrt(covariance(i, i) * covariance(j, j));
    }
    FitResult::Estimate& e = result.parameters[free[i]];
    e.deviation = std::sqrt(result.covariance(free[i], free[i]));
    e.lower = e.value - quantile * e.deviation;
    e.upper = e.value + quantile * e.deviation;
  }
}

void describe_columns(const FitModel& model, std::size_t experiment, const Search::Outcome& found, FitResult& result) {
  bool moved = found.moved[experiment];
  const FitModel::Answer answer = model.answer(found.best.p, false, nullptr, moved);
  const FitData& data = model.data();
  const std::size_t times = data.time.size();
  for (std::size_t c = 0; c < data.columns.size(); ++c) {
    const FitData::Column& column = data.columns[c];
    FitResult::Column described;
    described.signal = column.signal;
    described.experiment = experiment;
    double sum = 0;
    for (std::size_t i = 0; i < times; ++i) {
      described.fitted.push_back(answer.y[c * times + i]);
      if (std::isnan(column.values[i])) continue;
      ++described.values;
      sum += (described.fitted.back() - column.values[i]) * (described.fitted.back() - column.values[i]);
    }
    described.rms = std::sqrt(sum / static_cast<double>(std::max<std::size_t>(described.values, 1)));
    result.columns.push_back(std::move(described));
  }
}

// Nothing after reporting what is wrong.
std::optional<Models> models_of(const std::shared_ptr<const Model>& model, const FitRequest& request, Report& report) {
  if (request.experiments.empty()) report.error({}, "there are no data to fit to");
  Models models;
  std::size_t values = 0;
  for (const FitExperiment& experiment : request.experiments) {
    models.push_back(FitModel::make(model, request, experiment, report));
    if (!models.back()) return std::nullopt;
    for (const FitData::Column& column : experiment.data.columns)
      for (const double v : column.values) values += std::isnan(v) ? 0 : 1;
  }
  if (models.empty()) return std::nullopt;
  if (values >= request.parameters.size()) return models;
  report.error({}, "{} values cannot determine {} parameters", values, request.parameters.size());
  return std::nullopt;
}

// The first start is the given one; the others are drawn.
std::optional<std::vector<std::vector<double>>> starts_of(const FitModel& model, const FitRequest& request,
                                                          Report& report) {
  std::vector<std::vector<double>> starts{model.start()};
  for (std::size_t s = 1; s < request.starts; ++s) {
    std::vector<double> p;
    for (std::size_t k = 0; k < request.parameters.size(); ++k) {
      const FitParameter& parameter = request.parameters[k];
      if (!std::isfinite(parameter.lower) || !std::isfinite(parameter.upper)) {
        report.error({}, "further starts are drawn within the bounds: '{}' needs a lower and an upper one",
                     parameter.path);
        return std::nullopt;
      }
      const double u = uniform_number(request.seed, s, k, 0);
      p.push_back(parameter.lower + (parameter.upper - parameter.lower) * u);
    }
    starts.push_back(std::move(p));
  }
  return starts;
}

}  // namespace

std::optional<FitResult> fit(const std::shared_ptr<const Model>& model, const FitRequest& request, Report& report,
                             const FitControl& control) {
  const auto models = models_of(model, request, report);
  if (!models) return std::nullopt;
  const auto starts = starts_of(*models->front(), request, report);
  if (!starts) return std::nullopt;
  std::vector<std::optional<Search::Outcome>> outcomes(starts->size());
  std::vector<std::exception_ptr> failures(starts->size());
  in_parallel(starts->size(), thread_count(request.threads), [&](std::size_t s) {
    try {
      outcomes[s] = Search(*models, request, control).run((*starts)[s], s == 0);
    } catch (const LimitError&) {
      throw;
    } catch (const RunError&) {
      failures[s] = std::current_exception();
    }
  });
  FitResult result;
  std::size_t best = starts->size();
  for (std::size_t s = 0; s < outcomes.size(); ++s) {
    result.costs.push_back(outcomes[s] ? outcomes[s]->best.cost : nothing);
    if (outcomes[s] && (best == starts->size() || outcomes[s]->best.cost < outcomes[best]->best.cost)) best = s;
  }
  if (best == starts->size()) std::rethrow_exception(failures.front());
  const Search::Outcome& found = *outcomes[best];
  if (!can_be_determined(*models, request, found, report)) return std::nullopt;
  for (std::size_t k = 0; k < request.parameters.size(); ++k)
    result.parameters.push_back({request.parameters[k].path, (*starts)[best][k]});
  result.cost = found.best.cost;
  result.converged = found.converged;
  result.iterations = found.iterations;
  result.why = found.why;
  estimate(request, found.best, result);
  result.experiments = models->size();
  for (std::size_t e = 0; e < models->size(); ++e) {
    describe_columns(*(*models)[e], e, found, result);
    result.runs += (*models)[e]->runs();
  }
  const std::string differences = differences_of(*models, found.moved);
  result.gradient = differences.empty() ? "exact" : "differences: " + differences;
  return result;
}

}  // namespace plantloop
