// Fits against closed forms: estimates, their covariance, derivatives, and what is said when the data do not suffice.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "engine/analysis/fit_model.h"
#include "engine/analysis/quantiles.h"

namespace plantloop {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

std::shared_ptr<Diagram> diagram_of(const std::string& text) {
  Report report;
  auto diagram = Diagram::from_text("plantloop: 1\n" + text, "test.yaml", report);
  EXPECT_NE(diagram, nullptr) << to_text(report);
  return diagram;
}

std::vector<double> grid(double from, double to, int count) {
  std::vector<double> t;
  for (int i = 0; i < count; ++i) t.push_back(from + (to - from) * i / (count - 1));
  return t;
}

template <typename F>
FitData::Column data_of(const std::string& signal, const std::vector<double>& time, F f, double weight = 1) {
  FitData::Column column{signal, {}, weight};
  for (const double t : time) column.values.push_back(f(t));
  return column;
}

FitResult fitted(const std::string& text, const FitRequest& request) {
  Report report;
  auto result = fit(diagram_of(text)->model_pointer(), request, report);
  EXPECT_TRUE(result) << to_text(report);
  return result ? *result : FitResult{};
}

std::string said(const std::string& text, const FitRequest& request) {
  Report report;
  const auto result = fit(diagram_of(text)->model_pointer(), request, report);
  EXPECT_FALSE(result);
  return to_text(report);
}

// Evenly distributed, the same everywhere: the golden section's multiples.
double noise(int i) { return std::fmod(0.6180339887498949 * (i + 1), 1.0) - 0.5; }

constexpr const char* line = R"(
parameters: {a: 0.3, b: -1}
blocks: {y: a + b*time}
simulation: {stop: 1}
)";

constexpr const char* lag = R"(
parameters: {k: 1, tau: 1}
blocks:
  x: {type: first_order, in: 1, k: k, tau: tau, initial: 0}
simulation: {stop: 5}
)";

double lag_at(double k, double tau, double x0, double t) { return k + (x0 - k) * std::exp(-t / tau); }

TEST(Fit, OfALineIsLinearRegressionWithItsCovariance) {
  FitRequest request;
  request.parameters = {{"a", {}}, {"b", {}}};
  request.experiments[0].data.time = grid(0, 1, 21);
  int i = 0;
  request.experiments[0].data.columns = {
      data_of("y", request.experiments[0].data.time, [&](double t) { return 2 - 3 * t + 0.1 * noise(i++); })};
  const FitResult r = fitted(line, request);
  const auto& y = request.experiments[0].data.columns[0].values;
  double t1 = 0, t2 = 0, y1 = 0, ty = 0;
  const double n = 21;
  for (std::size_t j = 0; j < y.size(); ++j) {
    const double t = request.experiments[0].data.time[j];
    t1 += t, t2 += t * t, y1 += y[j], ty += t * y[j];
  }
  const double determinant = n * t2 - t1 * t1, b = (n * ty - t1 * y1) / determinant, a = (y1 - b * t1) / n;
  double squares = 0;
  for (std::size_t j = 0; j < y.size(); ++j) squares += std::pow(a + b * request.experiments[0].data.time[j] - y[j], 2);
  const double variance = squares / (n - 2);
  EXPECT_TRUE(r.converged) << r.why;
  EXPECT_EQ(r.gradient, "exact");
  EXPECT_NEAR(r.parameters[0].value, a, 1e-12);
  EXPECT_NEAR(r.parameters[1].value, b, 1e-12);
  EXPECT_NEAR(r.cost, squares, 1e-13);
  EXPECT_NEAR(r.covariance(0, 0), variance * t2 / determinant, 1e-14);
  EXPECT_NEAR(r.covariance(1, 1), variance * n / determinant, 1e-14);
  EXPECT_NEAR(r.covariance(0, 1), -variance * t1 / determinant, 1e-14);
  EXPECT_NEAR(r.correlation(0, 1), -t1 / std::sqrt(n * t2), 1e-12);
  // 19 degrees of freedom, 95 %: t = 2.093024 (tables).
  EXPECT_NEAR(r.parameters[0].upper - a, 2.093024054 * std::sqrt(variance * t2 / determinant), 1e-9);
}

TEST(Fit, WithTheTrueWeightsHasTheCovarianceThatTheyGive) {
  FitRequest request;
  request.parameters = {{"a", {}}, {"b", {}}};
  request.absolute = true;
  request.experiments[0].data.time = {0, 1, 2};
  request.experiments[0].data.columns = {data_of(
      "y", request.experiments[0].data.time, [](double t) { return 1 + t; }, 1 / 0.1)};
  const FitResult r = fitted(line, request);
  // (X'X)^-1 = [5 -3; -3 3]/6 times 0.1^2.
  EXPECT_NEAR(r.covariance(0, 0), 0.01 * 5 / 6, 1e-14);
  EXPECT_NEAR(r.covariance(0, 1), -0.01 * 3 / 6, 1e-14);
  EXPECT_NEAR(r.parameters[1].upper - r.parameters[1].value, 1.959963985 * 0.1 * std::sqrt(0.5), 1e-8);
}

TEST(Fit, WithoutNoiseFindsTheParametersAgain) {
  FitRequest request;
  request.parameters = {{"k", {}}, {"tau", {}}, {"x.initial", 0.5}};
  request.experiments[0].data.time = grid(0.1, 5, 25);
  request.experiments[0].data.columns = {
      data_of("x", request.experiments[0].data.time, [](double t) { return lag_at(2.5, 0.7, -1, t); })};
  for (const char* solver : {"dopri5", "bdf", "adams"}) {
    request.run.solver = solver;
    const FitResult r = fitted(lag, request);
    EXPECT_EQ(r.gradient, "exact");
    EXPECT_NEAR(r.parameters[0].value, 2.5, 1e-8) << solver;
    EXPECT_NEAR(r.parameters[1].value, 0.7, 1e-8) << solver;
    EXPECT_NEAR(r.parameters[2].value, -1, 1e-8) << solver;
    EXPECT_LT(r.columns[0].rms, 1e-8) << solver;
  }
}

// A line measured in two pieces, the second one lifted by 5, is one regression.
TEST(Fit, OfSeveralExperimentsIsTheRegressionOfAllTheirData) {
  const char* const lifted = R"(
parameters: {a: 0, b: 0, c: 0}
blocks: {y: a + b*time + c}
simulation: {stop: 5}
)";
  FitRequest whole;
  whole.parameters = {{"a", {}}, {"b", {}}};
  whole.experiments[0].data = {{0, 1, 2, 3, 4}, {{"y", {1, 2.5, 2, 4, 4.2}}}};
  FitRequest parts = whole;
  parts.experiments = {{{{"c", "0"}}, {{0, 1}, {{"y", {1, 2.5}}}}}, {{{"c", "5"}}, {{2, 3, 4}, {{"y", {7, 9, 9.2}}}}}};
  const FitResult one = fitted(lifted, whole), two = fitted(lifted, parts);
  EXPECT_EQ(two.values, 5U);
  EXPECT_EQ(two.degrees, 3U);
  EXPECT_NEAR(two.cost, one.cost, 1e-12);
  for (std::size_t k = 0; k < 2; ++k) {
    EXPECT_NEAR(two.parameters[k].value, one.parameters[k].value, 1e-12);
    for (std::size_t j = 0; j < 2; ++j) EXPECT_NEAR(two.covariance(k, j), one.covariance(k, j), 1e-12);
  }
  // Slope of the five points: sum((t - 2)(y - mean))/10 = 0.79.
  EXPECT_NEAR(two.parameters[1].value, 0.79, 1e-12);
  ASSERT_EQ(two.columns.size(), 2U);
  EXPECT_EQ(two.columns[1].experiment, 1U);
  EXPECT_NEAR(two.columns[1].fitted[0] - 5, one.columns[0].fitted[2], 1e-12);
}

// Each has its own initial value and its own times; neither tells k and tau alone.
TEST(Fit, OfSeveralExperimentsSharesTheParameters) {
  FitRequest request;
  request.parameters = {{"k", {}}, {"tau", {}}};
  request.experiments.resize(2);
  request.experiments[0].set = {{"x.initial", "-1"}};
  request.experiments[0].data.time = {1.5};
  request.experiments[0].data.columns = {{"x", {lag_at(2.5, 0.7, -1, 1.5)}}};
  request.experiments[1].set = {{"x.initial", "4"}};
  request.experiments[1].data.time = {0.4};
  request.experiments[1].data.columns = {{"x", {lag_at(2.5, 0.7, 4, 0.4)}}};
  const FitResult r = fitted(lag, request);
  EXPECT_NEAR(r.parameters[0].value, 2.5, 1e-8);
  EXPECT_NEAR(r.parameters[1].value, 0.7, 1e-8);
}

TEST(Fit, LeavesMissingValuesOutAndWeighsSignals) {
  FitRequest request;
  request.parameters = {{"a", {}}};
  request.experiments[0].data.time = {0, 1, 2};
  const std::string text = "parameters: {a: 1}\nblocks: {y: a, z: a}\nsimulation: {stop: 1}\n";
  request.experiments[0].data.columns = {{"y", {1, NAN, 1}, 1}, {"z", {4, 4, NAN}, 2}};
  // 2 (a - 1) + 4*2 (a - 4) = 0.
  EXPECT_NEAR(fitted(text, request).parameters[0].value, 3.4, 1e-10);  // it stands to 11 digits
}

TEST(Fit, StopsAtABoundAndSaysSo) {
  FitRequest request;
  request.parameters = {{"a", 0, -1, 1.5}, {"b", 0, -10, 10}};
  request.experiments[0].data.time = grid(0, 1, 5);
  request.experiments[0].data.columns = {
      data_of("y", request.experiments[0].data.time, [](double t) { return 2 - 3 * t; })};
  const FitResult r = fitted(line, request);
  EXPECT_TRUE(r.converged);
  EXPECT_EQ(r.parameters[0].value, 1.5);
  EXPECT_TRUE(r.parameters[0].on_bound);
  // b is the best slope through (0, 1.5): sum t (2 - 3t - 1.5)/sum t^2 with t = 0, 1/4, ...
  EXPECT_NEAR(r.parameters[1].value, (0.5 * 2.5 - 3 * 1.875) / 1.875, 1e-10);
  EXPECT_THAT(to_text(r, 0.95), HasSubstr("on a bound"));
}

TEST(Fit, FindsTheLowestOfSeveralMinimaFromManyStarts) {
  // sin(w t) has a minimum near every other frequency.
  const std::string text = "parameters: {w: 1}\nblocks: {y: sin(w*time)}\nsimulation: {stop: 1}\n";
  FitRequest request;
  request.parameters = {{"w", 4, 3, 12}};
  request.experiments[0].data.time = grid(0, 5, 60);
  request.experiments[0].data.columns = {
      data_of("y", request.experiments[0].data.time, [](double t) { return std::sin(7.25 * t); })};
  EXPECT_GT(fitted(text, request).cost, 1);
  request.starts = 30;
  FitResult first;
  for (const std::size_t threads : {1U, 3U}) {
    request.threads = threads;
    const FitResult r = fitted(text, request);
    EXPECT_NEAR(r.parameters[0].value, 7.25, 1e-9);
    if (threads == 1) first = r;
    EXPECT_EQ(r.parameters[0].value, first.parameters[0].value);
    EXPECT_EQ(r.parameters[0].deviation, first.parameters[0].deviation);
  }
}

TEST(Fit, FindsDampingAndLengthOfAPendulum) {
  const std::string text = R"(
parameters: {length: 0.8, damping: 0.05, g: 9.81}
blocks:
  angle: {type: integrator, in: rate, initial: 2}
  rate: {type: integrator, in: -g/length*sin(angle) - damping*rate}
simulation: {stop: 6, rtol: 1e-11, atol: 1e-13}
record: [angle]
)";
  const auto diagram = diagram_of(text);
  FitRequest request;
  request.experiments[0].data.time = grid(0.05, 6, 120);
  Report report;
  RunRequest truth;
  truth.set = {{"length", "1.1"}, {"damping", "0.31"}};
  truth.output_interval = 0.05;
  const auto run = diagram->run(truth, report);
  ASSERT_TRUE(run);
  int i = 0;
  request.experiments[0].data.columns = {data_of("angle", request.experiments[0].data.time, [&](double t) {
    return run->recording.value(0, t) + 0.01 * noise(i++);
  })};
  request.parameters = {{"length", {}, 0.1, 5}, {"damping", {}, 0, 5}};
  const FitResult r = fitted(text, request);
  EXPECT_EQ(r.gradient, "exact");
  EXPECT_NEAR(r.parameters[0].value, 1.1, 4 * r.parameters[0].deviation);
  EXPECT_NEAR(r.parameters[1].value, 0.31, 4 * r.parameters[1].deviation);
  EXPECT_LT(r.parameters[0].deviation, 1e-3);
  EXPECT_NEAR(r.columns[0].rms, 0.01 / std::sqrt(12), 5e-4);  // of evenly distributed noise
}

// --- derivatives -------------------------------------------------------------------------------------------------

// Against differences of sixth order of runs without sensitivities.
void expect_exact_slopes(const std::string& text, const std::vector<std::pair<std::string, double>>& at,
                         const std::vector<std::string>& signals, const std::string& solver = "dopri5") {
  FitRequest request;
  request.run.rtol = 1e-12;
  request.run.atol = 1e-14;
  request.run.solver = solver;
  for (const auto& [path, value] : at) request.parameters.push_back({path, value});
  request.experiments[0].data.time = {0, 0.4, 1, 1.7, 3};
  for (const std::string& signal : signals) request.experiments[0].data.columns.push_back({signal, {0, 0, 0, 0, 0}});
  Report report;
  const auto model = FitModel::make(diagram_of(text)->model_pointer(), request, request.experiments[0], report);
  ASSERT_NE(model, nullptr) << to_text(report);
  FitRequest plain = request;
  plain.differences = true;
  const auto by_runs = FitModel::make(diagram_of(text)->model_pointer(), plain, plain.experiments[0], report);
  bool moved = false;
  const FitModel::Answer exact = model->answer(model->start(), true, nullptr, moved);
  EXPECT_EQ(model->differences(moved), "");
  for (std::size_t k = 0; k < at.size(); ++k) {
    const double h = 0.005 * std::max(std::fabs(at[k].second), 0.1);
    std::vector<double> sum(model->outputs(), 0.0);
    for (const auto& [steps, factor] : std::vector<std::pair<int, double>>{{1, 45}, {2, -9}, {3, 1}}) {
      for (const int side : {1, -1}) {
        std::vector<double> p = model->start();
        p[k] += side * steps * h;
        const auto y = by_runs->answer(p, false, nullptr, moved).y;
        for (std::size_t i = 0; i < y.size(); ++i) sum[i] += side * factor * y[i];
      }
    }
    for (std::size_t i = 0; i < sum.size(); ++i) {
      const double difference = sum[i] / (60 * h);
      EXPECT_NEAR(exact.slopes(i, k), difference, 2e-8 * std::max(1.0, std::fabs(difference)))
          << at[k].first << ", value " << i << ", " << solver;
    }
  }
}

TEST(FitDerivatives, OfNonlinearEquationsAndInitialValuesAreExact) {
  const std::string text = R"(
parameters: {mu: 1.5, a: 0.4}
blocks:
  x: {type: integrator, in: v, initial: 1}
  v: {type: integrator, in: mu*(1 - x^2)*v - x + a*sin(2*time), initial: a^2}
  y: x*exp(-a*x) + mu
simulation: {stop: 3}
)";
  for (const char* solver : {"dopri5", "bdf", "adams"})
    expect_exact_slopes(text, {{"mu", 1.5}, {"a", 0.4}, {"x.initial", 0.8}}, {"x", "v", "y"}, solver);
}

TEST(FitDerivatives, OfElementsOfAMatrixAreExact) {
  expect_exact_slopes(R"yaml(
parameters: {A: [[-1, 2], [-2, -0.3]]}
blocks: {x: {type: integrator, in: "mul(A, x)", initial: [1, 0.5]}}
simulation: {stop: 3}
)yaml",
                      {{"A.1.2", 2}, {"A.2.2", -0.3}}, {"x.1", "x.2"});
}

TEST(FitDerivatives, ThroughSampledBlocksAreExact) {
  expect_exact_slopes(R"(
parameters: {kp: 0.7, ki: 0.4, tau: 0.9}
blocks:
  error: 1 - plant
  total: {type: discrete_integrator, in: ki*error, rate: 0.25}
  delayed: {type: unit_delay, in: plant^2, rate: 0.5}
  u: {type: zero_order_hold, in: kp*error + total - 0.1*delayed, rate: 0.25}
  plant: {type: integrator, in: (u - plant)/tau}
simulation: {stop: 3}
)",
                      {{"kp", 0.7}, {"ki", 0.4}, {"tau", 0.9}}, {"plant", "u", "total"});
}

TEST(FitDerivatives, ThroughAlgebraicLoopsAreExact) {
  expect_exact_slopes(R"(
parameters: {k: 0.5, c: 2}
blocks:
  z: c*cos(k*z + x)
  y: {type: algebraic_constraint, residual: y + k*y^3 - x}
  x: {type: integrator, in: y - z*k, initial: 0.2}
simulation: {stop: 3}
)",
                      {{"k", 0.3}, {"c", 0.8}}, {"x", "y", "z"});
}

TEST(FitDerivatives, ThroughResetsAndSwitchesAtFixedTimesAreExact) {
  expect_exact_slopes(R"(
parameters: {a: 0.6, b: 1.5}
blocks:
  x: {type: integrator, in: a*b - x, initial: b, reset: {when: time > 1.2, to: a*x^2}}
  y: where(time < 2, a, b)*x
simulation: {stop: 3}
)",
                      {{"a", 0.6}, {"b", 1.5}}, {"x", "y"});
}

TEST(FitDerivatives, ThroughEventsThatMoveAreDifferencesAndTheFitSaysSo) {
  // Free fall from h onto a floor that gives back e of the speed.
  const std::string text = R"(
parameters: {e: 0.9, g: 5}
blocks:
  h: {type: integrator, in: v, initial: 1}
  v: {type: integrator, in: -g, reset: {when: h < 0, edge: rising, to: -e*v}}
simulation: {stop: 1, rtol: 1e-10}
)";
  FitRequest request;
  request.parameters = {{"e", {}, 0.1, 1}, {"g", {}, 1, 20}};
  request.experiments[0].data.time = grid(0.02, 0.8, 40);
  request.experiments[0].data.columns = {data_of("h", request.experiments[0].data.time, [](double t) {
    const double g = 9.81, e = 0.8, hit = std::sqrt(2 / g), s = t - hit;
    return s < 0 ? 1 - 0.5 * g * t * t : e * g * hit * s - 0.5 * g * s * s;
  })};
  const FitResult r = fitted(text, request);
  EXPECT_THAT(r.gradient, StartsWith("differences: events have times that move with a parameter: v.reset"));
  EXPECT_NEAR(r.parameters[0].value, 0.8, 1e-6);
  EXPECT_NEAR(r.parameters[1].value, 9.81, 1e-6);
}

TEST(FitDerivatives, OfTheTimeOfAStepAreDifferences) {
  FitRequest request;
  request.parameters = {{"start", {}}};
  request.experiments[0].data.time = grid(0, 3, 31);
  request.experiments[0].data.columns = {
      data_of("x", request.experiments[0].data.time, [](double t) { return std::max(0.0, t - 1.33); })};
  const FitResult r = fitted(
      "parameters: {start: 1}\nblocks:\n  u: {type: step, time: start}\n  x: {type: integrator, in: u}\n"
      "simulation: {stop: 3}\n",
      request);
  EXPECT_EQ(r.gradient, "differences: the times at which 'u' jumps move");
  EXPECT_NEAR(r.parameters[0].value, 1.33, 1e-7);
}

// --- what is wrong ------------------------------------------------------------------------------------------------

FitRequest line_request() {
  FitRequest request;
  request.parameters = {{"a", {}}};
  request.experiments[0].data.time = {0, 1, 2};
  request.experiments[0].data.columns = {{"y", {1, 2, 3}}};
  return request;
}

TEST(FitFindings, NameAParameterThatChangesNothing) {
  const std::string text = "parameters: {a: 1, b: 2}\nblocks: {y: a*time, z: b}\nsimulation: {stop: 1}\n";
  FitRequest request = line_request();
  request.parameters.push_back({"b", {}});
  EXPECT_EQ(said(text, request), "error: 'b' does not change any of the fitted signals: y\n");
}

TEST(FitFindings, NameParametersThatTheDataDoNotTellApart) {
  const std::string text = "parameters: {a: 1, b: 2, c: 1}\nblocks: {y: a*b*time + c}\nsimulation: {stop: 1}\n";
  FitRequest request = line_request();
  request.parameters = {{"a", {}}, {"b", {}}, {"c", {}}};
  EXPECT_EQ(said(text, request),
            "error: the data do not tell 'a' and 'b' apart: they can change together without changing the fitted "
            "signals\n  leave one of them out, or add data that depend on them in another way\n");
}

TEST(FitFindings, SpeakOfNamesBoundsAndData) {
  FitRequest request = line_request();
  request.parameters = {{"q", {}}};
  EXPECT_THAT(said(line, request), HasSubstr("'q' is no number of the diagram that can be fitted"));
  request = line_request();
  request.parameters = {{"a", 5, 0, 1}};
  EXPECT_EQ(said(line, request), "error: 'a' starts at 5, outside of its bounds 0 and 1\n");
  request = line_request();
  request.parameters = {{"a", {}}, {"a", {}}};
  EXPECT_EQ(said(line, request), "error: the fit has 'a' twice\n");
  request = line_request();
  request.experiments[0].data.columns[0].signal = "w";
  EXPECT_THAT(said(line, request), StartsWith("error: the signal 'w' is no signal of the diagram\n"));
  request = line_request();
  request.experiments[0].data.columns[0].values.pop_back();
  EXPECT_EQ(said(line, request), "error: the data of 'y' have 2 values, but there are 3 times\n");
  request = line_request();
  request.experiments[0].data.time = {0, 2, 1};
  EXPECT_EQ(said(line, request), "error: the times of the data must ascend: 1 s comes after 2 s\n");
  request = line_request();
  request.parameters = {{"a", {}}, {"b", {}}};
  request.experiments[0].data.columns[0].values = {1, NAN, NAN};
  EXPECT_EQ(said(line, request), "error: 1 values cannot determine 2 parameters\n");
  request = line_request();
  request.starts = 3;
  EXPECT_EQ(said(line, request),
            "error: further starts are drawn within the bounds: 'a' needs a lower and an upper one\n");
  request = line_request();
  request.parameters = {{"x.initial", {}}};
  request.experiments[0].data.columns[0].signal = "x";
  EXPECT_THAT(said("parameters: {a: 1}\nblocks: {x: {type: integrator, in: a, initial: 2*a}}\nsimulation: {stop: 1}\n",
                   request),
              HasSubstr("needs a start value"));
}

TEST(Quantiles, OfStudentsDistributionAreThoseOfTheTables) {
  EXPECT_NEAR(student_quantile(0.95, 1), 12.7062047362, 1e-8);  // tan(0.95 pi/2)
  EXPECT_NEAR(student_quantile(0.95, 2), 4.30265272975, 1e-9);
  EXPECT_NEAR(student_quantile(0.99, 10), 3.16927267261, 1e-9);
  EXPECT_NEAR(student_quantile(0.95, 1000), 1.96233908081, 1e-9);
  EXPECT_EQ(student_quantile(0.95, 0), std::numeric_limits<double>::infinity());
}

}  // namespace
}  // namespace plantloop
