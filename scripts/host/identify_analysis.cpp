// pl.identify: measures, residual tests, histograms, spectra.

#include <fmt/format.h>

#include "identify/spectra/spectra.h"
#include "identify/validation/correlation.h"
#include "identify/validation/metrics.h"
#include "scripts/host/identify_models.h"
#include "scripts/host/identify_objects.h"

namespace plantloop::lua {
namespace {

using Eigen::Index;

void field(lua_State* L, const char* key, const Eigen::VectorXd& x) {
  push_numbers(L, x);
  lua_setfield(L, -2, key);
}

void field(lua_State* L, const char* key, double value) {
  lua_pushnumber(L, value);
  lua_setfield(L, -2, key);
}

// A frequency grid of the options: w itself, or `count` ones from `from`.
int frequencies(lua_State* L) {
  const Options o(L, 1, "the options of frequencies", {"from", "Ts", "count"});
  if (!o.has("from") || !o.has("Ts")) throw ScriptError("frequencies need 'from' in rad/s, and 'Ts' in s");
  push_numbers(L, identify::frequencies(*o.number("from"), *o.number("Ts"), integer(o, "count", 100)));
  return 1;
}

std::size_t channel(lua_State* L, int index, const char* what) {
  return static_cast<std::size_t>(is_given(L, index) ? integer_argument(L, index, what, 1, 1000) - 1 : 0);
}

int fourier(lua_State* L) {
  push_response(L, identify::fourier_analysis(data_argument(L, 1), channel(L, 2, "input"), channel(L, 3, "output")));
  return 1;
}

int spectral(lua_State* L) {
  const identify::DataSet& data = data_argument(L, 1);
  const Options o(L, 2, "the options of spectral", {"lags", "w", "input", "output", "window"});
  Eigen::VectorXd w;
  if (o.push("w")) {
    w = vector_of(L, -1, "w");
  } else {
    w = identify::frequencies(0.01 * 3.14159265358979 / data.Ts, data.Ts, 100);
  }
  const auto s = identify::spectral_analysis(data, integer(o, "lags", 35), w,
                                             static_cast<std::size_t>(std::max(1, integer(o, "input", 1)) - 1),
                                             static_cast<std::size_t>(std::max(1, integer(o, "output", 1)) - 1),
                                             identify::find_lag_window(o.text("window", "hamming")));
  push_response(L, s.response);
  field(L, "coherence", s.coherence);
  field(L, "noise", s.noise);
  field(L, "input", s.input);
  field(L, "output", s.output);
  return 1;
}

int periodogram(lua_State* L) {
  const identify::Spectrum s = identify::periodogram(vector_of(L, 1, "x"), number_argument(L, 2, "Ts"));
  push_numbers(L, s.w);
  push_numbers(L, s.power);
  return 2;
}

// {lag = ..., r = ..., band = ..., band99 = ...}
void push_correlation(lua_State* L, const identify::Correlation& c) {
  lua_newtable(L);
  field(L, "lag", c.lag);
  field(L, "r", c.r);
  field(L, "band", c.band95);
  field(L, "band99", c.band99);
}

int lags_argument(lua_State* L, int index) {
  return is_given(L, index) ? static_cast<int>(integer_argument(L, index, "lags", 1, 1'000'000)) : 25;
}

int autocorrelation(lua_State* L) {
  push_correlation(L, identify::autocorrelation({vector_of(L, 1, "e")}, lags_argument(L, 2)));
  return 1;
}

int cross_correlation(lua_State* L) {
  push_correlation(L, identify::cross_correlation({vector_of(L, 1, "e")}, {vector_of(L, 2, "u")}, lags_argument(L, 3)));
  return 1;
}

int residual_tests(lua_State* L) {
  const identify::ResidualTests tests =
      identify::residual_tests({vector_of(L, 1, "e")}, {vector_of(L, 2, "u")}, lags_argument(L, 3));
  lua_newtable(L);
  for (std::size_t i = 0; i < tests.verdicts.size(); ++i) {
    const identify::Verdict& v = tests.verdicts[i];
    push_correlation(L, tests.correlations[i]);
    push_text(L, v.name);
    lua_setfield(L, -2, "name");
    push_text(L, v.meaning);
    lua_setfield(L, -2, "meaning");
    lua_pushboolean(L, v.passed ? 1 : 0);
    lua_setfield(L, -2, "passed");
    field(L, "outside", v.outside);
    field(L, "largest", v.largest);
    lua_rawseti(L, -2, static_cast<lua_Integer>(i) + 1);
  }
  return 1;
}

int histogram(lua_State* L) {
  const int bins = is_given(L, 2) ? static_cast<int>(integer_argument(L, 2, "bins", 1, 10'000)) : 20;
  const identify::Histogram h = identify::histogram(vector_of(L, 1, "x"), bins);
  lua_newtable(L);
  field(L, "edges", h.edges);
  field(L, "middles", (h.edges.head(h.counts.size()) + h.edges.tail(h.counts.size())) / 2);
  field(L, "counts", h.counts);
  field(L, "normal", h.normal);
  field(L, "mean", h.mean);
  field(L, "deviation", h.deviation);
  return 1;
}

int metrics(lua_State* L) {
  const Options o(L, 3, "the options of metrics", {"skip", "variance", "partial"});
  const int skip = integer(o, "skip", 0);
  if (skip < 0) o.wrong("skip", "a number of samples, 0 or more");
  const auto tail = [&](const Eigen::VectorXd& x) {
    return Eigen::VectorXd(x.tail(std::max<Index>(0, x.size() - skip)));
  };
  const Eigen::VectorXd y = tail(vector_of(L, 1, "y"));
  const Eigen::VectorXd prediction = tail(vector_of(L, 2, "prediction"));
  Eigen::VectorXd variance;
  const bool with_variance = o.push("variance");
  if (with_variance) {
    variance = tail(vector_of(L, -1, "variance"));
    lua_pop(L, 1);
  }
  const identify::Counted counted = identify::check_predictions(y, prediction, variance, skip, o.flag("partial"));
  lua_newtable(L);
  lua_pushinteger(L, counted.samples);
  lua_setfield(L, -2, "samples");
  lua_pushinteger(L, counted.without_prediction);
  lua_setfield(L, -2, "without_prediction");
  for (const identify::Metric& m : identify::metrics()) {
    lua_pushnumber(L, m.value(y, prediction));
    lua_setfield(L, -2, std::string(m.name).c_str());
  }
  if (with_variance) {
    field(L, "LD", identify::log_density_error(y, prediction, variance));
    field(L, "coverage", identify::coverage(y, prediction, variance));
  }
  return 1;
}

}  // namespace

Entries identify_analysis_functions() {
  return {
      {"metrics", guarded<metrics>,
       "y: pl.Vector, prediction: pl.Vector, options?: {skip?: integer, variance?: pl.Vector, partial?: boolean}",
       "table<string, number>",
       "AE, SE, RMSE, nRMSE, FIT, max; with variances LD and the coverage of the 95 % band; `samples` are counted. Not "
       "counted are the first `skip`, those that were not measured, and those before the first prediction; a "
       "prediction "
       "that is missing later is an error, with `partial` it is left out and `without_prediction` says how many"},
      {"autocorrelation", guarded<autocorrelation>, "e: pl.Vector, lags?: integer", "table",
       "lag, r, band (95 %), band99 of white residuals"},
      {"cross_correlation", guarded<cross_correlation>, "e: pl.Vector, u: pl.Vector, lags?: integer", "table",
       "the same of e(k+lag) and u(k), lags to both sides, with the bands of two signals that do not depend on each "
       "other"},
      {"residual_tests", guarded<residual_tests>, "e: pl.Vector, u: pl.Vector, lags?: integer", "table[]",
       "linear and nonlinear tests of residuals at a level of 1 %: name, passed, meaning, outside, largest, and the "
       "correlation"},
      {"histogram", guarded<histogram>, "x: pl.Vector, bins?: integer", "table",
       "edges, middles, counts, and the normal density of the same mean and deviation in counts"},
      {"frequencies", guarded<frequencies>, "options: {from: number, Ts: number, count?: integer}", "pl.Vector",
       "rad/s with equal ratios, up to the Nyquist frequency"},
      {"fourier", guarded<fourier>, "data: pl.DataSet, input?: integer, output?: integer", "table",
       "empirical frequency response Y/U: w, magnitude, phase"},
      {"spectral", guarded<spectral>,
       "data: pl.DataSet, options?: {lags?: integer, w?: pl.Vector, input?: integer, output?: integer, window?: "
       "string}",
       "table",
       "frequency response by correlations with a window (hamming, hann, bartlett or parzen): w, magnitude, phase, "
       "deviation; coherence, noise, input and output power with one whose spectra are never negative"},
      {"periodogram", guarded<periodogram>, "x: pl.Vector, Ts: number", "pl.Vector, pl.Vector",
       "frequencies in rad/s and |X|^2/N"},
  };
}

}  // namespace plantloop::lua
