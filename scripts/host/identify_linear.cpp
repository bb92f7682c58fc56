// pl.identify: linear models, their fits and what they can do.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "identify/linear/fit_linear.h"
#include "identify/linear/least_squares.h"
#include "identify/linear/order.h"
#include "identify/linear/recursive.h"
#include "identify/linear/state_space.h"
#include "identify/model_file/model_file.h"
#include "identify/spectra/spectra.h"
#include "scripts/host/identify_models.h"
#include "scripts/host/identify_objects.h"

namespace plantloop::lua {
namespace {

using Eigen::Index;
using identify::LinearOptions;
using identify::Orders;
using identify::PolynomialModel;

// What all fits of polynomials understand beside their orders.
const std::vector<std::string> common_keys{"delay",   "output", "remove_means", "offset",
                                           "initial", "ridge",  "iterations"};

std::optional<identify::Initial> initial_of(const Options& o) {
  const std::string initial = o.text("initial");
  if (!o.has("initial")) return {};
  if (initial != "rest" && initial != "estimate") o.wrong("initial", "rest or estimate");
  return initial == "rest" ? identify::Initial::rest : identify::Initial::estimate;
}

LinearOptions linear_options(const Options& o) {
  return {.output = o.text("output"),
          .remove_means = o.flag("remove_means"),
          .offset = o.flag("offset"),
          .initial = initial_of(o),
          .ridge = o.number("ridge").value_or(0),
          .iterations = integer(o, "iterations", 200)};
}

Orders orders_of(lua_State* L, const Options& o) {
  return {.na = integer(o, "na", 0),
          .nc = integer(o, "nc", 0),
          .nd = integer(o, "nd", 0),
          .nb = integers(L, o, "nb"),
          .nf = integers(L, o, "nf"),
          .delay = integers(L, o, "delay")};
}

std::size_t bytes_of(const PolynomialModel& m) {
  return static_cast<std::size_t>(m.covariance.size()) * sizeof(double) + 1000;
}

void push_model(lua_State* L, PolynomialModel m) {
  const std::size_t bytes = bytes_of(m);
  push_held(L, linear_kind, std::move(m), bytes);
}

int fit(lua_State* L, const char* name, std::initializer_list<std::string_view> orders) {
  std::vector<std::string> keys(orders.begin(), orders.end());
  keys.insert(keys.end(), common_keys.begin(), common_keys.end());
  const Options o(L, 2, fmt::format("the options of {}", name), keys);
  const auto has = [&](std::string_view key) { return std::find(orders.begin(), orders.end(), key) != orders.end(); };
  Orders own{.na = has("na") ? integer(o, "na", 1) : 0,
             .nc = has("nc") ? integer(o, "nc", 1) : 0,
             .nd = has("nd") ? integer(o, "nd", 1) : 0,
             .nb = integers(L, o, "nb"),
             .nf = integers(L, o, "nf"),
             .delay = integers(L, o, "delay")};
  if (has("nf") && own.nf.empty()) own.nf = {1};
  push_model(L, identify::fit_linear(data_argument(L, 1), own, linear_options(o), control_of(L)));
  return 1;
}

int fir(lua_State* L) { return fit(L, "fir", {"nb"}); }
int arx(lua_State* L) { return fit(L, "arx", {"na", "nb"}); }
int armax(lua_State* L) { return fit(L, "armax", {"na", "nb", "nc"}); }
int oe(lua_State* L) { return fit(L, "oe", {"nb", "nf"}); }
int bj(lua_State* L) { return fit(L, "bj", {"nb", "nc", "nd", "nf"}); }

Options arx_like(lua_State* L, const char* name, std::vector<std::string> keys) {
  keys.insert(keys.end(), common_keys.begin(), common_keys.end());
  return {L, 2, fmt::format("the options of {}", name), keys};
}

int filtered(lua_State* L) {
  const Options o = arx_like(L, "filtered", {"na", "nb", "passes"});
  push_model(L,
             identify::fit_filtered(data_argument(L, 1), orders_of(L, o), linear_options(o), integer(o, "passes", 30)));
  return 1;
}

int instrumental(lua_State* L) {
  const Options o = arx_like(L, "instrumental", {"na", "nb"});
  push_model(L, identify::fit_instrumental(data_argument(L, 1), orders_of(L, o), linear_options(o)));
  return 1;
}

int state_space(lua_State* L) {
  const Options o(L, 2, "the options of state_space",
                  {"order", "highest", "block_rows", "remove_means", "offset", "feedthrough"});
  identify::SubspaceOptions s;
  s.order = integer(o, "order", 0);
  s.highest = integer(o, "highest", s.highest);
  s.block_rows = integer(o, "block_rows", s.block_rows);
  s.remove_means = o.flag("remove_means");
  s.offset = o.flag("offset");
  if (o.has("feedthrough")) s.feedthrough = o.flag("feedthrough");
  push_state_space(L, identify::fit_subspace(data_argument(L, 1), s, control_of(L)));
  return 1;
}

int order_table(lua_State* L) {
  const Options o(L, 2, "the options of order_table",
                  {"na", "nb", "delay", "output", "remove_means", "offset", "validation"});
  const auto range = [&](const char* key, int& least, int& most) {
    const std::vector<int> ends = integers(L, o, key);
    if (ends.empty()) return;
    if (ends.size() != 2) throw ScriptError(fmt::format("'{}' is a range, {{least, greatest}}", key));
    least = ends[0];
    most = ends[1];
  };
  identify::OrderRange r;
  range("na", r.na_least, r.na_most);
  range("nb", r.nb_least, r.nb_most);
  range("delay", r.delay_least, r.delay_most);
  const identify::DataSet* validation = nullptr;
  if (o.push("validation")) validation = &data_argument(L, -1);
  const LinearOptions options{
      .output = o.text("output"), .remove_means = o.flag("remove_means"), .offset = o.flag("offset")};
  const identify::ArxTable table = identify::arx_table(data_argument(L, 1), r, options, validation, control_of(L));
  lua_newtable(L);
  lua_Integer place = 0;
  for (const identify::ArxCandidate& c : table.candidates) {
    lua_newtable(L);
    const std::pair<const char*, double> values[] = {{"na", c.orders.na},
                                                     {"nb", c.orders.nb.empty() ? 0 : c.orders.nb[0]},
                                                     {"delay", c.orders.delay.empty() ? 0 : c.orders.delay[0]},
                                                     {"parameters", c.parameters},
                                                     {"AIC", c.aic},
                                                     {"MDL", c.mdl},
                                                     {"FPE", c.fpe},
                                                     {"simulated", c.simulated},
                                                     {"mean_square", c.sse / static_cast<double>(table.rows)}};
    for (const auto& [key, value] : values) {
      if (value == std::floor(value) && std::fabs(value) < 1e9) {
        lua_pushinteger(L, static_cast<lua_Integer>(value));
      } else {
        lua_pushnumber(L, value);
      }
      lua_setfield(L, -2, key);
    }
    lua_rawseti(L, -2, ++place);
  }
  const std::pair<const char*, std::size_t> best[] = {
      {"AIC", table.best_aic}, {"MDL", table.best_mdl}, {"FPE", table.best_fpe}, {"simulated", table.best_simulated}};
  lua_newtable(L);
  for (const auto& [key, at] : best) {
    lua_rawgeti(L, -2, static_cast<lua_Integer>(at) + 1);
    lua_setfield(L, -2, key);
  }
  lua_setfield(L, -2, "best");
  return 1;
}

int delay_table(lua_State* L) {
  const Options o(L, 2, "the options of delay_table",
                  {"order", "delay", "output", "remove_means", "offset", "initial"});
  std::vector<int> ends = integers(L, o, "delay");
  if (ends.empty()) ends = {0, 5};
  if (ends.size() != 2) throw ScriptError("'delay' is a range, {least, greatest}");
  const LinearOptions options{.output = o.text("output"),
                              .remove_means = o.flag("remove_means"),
                              .offset = o.flag("offset"),
                              .initial = initial_of(o)};
  const auto table =
      identify::delay_table(data_argument(L, 1), integer(o, "order", 2), ends[0], ends[1], options, control_of(L));
  Eigen::VectorXd delay(static_cast<Index>(table.size()));
  Eigen::VectorXd rmse(delay.size());
  for (Index i = 0; i < delay.size(); ++i) {
    delay[i] = table[static_cast<std::size_t>(i)].delay;
    rmse[i] = table[static_cast<std::size_t>(i)].rmse;
  }
  push_numbers(L, delay);
  push_numbers(L, rmse);
  return 2;
}

int information_test(lua_State* L) {
  const Options o(L, 2, "the options of information_test", {"highest", "delay", "output", "remove_means", "offset"});
  const LinearOptions options{
      .output = o.text("output"), .remove_means = o.flag("remove_means"), .offset = o.flag("offset")};
  const identify::InformationTest test =
      identify::information_test(data_argument(L, 1), integer(o, "highest", 4), integer(o, "delay", 0), options);
  push_vector(L, test.determinants);
  lua_pushinteger(L, test.order);
  return 2;
}

int least_squares(lua_State* L) {
  const Options o(L, 3, "the options of least_squares", {"ridge"});
  const identify::LeastSquares fit =
      identify::least_squares(matrix_of(L, 1, "X"), vector_of(L, 2, "y"), {.ridge = o.number("ridge").value_or(0)});
  lua_newtable(L);
  push_numbers(L, fit.theta);
  lua_setfield(L, -2, "theta");
  push_matrix(L, fit.covariance);
  lua_setfield(L, -2, "covariance");
  push_numbers(L, fit.deviations());
  lua_setfield(L, -2, "deviations");
  push_numbers(L, fit.residuals);
  lua_setfield(L, -2, "residuals");
  const std::pair<const char*, double> numbers[] = {
      {"sse", fit.sse}, {"variance", fit.s2}, {"rank", static_cast<double>(fit.rank)}, {"condition", fit.condition}};
  for (const auto& [key, value] : numbers) {
    lua_pushnumber(L, value);
    lua_setfield(L, -2, key);
  }
  push_texts(L, fit.warnings);
  lua_setfield(L, -2, "warnings");
  return 1;
}

int recursive(lua_State* L) {
  const Options o(L, 3, "the options of recursive_least_squares", {"forgetting", "initial_covariance"});
  const identify::RecursiveResult r =
      identify::recursive_least_squares(matrix_of(L, 1, "X"), vector_of(L, 2, "y"),
                                        {.forgetting = o.number("forgetting").value_or(1),
                                         .initial_covariance = o.number("initial_covariance").value_or(1e4)});
  push_matrix(L, r.theta);
  push_numbers(L, r.errors);
  push_matrix(L, r.P);
  return 3;
}

const PolynomialModel& self(lua_State* L) { return held_self<PolynomialModel>(L, linear_kind); }

void push_series(lua_State* L, const identify::Series& series) {
  Index size = 0;
  for (const Eigen::VectorXd& s : series) size += s.size();
  double* out = push_vector(L, size).data();
  for (const Eigen::VectorXd& s : series) out = std::copy(s.begin(), s.end(), out);
}

int simulate(lua_State* L) {
  const Options o(L, 3, "the options of simulate", {"start", "samples"});
  // Measured samples are the state of an equation error model; of the others noise in them hides it.
  const bool by_outputs = self(L).A.size() > 1 || self(L).orders().nf == std::vector<int>(self(L).B.size(), 0);
  const std::string start = o.text("start", by_outputs ? "measured" : "estimated");
  if (start != "measured" && start != "estimated" && start != "zero") o.wrong("start", "measured, estimated or zero");
  push_series(L, identify::simulate(self(L), data_argument(L, 2),
                                    start == "zero"        ? identify::Start::zero
                                    : start == "estimated" ? identify::Start::estimated
                                                           : identify::Start::measured,
                                    start_samples(o)));
  return 1;
}

int predict(lua_State* L) {
  const std::int64_t steps = is_given(L, 3) ? integer_argument(L, 3, "steps", 1, 1'000'000) : 1;
  const Options o(L, 4, "the options of predict", {"initial"});
  push_series(L, identify::k_step(self(L), data_argument(L, 2), static_cast<int>(steps), initial_of(o)));
  return 1;
}

int residuals(lua_State* L) {
  const Options o(L, 3, "the options of residuals", {"initial"});
  push_series(L, identify::residuals(self(L), data_argument(L, 2), initial_of(o)));
  return 1;
}

int response(lua_State* L) {
  const std::int64_t input = is_given(L, 3) ? integer_argument(L, 3, "input", 1, 1000) : 1;
  push_response(L, identify::frequency_response(self(L), vector_of(L, 2, "w"), static_cast<std::size_t>(input - 1)));
  return 1;
}

int convert(lua_State* L) {
  push_state_space(L, identify::to_state_space(self(L)));
  return 1;
}

int save(lua_State* L) {
  write_and_push(L, text_argument(L, 2, "path"), identify::to_yaml("linear_model", identify::to_item(self(L))),
                 {".yaml"});
  return 1;
}

// Of one input the polynomial itself, of several a list.
void push_polynomials(lua_State* L, const std::vector<Eigen::VectorXd>& list) {
  if (list.size() == 1) return push_numbers(L, list[0]);
  lua_newtable(L);
  for (std::size_t i = 0; i < list.size(); ++i) {
    push_numbers(L, list[i]);
    lua_rawseti(L, -2, static_cast<lua_Integer>(i) + 1);
  }
}

const std::vector<Field<PolynomialModel>>& fields() {
  using M = PolynomialModel;
  static const std::vector<Field<M>> list{
      {"A", "pl.Vector", "1, a1, a2 ...", [](lua_State* L, const M& m) { push_numbers(L, m.A); }},
      {"B", "pl.Vector", "b1, b2 ...; of several inputs a list",
       [](lua_State* L, const M& m) { push_polynomials(L, m.B); }},
      {"C", "pl.Vector", "1, c1 ...", [](lua_State* L, const M& m) { push_numbers(L, m.C); }},
      {"D", "pl.Vector", "1, d1 ...", [](lua_State* L, const M& m) { push_numbers(L, m.D); }},
      {"F", "pl.Vector", "1, f1 ...; of several inputs a list",
       [](lua_State* L, const M& m) { push_polynomials(L, m.F); }},
      {"theta", "pl.Vector", "all parameters", [](lua_State* L, const M& m) { push_numbers(L, m.parameters()); }},
      {"names", "string[]", "of the parameters", [](lua_State* L, const M& m) { push_texts(L, m.parameter_names()); }},
      {"deviations", "pl.Vector", "standard deviations of the parameters",
       [](lua_State* L, const M& m) { push_numbers(L, m.covariance.diagonal().cwiseSqrt()); }},
      {"covariance", "pl.Vector", "of the parameters", [](lua_State* L, const M& m) { push_matrix(L, m.covariance); }},
      {"variance", "number", "of the noise", [](lua_State* L, const M& m) { lua_pushnumber(L, m.variance); }},
      {"gain", "number|pl.Vector", "at rest, of each input",
       [](lua_State* L, const M& m) {
         Eigen::VectorXd gains(static_cast<Index>(m.B.size()));
         for (std::size_t i = 0; i < m.B.size(); ++i) gains[static_cast<Index>(i)] = m.gain(i);
         if (gains.size() == 1) return lua_pushnumber(L, gains[0]);
         push_numbers(L, gains);
       }},
      {"delay", "pl.Vector", "samples, of each input",
       [](lua_State* L, const M& m) {
         Eigen::VectorXd d(static_cast<Index>(m.delay.size()));
         for (Index i = 0; i < d.size(); ++i) d[i] = m.delay[static_cast<std::size_t>(i)];
         push_numbers(L, d);
       }},
      {"offset", "number?", "the constant, where one was estimated",
       [](lua_State* L, const M& m) {
         if (!m.has_offset) return lua_pushnil(L);
         lua_pushnumber(L, m.offset);
       }},
      {"level", "number", "of the output at rest, with the inputs at their operating point",
       [](lua_State* L, const M& m) { lua_pushnumber(L, m.level()); }},
      {"initial", "string", "how the past before a record is taken: rest or estimate",
       [](lua_State* L, const M& m) { push_text(L, m.initial == identify::Initial::rest ? "rest" : "estimate"); }},
      {"structure", "string", "FIR, ARX, ARMAX, OE, BJ", [](lua_State* L, const M& m) { push_text(L, m.structure); }},
      {"Ts", "number", "s", [](lua_State* L, const M& m) { lua_pushnumber(L, m.Ts); }},
      {"stable", "boolean", "all poles inside the unit circle",
       [](lua_State* L, const M& m) { lua_pushboolean(L, m.is_stable() ? 1 : 0); }},
      {"report", "table", "method, samples, reached, measure, iterations, stopped, tried, warnings, text",
       [](lua_State* L, const M& m) { push_report(L, m.fit); }},
  };
  return list;
}

}  // namespace

Entries identify_linear_functions() {
  const std::string_view rest =
      "delay?: integer|integer[], output?: string, remove_means?: boolean, offset?: boolean, "
      "initial?: \"rest\"|\"estimate\", ridge?: number, iterations?: integer}";
  static const std::string fir_options = fmt::format("data: pl.DataSet, options?: {{nb?: integer|integer[], {}", rest);
  static const std::string arx_options =
      fmt::format("data: pl.DataSet, options?: {{na?: integer, nb?: integer|integer[], {}", rest);
  static const std::string armax_options =
      fmt::format("data: pl.DataSet, options?: {{na?: integer, nb?: integer|integer[], nc?: integer, {}", rest);
  static const std::string oe_options =
      fmt::format("data: pl.DataSet, options?: {{nb?: integer|integer[], nf?: integer|integer[], {}", rest);
  static const std::string bj_options = fmt::format(
      "data: pl.DataSet, options?: {{nb?: integer|integer[], nc?: integer, nd?: integer, nf?: integer|integer[], {}",
      rest);
  static const std::string filtered_options =
      fmt::format("data: pl.DataSet, options?: {{na?: integer, nb?: integer|integer[], passes?: integer, {}", rest);
  return {
      {"fir", guarded<fir>, fir_options, "pl.LinearModel",
       "y = q^-delay B u + v by least squares; `offset`, here and in all others, adds a constant"},
      {"arx", guarded<arx>, arx_options, "pl.LinearModel", "A y = q^-delay B u + v by least squares"},
      {"armax", guarded<armax>, armax_options, "pl.LinearModel",
       "A y = q^-delay B u + C v by the prediction error method"},
      {"oe", guarded<oe>, oe_options, "pl.LinearModel", "y = q^-delay B/F u + v: output error"},
      {"bj", guarded<bj>, bj_options, "pl.LinearModel", "y = q^-delay B/F u + C/D v: Box-Jenkins"},
      {"filtered", guarded<filtered>, filtered_options, "pl.LinearModel",
       "an output-error model by least squares of signals filtered by 1/A of the pass before"},
      {"instrumental", guarded<instrumental>, arx_options, "pl.LinearModel",
       "ARX by instrumental variables: unbiased with coloured noise"},
      {"state_space", guarded<state_space>,
       "data: pl.DataSet, options?: {order?: integer, highest?: integer, block_rows?: integer, remove_means?: boolean, "
       "offset?: boolean, feedthrough?: boolean}",
       "pl.StateSpaceModel", "the subspace method PO-MOESP; the order from the singular values unless told"},
      {"order_table", guarded<order_table>,
       "data: pl.DataSet, options?: {na?: integer[], nb?: integer[], delay?: integer[], output?: string, "
       "remove_means?: boolean, offset?: boolean, validation?: pl.DataSet}",
       "table[]", "every ARX structure in the ranges with AIC, MDL, FPE and free-run error; .best names the least"},
      {"delay_table", guarded<delay_table>,
       "data: pl.DataSet, options?: {order?: integer, delay?: integer[], output?: string, remove_means?: boolean, "
       "offset?: boolean, initial?: \"rest\"|\"estimate\"}",
       "pl.Vector, pl.Vector", "delays, and the error of the output-error model of each"},
      {"information_test", guarded<information_test>,
       "data: pl.DataSet, options?: {highest?: integer, delay?: integer, output?: string, remove_means?: boolean, "
       "offset?: boolean}",
       "pl.Vector, integer", "det(Psi'Psi/N) for orders 1, 2, ..., and the order that it tells"},
      {"least_squares", guarded<least_squares>, "X: pl.Vector, y: pl.Vector, options?: {ridge?: number}", "table",
       "theta, covariance, deviations, residuals, sse, variance, rank, condition, warnings"},
      {"recursive_least_squares", guarded<recursive>,
       "X: pl.Vector, y: pl.Vector, options?: {forgetting?: number, initial_covariance?: number}",
       "pl.Vector, pl.Vector, pl.Vector", "the estimate after each row, the errors before it, and P at the end"},
  };
}

Entries linear_model_methods() {
  return {
      {"simulate", guarded<simulate>,
       "data: pl.DataSet, options?: {start?: \"measured\"|\"estimated\"|\"zero\", samples?: integer}", "pl.Vector",
       "free run: the outputs are the model's own; measured is the start of models with A, else estimated"},
      {"predict", guarded<predict>, "data: pl.DataSet, steps?: integer, options?: {initial?: \"rest\"|\"estimate\"}",
       "pl.Vector", "the output that many steps after the last measured one"},
      {"residuals", guarded<residuals>, "data: pl.DataSet, options?: {initial?: \"rest\"|\"estimate\"}", "pl.Vector",
       "measured less predicted one step ahead"},
      {"response", guarded<response>, "w: pl.Vector, input?: integer", "table",
       "frequency response: w, magnitude, phase, deviation, phase_deviation"},
      {"state_space", guarded<convert>, "", "pl.StateSpaceModel", "the same in observer form"},
      {"save", guarded<save>, "path: string", "string", "writes a model file, .yaml; gives the path"},
  };
}

std::vector<FieldInfo> linear_model_fields() { return infos_of(fields()); }

void push_linear_model(lua_State* L, PolynomialModel model) { push_model(L, std::move(model)); }
void open_linear_models(lua_State* L) { open_held<PolynomialModel>(L, linear_kind, linear_model_methods(), fields()); }

}  // namespace plantloop::lua
