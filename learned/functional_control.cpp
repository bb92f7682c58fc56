// The search of predictive functional control: candidates, then bisection or least squares.

#include "learned/functional_control.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "identify/error.h"
#include "learned/narx_predictor.h"
#include "learned/reference_trajectory.h"

namespace plantloop {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using identify::GpMap;
using identify::LoadedModel;

namespace {

double power(double value, int exponent) {
  double result = 1;
  for (int i = 0; i < exponent; ++i) result *= value;
  return result;
}

}  // namespace

std::string FunctionalControlKernel::why_not(const LoadedModel& model, const FunctionalControl& how) {
  if (!model.dynamic) return why_no_predictor(model);
  const identify::RegressorSet& set = model.narx.regressors;
  if (set.inputs.size() != 1 || set.outputs.size() != 1)
    return fmt::format("the model has {} inputs and {} outputs; the controller is for one of each", set.inputs.size(),
                       set.outputs.size());
  if (std::string why = why_no_predictor(model); !why.empty()) return why;
  const bool certain = how.propagation == identify::Propagation::naive;
  if (!model.map->has_variance()) {
    if (how.limits_variance)
      return fmt::format("only a Gaussian process knows how uncertain it is, this is '{}'", model.map->type());
    if (!certain) return fmt::format("there is no uncertainty to carry along: the model is '{}'", model.map->type());
  }
  if (certain) return {};
  try {
    identify::UncertainRun(std::dynamic_pointer_cast<const GpMap>(model.map), set, how.propagation);
  } catch (const identify::IdentifyError& error) {
    return error.what();
  }
  return {};
}

FunctionalControlKernel::FunctionalControlKernel(std::shared_ptr<const LoadedModel> model, FunctionalControl how)
    : model_(std::move(model)), how_(std::move(how)), rows_(model_->narx.regressors) {
  if (const auto gp = std::dynamic_pointer_cast<const GpMap>(model_->map)) {
    noise_variance_ = gp->noise_variance(0);
    if (how_.propagation != identify::Propagation::naive)
      uncertain_.emplace(gp, model_->narx.regressors, how_.propagation);
  }
}

int FunctionalControlKernel::scratch_size() const { return model_->map->scratch_size(); }

// One sample's search.
class FunctionalControlKernel::Move {
 public:
  Move(const FunctionalControlKernel& kernel, const KernelCall& call)
      : k_(kernel), map_(*kernel.model_->map), scratch_(call.scratch) {
    const double* in = call.in;
    const auto take = [&](int count) { return std::exchange(in, in + count); };
    const double* const w = take(how().set_points);
    const double y = *take(1);
    lower_ = *take(1);
    upper_ = *take(1);
    const double change = *take(1);
    variance_limit_ = how().limits_variance ? *in : std::numeric_limits<double>::infinity();
    take(1);
    const double lambda = *take(1), r = *take(1);
    const double* const past_u = take(k_.past_inputs());
    const double* const past_y = take(k_.past_outputs());
    const double* const model_y = take(k_.past_outputs());

    const Span next = reachable(past_u[0], change, lower_, upper_);
    least_ = next.least;
    most_ = next.most;
    correction_ = how().correction ? y - model_y[0] : 0;
    const double base = how().from_reference ? r : y;
    for (const int h : how().coincidence) {
      const double to = how().set_points == 1 ? w[0] : w[h];
      target_.push_back(reference_at(h, to, w[0], lambda, base) - correction_);
    }
    next_reference_ = next_reference(w[0], lambda, r);

    // Oldest first, so that time runs along the arrays.
    const int horizon = how().coincidence.back();
    inputs_.resize(static_cast<std::size_t>(k_.past_inputs() + horizon));
    outputs_.resize(static_cast<std::size_t>(k_.past_outputs() + horizon));
    own_outputs_.resize(static_cast<std::size_t>(k_.past_outputs()));
    for (int i = 0; i < k_.past_inputs(); ++i) inputs_[at(k_.past_inputs() - 1 - i)] = past_u[i];
    for (int i = 0; i < k_.past_outputs(); ++i) {
      own_outputs_[at(k_.past_outputs() - 1 - i)] = model_y[i];
      outputs_[at(k_.past_outputs() - 1 - i)] = how().correction ? model_y[i] : i == 0 ? y : past_y[i - 1];
    }
    x_.resize(kernel.model_->narx.regressors.list.size());
    slope_.resize(x_.size());
  }

  void solve(double* out) {
    VectorXd c = VectorXd::Zero(how().basis);
    c[0] = nearest_constant();
    Status status = Status::met;
    if (!how().refines || (how().basis == 1 && target_.size() == 1)) {
      status = meets_ ? Status::met : Status::at_limit;
    } else {
      refine(c);
      const double first = std::clamp(c[0], least_, most_);
      status = c[0] == first && is_inside(c) ? Status::met : Status::at_limit;
      c[0] = first;
    }
    double variance = predict_with_variance(c);
    if (variance > variance_limit_) {
      status = limit_variance(c);
      variance = predict_with_variance(c);
    }
    out[Result::input] = c[0];
    out[Result::deviation] = map_.has_variance() ? std::sqrt(std::max(variance, 0.0)) : 0;
    out[Result::status] = status;
    out[Result::model_output] = next_of_model(c[0]);
    out[Result::reference] = next_reference_;
  }

 private:
  const FunctionalControl& how() const { return k_.how_; }
  static std::size_t at(int i) { return static_cast<std::size_t>(i); }

  // The regressors of y(k + step + 1).
  void row(const std::vector<double>& outputs, int step) {
    k_.rows_.row(&inputs_[at(k_.past_inputs() + step)], &outputs[at(k_.past_outputs() - 1 + step)], x_.data());
  }
  double next_of_model(double u) {
    inputs_[at(k_.past_inputs())] = u;
    row(own_outputs_, 0);
    double y = 0;
    map_.evaluate(x_.data(), &y, scratch_);
    return y;
  }
  double input_of(const VectorXd& c, int step) const {
    double value = 0;
    for (auto i = c.size() - 1; i >= 0; --i) value = value * step + c[i];
    return value;
  }
  void set_inputs(const VectorXd& c) {
    for (int j = 0; j < how().coincidence.back(); ++j)
      inputs_[at(k_.past_inputs() + j)] = std::clamp(input_of(c, j), lower_, upper_);
  }
  bool is_inside(const VectorXd& c) const {
    for (int j = 0; j < how().coincidence.back(); ++j) {
      const double u = input_of(c, j);
      if (u < lower_ || u > upper_) return false;
    }
    return true;
  }

  // Fills the outputs to come.
  void predict(const VectorXd& c) {
    set_inputs(c);
    const int horizon = how().coincidence.back();
    if (k_.uncertain_) {
      predict_uncertain(horizon);
      return;
    }
    for (int j = 0; j < horizon; ++j) {
      row(outputs_, j);
      map_.evaluate(x_.data(), &outputs_[at(k_.past_outputs() + j)], scratch_);
    }
  }
  // The same, and the variance of a measurement at the last point.
  double predict_with_variance(const VectorXd& c) {
    if (k_.uncertain_) {
      set_inputs(c);
      return predict_uncertain(how().coincidence.back());
    }
    predict(c);
    if (!map_.has_variance()) return 0;
    double variance = 0;
    map_.variance(x_.data(), &variance, scratch_);
    return variance + k_.noise_variance_;
  }
  double predict_uncertain(int horizon) {
    const identify::UncertainRun& run = *k_.uncertain_;
    std::vector<double> state(at(run.state_size()), 0.0), next(state.size());
    for (int i = 0; i < run.depth(); ++i) state[at(i)] = outputs_[at(k_.past_outputs() - 1 - i)];
    double variance = 0;
    for (int j = 0; j < horizon; ++j) {
      row(outputs_, j);
      const identify::UncertainRun::Step step = run.predict(x_.data(), state.data());
      outputs_[at(k_.past_outputs() + j)] = step.mean[0];
      variance = step.covariance(0, 0);
      run.advance(step, state.data(), next.data());
      state.swap(next);
    }
    return variance + k_.noise_variance_;
  }
  double residual(std::size_t point) const {
    return outputs_[at(k_.past_outputs() - 1 + how().coincidence[point])] - target_[point];
  }
  double cost() const {
    double sum = 0;
    for (std::size_t i = 0; i < target_.size(); ++i) sum += residual(i) * residual(i);
    return sum;
  }
  VectorXd constant(double u) const {
    VectorXd c = VectorXd::Zero(how().basis);
    c[0] = u;
    return c;
  }
  double candidate(int i) const { return least_ + (most_ - least_) * i / (how().candidates - 1); }
  // Of constant inputs the one that meets the last target, of several the least in magnitude; where none does, that of
  // the least cost.
  double nearest_constant() {
    const std::size_t last = target_.size() - 1;
    double best = least_, least_cost = std::numeric_limits<double>::infinity(), before = 0;
    std::optional<double> root;
    const auto offer = [&](double u) {
      if (!root || std::abs(u) < std::abs(*root)) root = u;
    };
    for (int i = 0; i < how().candidates; ++i) {
      const double u = candidate(i);
      predict(constant(u));
      const double g = residual(last);
      if (const double one = cost(); one < least_cost) {
        least_cost = one;
        best = u;
      }
      const bool passes = i > 0 && g * before < 0;
      meets_ = meets_ || g == 0 || passes;
      if (g == 0) {
        offer(u);
      } else if (how().refines && passes) {
        offer(bisect(candidate(i - 1), u, before, last));
      }
      before = g;
      if (least_ == most_) break;
    }
    return root && target_.size() == 1 ? *root : best;
  }
  double bisect(double a, double b, double at_a, std::size_t point) {
    constexpr double narrow = 1e-12;
    while (b - a > narrow * std::max(1.0, std::abs(a))) {
      const double middle = 0.5 * (a + b);
      if (middle <= a || middle >= b) break;
      predict(constant(middle));
      const double g = residual(point);
      if (g == 0) return middle;
      (g * at_a < 0 ? b : a) = middle;
    }
    return 0.5 * (a + b);
  }

  // Residuals by the coefficients, along the prediction that was made last (first order, exact).
  MatrixXd jacobian(const VectorXd& c) {
    const int horizon = how().coincidence.back(), count = static_cast<int>(c.size());
    const auto zeros = [count](int rows) { return std::vector<double>(at(rows * count), 0.0); };
    std::vector<double> by_outputs = zeros(k_.past_outputs() + horizon), by_inputs = zeros(k_.past_inputs() + horizon);
    for (int j = 0; j < horizon; ++j) {
      const double u = input_of(c, j);
      if (u < lower_ || u > upper_) continue;
      for (int b = 0; b < count; ++b) by_inputs[at((k_.past_inputs() + j) * count + b)] = power(j, b);
    }
    for (int j = 0; j < horizon; ++j) {
      row(outputs_, j);
      map_.derivative(x_.data(), slope_.data(), scratch_);
      const int u = k_.past_inputs() + j, y = k_.past_outputs() - 1 + j;
      for (int r = 0; r < k_.rows_.size(); ++r)
        k_.rows_.add_slope(r, slope_[at(r)], &inputs_[at(u)], &outputs_[at(y)], &by_inputs[at(u * count)],
                           &by_outputs[at(y * count)], count, &by_outputs[at((y + 1) * count)]);
    }
    MatrixXd J(static_cast<Eigen::Index>(target_.size()), c.size());
    for (std::size_t i = 0; i < target_.size(); ++i) {
      const int row = k_.past_outputs() - 1 + how().coincidence[i];
      for (int b = 0; b < count; ++b) J(static_cast<Eigen::Index>(i), b) = by_outputs[at(row * count + b)];
    }
    return J;
  }

  // Levenberg and Marquardt's method from the best constant input on.
  void refine(VectorXd& c) {
    predict(c);
    double now = cost(), damping = 1e-3;
    constexpr int most_steps = 50;
    for (int i = 0; i < most_steps && now > 0; ++i) {
      predict(c);
      VectorXd r(static_cast<Eigen::Index>(target_.size()));
      for (std::size_t p = 0; p < target_.size(); ++p) r[static_cast<Eigen::Index>(p)] = residual(p);
      const MatrixXd J = jacobian(c);
      const VectorXd gradient = J.transpose() * r;
      MatrixXd H = J.transpose() * J;
      H.diagonal() += damping * H.diagonal() + VectorXd::Constant(c.size(), 1e-12 * (1 + H.trace()));
      const VectorXd to = c - H.ldlt().solve(gradient);
      predict(to);
      const double then = cost();
      if (then < now) {
        const bool done = (to - c).norm() <= 1e-12 * (1 + c.norm());
        c = to;
        now = then;
        damping = std::max(damping / 10, 1e-12);
        if (done) return;
      } else {
        damping *= 10;
        if (damping > 1e8) return;
      }
    }
  }

  // The constant input of the least cost whose variance keeps the limit, moved to that limit; else that of the least
  // variance.
  Status limit_variance(VectorXd& c) {
    int best = -1, surest = 0;
    double least_cost = std::numeric_limits<double>::infinity(), least = least_cost;
    for (int i = 0; i < how().candidates; ++i) {
      const double variance = predict_with_variance(constant(candidate(i)));
      if (variance < least) {
        least = variance;
        surest = i;
      }
      if (variance <= variance_limit_ && cost() < least_cost) {
        least_cost = cost();
        best = i;
      }
    }
    if (best < 0) {
      c = constant(candidate(surest));
      return Status::too_uncertain;
    }
    c = constant(how().refines ? at_variance_limit(best, least_cost) : candidate(best));
    return Status::at_variance;
  }

  // From the best candidate towards a better one beside it that breaks the limit, as far as the limit allows.
  double at_variance_limit(int best, double least_cost) {
    for (const int beside : {best - 1, best + 1}) {
      if (beside < 0 || beside >= how().candidates) continue;
      double inside = candidate(best), outside = candidate(beside);
      const double variance = predict_with_variance(constant(outside));
      if (cost() >= least_cost || variance <= variance_limit_) continue;
      constexpr int halvings = 40;
      for (int i = 0; i < halvings; ++i) {
        const double middle = 0.5 * (inside + outside);
        (predict_with_variance(constant(middle)) <= variance_limit_ ? inside : outside) = middle;
      }
      return inside;
    }
    return candidate(best);
  }

  const FunctionalControlKernel& k_;
  const identify::Approximator& map_;
  double* scratch_;
  double lower_ = 0, upper_ = 0;  // of all inputs to come
  double least_ = 0, most_ = 0;   // of the next one
  bool meets_ = false;            // some constant input meets the last target
  double variance_limit_ = 0, correction_ = 0, next_reference_ = 0;
  std::vector<double> target_;
  std::vector<double> inputs_, outputs_, own_outputs_, x_, slope_;
};

std::vector<std::string> FunctionalControlKernel::status_words() const {
  return {"the reference met", "the input at a limit", "the predicted variance at its limit",
          "no input that keeps the limit on the variance"};
}

void FunctionalControlKernel::evaluate(const KernelCall& call) const { Move(*this, call).solve(call.out); }

}  // namespace plantloop
