// What a careful engineer says about data before a fit.

#include "identify/data/advice.h"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <set>

#include "identify/data/preprocess.h"
#include "identify/data/undetermined.h"
#include "identify/error.h"
#include "identify/linear/arx.h"
#include "identify/linear/order.h"
#include "identify/spectra/spectra.h"
#include "identify/validation/correlation.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// "1 sample", "3 samples"
std::string some(auto count, const char* what) { return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s"); }

class Adviser {
 public:
  explicit Adviser(const DataSet& data) : data_(data) {}

  std::vector<std::string> all() {
    say("{} of {} and {} in {}, one each {:.6g} s", some(data_.samples(), "sample"), some(data_.inputs.size(), "input"),
        some(data_.outputs.size(), "output"), some(data_.experiments.size(), "experiment"), data_.Ts);
    if (data_.samples() < 100) say("there are few samples: fits will be uncertain, and little can be held back");
    gaps();
    for (const bool output : {false, true}) {
      const auto& channels = output ? data_.outputs : data_.inputs;
      for (std::size_t i = 0; i < channels.size(); ++i) {
        signal(channels[i].name, (output ? data_.all_y() : data_.all_u()).col(static_cast<Index>(i)), output);
      }
    }
    if (data_.inputs.empty()) say("there is no input: only models of the outputs' own past are possible");
    if (data_.missing() > 0 || data_.samples() < 30) return std::move(lines_);
    for (std::size_t i = 0; i < data_.inputs.size(); ++i) excitation(i);
    if (inputs_are_one()) return std::move(lines_);
    for (std::size_t o = 0; o < data_.outputs.size(); ++o) dynamics(o);
    return std::move(lines_);
  }

 private:
  template <typename... Args>
  void say(fmt::format_string<Args...> text, Args&&... args) {
    lines_.push_back(fmt::format(text, std::forward<Args>(args)...));
  }

  void gaps() {
    const Index missing = data_.missing();
    if (missing == 0) return;
    say("{} missing: least squares leaves the rows out that touch them; fill the gaps, or cut the data "
        "there, for spectra, filters and searches",
        missing == 1 ? "1 value is" : fmt::format("{} values are", missing));
  }

  static std::vector<double> present(const VectorXd& x) {
    std::vector<double> values;
    for (const double v : x) {
      if (!std::isnan(v)) values.push_back(v);
    }
    return values;
  }

  static double median(std::vector<double> x) {
    std::nth_element(x.begin(), x.begin() + static_cast<long>(x.size() / 2), x.end());
    return x[x.size() / 2];
  }

  void signal(const std::string& name, const VectorXd& column, bool output) {
    const std::vector<double> x = present(column);
    if (x.size() < 2) return say("'{}' has no values", name);
    const auto [least, most] = std::minmax_element(x.begin(), x.end());
    if (*least == *most) {
      return output ? say("'{}' does not vary: there is nothing to model", name)
                    : say("'{}' does not vary: its effect cannot be identified; leave it out", name);
    }
    const std::set<double> levels(x.begin(), x.end());
    if (!output && levels.size() == 2) {
      say("'{}' has two levels: good for linear models, but nothing nonlinear in it can be seen", name);
    } else {
      limits(name, x, *least, *most);
      if (output && levels.size() < 30) {
        say("'{}' has only {} different values: its resolution limits what can be reached", name, levels.size());
      }
    }
    if (output) offset(name, x);
    if (output || levels.size() > 50) outliers(name, column);
    drift(name, x, *most - *least, output);
  }

  void limits(const std::string& name, const std::vector<double>& x, double least, double most) {
    for (const double end : {least, most}) {
      // Two or more in a row at the very end of the range, 5 % of the samples: a saturation.
      Index at_end = 0;
      for (std::size_t k = 1; k < x.size(); ++k) at_end += x[k] == end && x[k - 1] == end ? 1 : 0;
      if (static_cast<double>(at_end) > 0.05 * static_cast<double>(x.size())) {
        say("'{}' stays at its {} {:.6g} for {:.0f} % of the samples: is it limited there?", name,
            end == least ? "least value" : "greatest value", end,
            100 * static_cast<double>(at_end) / static_cast<double>(x.size()));
      }
    }
  }

  // Samples far from the mean of their neighbours, in robust deviations of that difference.
  void outliers(const std::string& name, const VectorXd& x) {
    std::vector<double> differences;
    for (Index k = 1; k + 1 < x.size(); ++k) {
      const double d = x[k] - (x[k - 1] + x[k + 1]) / 2;
      if (!std::isnan(d)) differences.push_back(std::fabs(d));
    }
    if (differences.size() < 20) return;
    const double robust = 1.4826 * median(differences);
    if (!(robust > 0)) return;
    const auto far = std::count_if(differences.begin(), differences.end(), [&](double d) { return d > 10 * robust; });
    // A lone value makes three such differences; many are steps, not outliers.
    if (far > 0 && static_cast<double>(far) < 0.005 * static_cast<double>(differences.size()) + 3) {
      say("'{}' has {} samples that stand far from their neighbours (more than 10 robust deviations): outliers?", name,
          far);
    }
  }

  // A linear model without a constant is 0 at rest.
  void offset(const std::string& name, const std::vector<double>& x) {
    double mean = 0, squares = 0;
    for (const double v : x) mean += v / static_cast<double>(x.size());
    for (const double v : x) squares += (v - mean) * (v - mean) / static_cast<double>(x.size());
    if (std::fabs(mean) > 2 * std::sqrt(squares))
      say("'{}' lies about {:.4g} and varies by {:.3g} there: a linear model needs a constant for that, offset = true, "
          "or "
          "the means removed, remove_means = true",
          name, mean, std::sqrt(squares));
  }

  // Nothing more can be said of inputs that carry the same signal.
  bool inputs_are_one() {
    bool found = false;
    for (const std::string& line : undetermined(data_)) {
      if (line.find("carry the same signal") == std::string::npos) continue;
      say("{}; leave one of them out", line);
      found = true;
    }
    return found;
  }

  void drift(const std::string& name, const std::vector<double>& x, double range, bool output) {
    if (!output || x.size() < 100) return;
    const auto mean = [](auto begin, auto end) {
      double sum = 0;
      for (auto at = begin; at != end; ++at) sum += *at;
      return sum / static_cast<double>(end - begin);
    };
    const auto quarter = static_cast<long>(x.size() / 4);
    const double change = mean(x.end() - quarter, x.end()) - mean(x.begin(), x.begin() + quarter);
    if (std::fabs(change) > 0.25 * range) {
      say("'{}' drifts: the mean of its last quarter differs by {:.3g} from that of the first; remove a line, or model "
          "what drives it",
          name, change);
    }
  }

  void excitation(std::size_t i) {
    const int highest = static_cast<int>(std::min<Index>(20, data_.samples() / 5));
    const int order = excitation_order(data_, i, highest);
    if (order >= highest || order == 0) return;
    say("'{}' excites only {} parameters: it is too slow or too poor for a model of higher order", data_.inputs[i].name,
        order);
  }

  void dynamics(std::size_t o) {
    if (data_.inputs.empty()) return;
    const auto most =
        static_cast<int>(std::min<Index>(240, data_.samples() / (4 * static_cast<Index>(data_.inputs.size()) + 4)));
    if (most < 4) return;
    int length = std::min(30, most);
    std::vector<int> delays = impulse_delays(data_, o, length);
    // An effect that is not seen may come later.
    while (length < most && std::any_of(delays.begin(), delays.end(), [](int d) { return d < 0; })) {
      length = std::min(2 * length, most);
      delays = impulse_delays(data_, o, length);
    }
    for (std::size_t i = 0; i < delays.size(); ++i) {
      if (delays[i] < 0) {
        say("no effect of '{}' on '{}' is seen within {}", data_.inputs[i].name, data_.outputs[o].name,
            some(length, "sample"));
      } else {
        say("'{}' acts on '{}' after about {}", data_.inputs[i].name, data_.outputs[o].name, some(delays[i], "sample"));
      }
    }
    sampling(o);
    feedback(o);
  }

  // From the slowest pole of an ARX model of order 2 about the means; of order 1 where 2 is not determined.
  void sampling(std::size_t o) {
    const LinearOptions options{.output = data_.outputs[o].name, .remove_means = true};
    PolynomialModel model = fit_linear(data_, {.na = 2, .nb = {2}, .nf = {}, .delay = {0}}, options);
    if (!model.fit.warnings.empty()) model = fit_linear(data_, {.na = 1, .nb = {1}, .nf = {}, .delay = {0}}, options);
    const Eigen::VectorXcd z = to_state_space(model).poles();
    double slowest = 0;
    for (const auto& pole : z) slowest = std::max(slowest, std::abs(pole));
    if (slowest <= 0) return;
    const double constant = slowest < 1 ? -data_.Ts / std::log(slowest) : HUGE_VAL;
    const double record =
        data_.Ts * static_cast<double>(data_.samples()) / static_cast<double>(data_.experiments.size());
    if (constant > record) {
      say("'{}' integrates or drifts: its slowest time constant is longer than the record ({:.3g} s)",
          data_.outputs[o].name, record);
      return;
    }
    if (constant > 50 * data_.Ts) {
      say("'{}' is sampled fast: its slowest time constant is about {:.3g} s, {:.0f} samples; keep every {:.0f}th "
          "sample or fit the free run, as one-step errors say little",
          data_.outputs[o].name, constant, constant / data_.Ts, std::max(2.0, std::floor(constant / data_.Ts / 15)));
    } else if (constant < data_.Ts) {
      say("'{}' is sampled slowly: its slowest time constant is about {:.3g} s, less than a sample",
          data_.outputs[o].name, constant);
    }
  }

  // Residuals of a long ARX model that later inputs follow.
  void feedback(std::size_t o) {
    const LinearOptions options{.output = data_.outputs[o].name, .remove_means = true};
    const int n =
        static_cast<int>(std::min<Index>(10, data_.samples() / (8 * static_cast<Index>(data_.inputs.size() + 1))));
    if (n < 2) return;
    const PolynomialModel model = fit_linear(data_, {.na = n, .nb = {n}, .nf = {}, .delay = {-1}}, options);
    const Series e = residuals(model, data_);
    for (std::size_t i = 0; i < data_.inputs.size(); ++i) {
      Signals u;
      Signals tail;
      for (std::size_t x = 0; x < e.size(); ++x) {
        const Index skip = std::min<Index>(n, e[x].size());
        tail.emplace_back(e[x].tail(e[x].size() - skip));
        u.emplace_back(data_.experiments[x].u.col(static_cast<Index>(i)).tail(e[x].size() - skip));
      }
      const Correlation c = cross_correlation(tail, u, 10);
      double largest = 0;
      for (Index k = 0; k < 10; ++k) largest = std::max(largest, std::fabs(c.r[k]));
      if (largest > 3 * c.band95) {
        say("'{}' follows what '{}' did before (correlation {:.2f}): the data come from a closed loop; spectra and "
            "correlations of input and output are biased, prediction error methods with a noise model are not",
            data_.inputs[i].name, data_.outputs[o].name, largest);
      }
    }
  }

  const DataSet& data_;
  std::vector<std::string> lines_;
};

}  // namespace

std::vector<int> impulse_delays(const DataSet& data, std::size_t output, int length) {
  const LinearOptions options{.output = data.outputs.at(output).name, .remove_means = true};
  // A short past of the output whitens the noise, so that the deviations mean what they say.
  const int na = std::min(2, length);
  const PolynomialModel model = fit_linear(data, {.na = na, .nb = {length}, .nf = {}, .delay = {-1}}, options);
  std::vector<int> delays;
  Index at = na;
  for (const VectorXd& b : model.B) {
    const double rounding = 1e-6 * b.cwiseAbs().maxCoeff();  // of data without noise
    const auto first_above = [&](double deviations) {
      for (Index i = 0; i < b.size(); ++i) {
        const double deviation = std::sqrt(model.covariance(at + i, at + i));
        if (std::isfinite(deviation) && std::fabs(b[i]) > deviations * deviation + rounding) return static_cast<int>(i);
      }
      return -1;
    };
    // Of many coefficients some are large by chance: one must be larger than chance makes any of them, once in a
    // thousand times; what comes before it may be smaller.
    const double sure = std::sqrt(2 * std::log(1e3 * static_cast<double>(b.size())));
    delays.push_back(first_above(sure) < 0 ? -1 : first_above(3.5));
    at += b.size();
  }
  return delays;
}

int excitation_order(const DataSet& data, std::size_t input, int highest) {
  check(data);
  refuse_missing(data, "the order of excitation");
  if (input >= data.inputs.size()) fail("the data have {} inputs, there is no input {}", data.inputs.size(), input + 1);
  // Windows about their mean window: a constant adds nothing.
  VectorXd mean = VectorXd::Zero(highest);
  double count = 0;
  const auto for_windows = [&](auto use) {
    for (const Experiment& e : data.experiments) {
      const VectorXd u = e.u.col(static_cast<Index>(input));
      for (Index k = 0; k + highest <= u.size(); ++k) use(u.segment(k, highest));
    }
  };
  for_windows([&](const auto& window) {
    mean += window;
    count += 1;
  });
  mean /= std::max(1.0, count);
  MatrixXd R = MatrixXd::Zero(highest, highest);
  for_windows([&](const auto& window) {
    const VectorXd x = window - mean;
    R += x * x.transpose();
  });
  const VectorXd s = R.jacobiSvd().singularValues();
  if (!(s[0] > 0)) return 0;
  return static_cast<int>((s.array() > 1e-6 * s[0]).count());
}

std::vector<std::string> advice(const DataSet& data) {
  check(data);
  return Adviser(data).all();
}

}  // namespace plantloop::identify
