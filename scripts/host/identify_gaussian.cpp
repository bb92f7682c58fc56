// pl.identify.gaussian_process: fits, processes at given hyperparameters, and what they know of their data.

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <optional>

#include "identify/gp/gp_map.h"
#include "scripts/host/identify_models.h"
#include "scripts/host/identify_objects.h"

namespace plantloop::lua {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using identify::DataSet;
using identify::GpMap;
using identify::Hyperparameters;
using identify::NarxModel;
using identify::RegressorSet;

// One linear model or a list of them.
std::vector<identify::PolynomialModel> local_models_of(lua_State* L, const Options& o) {
  std::vector<identify::PolynomialModel> list;
  if (!o.push("local_models")) return list;
  const auto take = [&](int index) {
    list.push_back(held_argument<identify::PolynomialModel>(L, index, linear_kind, "local_models"));
  };
  if (lua_istable(L, -1)) {
    for (lua_Integer i = 1; i <= luaL_len(L, -1); ++i) {
      lua_rawgeti(L, -1, i);
      take(-1);
      lua_pop(L, 1);
    }
  } else {
    take(-1);
  }
  lua_pop(L, 1);
  return list;
}

// Rows of the user's own: columns x1, x2, ... of X, and the outputs, without a past.
DataSet data_of(const MatrixXd& X, const MatrixXd& Y) {
  if (X.rows() != Y.rows())
    throw ScriptError(fmt::format("X has {} rows and y {}; they must agree", X.rows(), Y.rows()));
  if (X.cols() == 0) throw ScriptError("X has no column; a process needs at least one input");
  std::vector<identify::Channel> inputs, outputs;
  for (Index d = 0; d < X.cols(); ++d) inputs.push_back({fmt::format("x{}", d + 1), ""});
  for (Index o = 0; o < Y.cols(); ++o) outputs.push_back({Y.cols() == 1 ? "y" : fmt::format("y{}", o + 1), ""});
  return identify::make_data_set(X, Y, 1, std::move(inputs), std::move(outputs));
}

RegressorSet inputs_of(const DataSet& data) {
  RegressorSet set = identify::parse_regressors("1", data);
  set.list.clear();
  for (int c = 0; c < static_cast<int>(data.inputs.size()); ++c) set.list.push_back({{{false, c, 0, 1}}});
  return set;
}

// Names in the order of the model file, v0 last.
std::vector<std::string> names_of(const identify::Covariance& covariance, int inputs) {
  std::vector<std::string> names = covariance.names(inputs);
  names.emplace_back("v0");
  return names;
}

// The table on the stack.
Hyperparameters hyperparameters_of(lua_State* L, const identify::Covariance& covariance, int inputs) {
  if (!lua_istable(L, -1))
    throw ScriptError(
        fmt::format("'hyperparameters' must be a table of names and numbers, here is {}", describe(L, -1)));
  const std::vector<std::string> names = names_of(covariance, inputs);
  const std::string all = fmt::format("'{}' of {} regressor{} has {}", covariance.name(), inputs,
                                      inputs == 1 ? "" : "s", fmt::join(names, ", "));
  Eigen::VectorXd values(static_cast<Index>(names.size()));
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (lua_getfield(L, -1, names[i].c_str()) == LUA_TNIL)
      throw ScriptError(fmt::format("'hyperparameters' lack '{}': {}", names[i], all));
    values[static_cast<Index>(i)] = number_argument(L, -1, names[i]);
    lua_pop(L, 1);
  }
  lua_pushnil(L);
  while (lua_next(L, -2) != 0) {
    lua_pop(L, 1);
    const std::string name = lua_type(L, -1) == LUA_TSTRING ? lua_tostring(L, -1) : describe(L, -1);
    if (std::find(names.begin(), names.end(), name) == names.end())
      throw ScriptError(fmt::format("there is no hyperparameter '{}': {}", name, all));
  }
  return {values.head(values.size() - 1), values[values.size() - 1]};
}

// One table for all outputs, or a list of one for each.
std::vector<Hyperparameters> given_hyperparameters(lua_State* L, const Options& o, const std::string& covariance,
                                                   const RegressorSet& set) {
  std::vector<Hyperparameters> list;
  if (!o.push("hyperparameters")) return list;
  const auto form = identify::find_covariance(covariance);
  const int inputs = static_cast<int>(set.size());
  const bool is_list = lua_istable(L, -1) && luaL_len(L, -1) > 0;
  for (lua_Integer i = 1; is_list && i <= luaL_len(L, -1); ++i) {
    lua_rawgeti(L, -1, i);
    list.push_back(hyperparameters_of(L, *form, inputs));
    lua_pop(L, 1);
  }
  if (!is_list) list.push_back(hyperparameters_of(L, *form, inputs));
  lua_pop(L, 1);
  return list;
}

// Through inducing inputs: their number, or a matrix of them.
std::optional<identify::SparseOptions> sparse_options(lua_State* L, const Options& o) {
  const std::string approximation = o.text("approximation", "subset");
  if (approximation != "subset" && approximation != "fitc" && approximation != "vfe")
    o.wrong("approximation", "subset, fitc or vfe");
  if (approximation == "subset") {
    for (const char* key : {"inducing", "hold_inducing", "refined"}) {
      if (o.has(key)) throw ScriptError(fmt::format("'{}' is for approximation = \"fitc\" or \"vfe\"", key));
    }
    return std::nullopt;
  }
  if (o.has("points"))
    throw ScriptError("'points' is for approximation = \"subset\"; all rows are seen through the inducing inputs");
  identify::SparseOptions s;
  s.method = identify::find_sparse_method(approximation);
  if (o.push("inducing")) {
    if (lua_type(L, -1) == LUA_TNUMBER) {
      s.inducing = integer(o, "inducing", s.inducing);
    } else {
      s.inputs = matrix_of(L, -1, "inducing");
    }
    lua_pop(L, 1);
  }
  s.hold = o.flag("hold_inducing");
  s.refined = integer(o, "refined", s.refined);
  return s;
}

int gaussian_process(lua_State* L) {
  const bool own_rows = test_object<Held<DataSet>>(L, 1, data_kind) == nullptr && is_given(L, 1);
  if (own_rows && test_array(L, 1) == nullptr && !lua_istable(L, 1))
    throw ScriptError(
        fmt::format("'data' must be a data set, or X a matrix with y behind it; it is {}", describe(L, 1)));
  const Options o(L, own_rows ? 3 : 2, "the options of gaussian_process",
                  {"regressors", "covariance", "mean", "starts", "iterations", "points", "seed", "local_models",
                   "hyperparameters", "normalise", "approximation", "inducing", "hold_inducing", "refined"});
  if (own_rows && o.has("regressors"))
    throw ScriptError("'regressors' are of a data set; here the columns of X are the regressors");
  if (own_rows && o.has("local_models"))
    throw ScriptError("'local_models' are of a data set with a past, not of X and y");
  const DataSet data = own_rows ? data_of(matrix_of(L, 1, "X"), matrix_of(L, 2, "y")) : data_argument(L, 1);
  const RegressorSet set = own_rows ? inputs_of(data) : plain_regressors(o, data);
  identify::GpModelOptions m;
  identify::GpOptions& g = m.process;
  if (o.has("covariance")) g.covariance = o.text("covariance");
  if (o.has("mean")) g.mean = o.text("mean");
  m.given = given_hyperparameters(L, o, g.covariance, set);
  g.starts = integer(o, "starts", m.given.empty() ? g.starts : 1);
  g.max_iterations = integer(o, "iterations", m.given.empty() ? g.max_iterations : 0);
  if (g.max_iterations < 0) o.wrong("iterations", "0 or more");
  g.seed = seed_of(o);
  // What is only evaluated is evaluated at all rows.
  const bool trained = m.given.empty() || g.max_iterations > 0;
  m.most = integer(o, "points", trained ? m.most : std::numeric_limits<int>::max());
  if (m.most < 1) o.wrong("points", "1 or more");
  m.normalise = o.has("normalise") ? o.flag("normalise") : m.given.empty();
  m.sparse = sparse_options(L, o);
  push_learned_model(L, identify::fit_narx_gp(data, set, m, control_of(L), local_models_of(L, o)));
  return 1;
}

const NarxModel& self(lua_State* L) { return held_self<NarxModel>(L, learned_kind); }

const GpMap& gp_self(lua_State* L, std::string_view what) {
  const auto* map = dynamic_cast<const GpMap*>(self(L).map.get());
  if (map == nullptr)
    throw ScriptError(fmt::format("only a gaussian_process {}, this is a {}", what, self(L).map->type()));
  return *map;
}

Index output_of(lua_State* L, int index, const GpMap& map) {
  return is_given(L, index) ? integer_argument(L, index, "output", 1, map.outputs()) - 1 : 0;
}

// {w1 = ..., v1 = ..., v0 = ...}
void push_named(lua_State* L, const identify::GpPosterior& process, const Eigen::VectorXd& values) {
  lua_newtable(L);
  const std::vector<std::string> names = names_of(process.covariance(), process.inputs());
  for (std::size_t i = 0; i < names.size(); ++i) {
    lua_pushnumber(L, values[static_cast<Index>(i)]);
    lua_setfield(L, -2, names[i].c_str());
  }
}

int hyperparameters(lua_State* L) {
  const GpMap& map = gp_self(L, "has hyperparameters");
  const identify::GpPosterior& process = map.process(output_of(L, 2, map));
  const Hyperparameters& at = process.hyperparameters();
  Eigen::VectorXd all(at.theta.size() + 1);
  all << at.theta, at.v0;
  push_named(L, process, all);
  return 1;
}

int log_likelihood(lua_State* L) {
  const GpMap& map = gp_self(L, "has a likelihood");
  lua_pushnumber(L, map.log_likelihood(output_of(L, 2, map)));
  return 1;
}

// A likelihood with its gradient, and the matrix behind leave-one-out, need the cube of the points.
void count_cube(lua_State* L, const GpMap& map) {
  const auto points = static_cast<double>(map.process(0).x().rows());
  session_of(L).sandbox.work(L, points * points * static_cast<double>(map.process(0).samples()) / 10);
}

int gradient(lua_State* L) {
  const GpMap& map = gp_self(L, "has a likelihood");
  count_cube(L, map);
  const Index output = output_of(L, 2, map);
  const identify::Likelihood found = map.likelihood(output);
  push_named(L, map.process(output), found.gradient);
  if (found.by_inducing.size() == 0) return 1;
  push_matrix(L, found.by_inducing);
  return 2;
}

int inducing(lua_State* L) {
  const GpMap& map = gp_self(L, "has inducing inputs");
  const identify::GpPosterior& process = map.process(output_of(L, 2, map));
  if (!process.is_sparse())
    throw ScriptError(
        "this process knows its points themselves; approximation = \"fitc\" or \"vfe\" has inducing inputs");
  push_matrix(L, map.x_scaling().original(process.x()));
  return 1;
}

int leave_one_out(lua_State* L) {
  const GpMap& map = gp_self(L, "predicts its own points from the others");
  count_cube(L, map);
  const identify::LeaveOneOut found = map.leave_one_out(output_of(L, 2, map));
  lua_newtable(L);
  const auto vector = [L](const char* key, const Eigen::VectorXd& values) {
    push_numbers(L, values);
    lua_setfield(L, -2, key);
  };
  vector("mean", found.mean);
  vector("variance", found.variance);
  vector("log_density", found.log_density);
  lua_pushnumber(L, found.log_probability);
  lua_setfield(L, -2, "log_probability");
  return 1;
}

int uncertain(lua_State* L) {
  const Options o(L, 3, "the options of uncertain", {"propagation", "trajectories", "seed", "noise"});
  const bool noise = !o.has("noise") || o.flag("noise");
  const identify::Outputs found =
      o.has("trajectories")
          ? identify::simulate_monte_carlo(self(L), data_argument(L, 2), integer(o, "trajectories", 1000), seed_of(o),
                                           noise)
          : identify::simulate_uncertain(self(L), data_argument(L, 2),
                                         identify::find_propagation(o.text("propagation", "moment_matching")), noise);
  const Index outputs = self(L).map->outputs();
  identify::Outputs means, variances, covariances;
  for (const Eigen::MatrixXd& part : found) {
    means.emplace_back(part.leftCols(outputs));
    covariances.emplace_back(part.rightCols(outputs * outputs));
    Eigen::MatrixXd own(part.rows(), outputs);
    for (Index i = 0; i < outputs; ++i) own.col(i) = covariances.back().col(i * (outputs + 1));
    variances.push_back(std::move(own));
  }
  push_outputs(L, means);
  push_outputs(L, variances);
  push_outputs(L, covariances);
  return 3;
}

int propagate(lua_State* L) {
  gp_self(L, "knows how uncertain it is");
  const Options o(L, 4, "the options of propagate", {"propagation"});
  const identify::UncertainPoint point{vector_of(L, 2, "x"), matrix_of(L, 3, "covariance")};
  const auto map = std::dynamic_pointer_cast<const GpMap>(self(L).map);
  identify::check_point(point, map->inputs());
  const identify::UncertainMap uncertain(map, identify::find_propagation(o.text("propagation", "moment_matching")));
  const identify::UncertainPrediction found = uncertain.predict(point);
  push_numbers(L, found.mean);
  push_matrix(L, found.covariance);
  push_matrix(L, found.slope * point.covariance);
  return 3;
}

int add(lua_State* L) {
  const NarxModel& model = self(L);
  const GpMap& map = gp_self(L, "takes in single measurements");
  const DataSet& data = data_argument(L, 2);
  identify::check_data(model, data);
  const identify::Regression rows = identify::make_regression(data, model.regressors);
  NarxModel more = model;
  more.map = identify::with_measurements(map, rows.X, rows.Y);
  more.fit.samples += rows.X.rows();
  more.fit.options.push_back(fmt::format("{} samples added with the hyperparameters kept", rows.X.rows()));
  push_learned_model(L, std::move(more));
  return 1;
}

}  // namespace

Entries gaussian_process_functions() {
  return {
      {"gaussian_process", guarded<gaussian_process>,
       "data: pl.DataSet|pl.Vector, options: {regressors: string, covariance?: string, mean?: "
       "\"zero\"|\"constant\"|\"linear\", starts?: integer, iterations?: integer, points?: integer, seed?: integer, "
       "local_models?: pl.LinearModel|pl.LinearModel[], hyperparameters?: table, normalise?: boolean, "
       "approximation?: \"subset\"|\"fitc\"|\"vfe\", inducing?: integer|pl.Vector, hold_inducing?: boolean, refined?: "
       "integer}",
       "pl.LearnedModel",
       "a Gaussian process by maximum likelihood, for each output; from more rows than `points` the most spread ones "
       "are taken; local_models: linear models at operating points, whose values at rest and slopes are observed too; "
       "hyperparameters: {w1 = 1, v1 = 1, v0 = 0.01}, kept as they are unless `iterations` are given, and the data not "
       "normalised unless `normalise` is true; approximation: fitc and vfe see all rows through `inducing` inputs, "
       "their "
       "number or a matrix of them, trained too unless held, from the `refined` best optima of an exact process of "
       "some rows; "
       "gaussian_process(X, y, options): of rows of your own"},
  };
}

Entries gaussian_process_methods() {
  return {
      {"hyperparameters", guarded<hyperparameters>, "output?: integer", "table<string, number>",
       "of a Gaussian process, by their names; v0 is the variance of the noise"},
      {"log_likelihood", guarded<log_likelihood>, "output?: integer", "number",
       "log p(y | X) of a Gaussian process at its hyperparameters, of the targets in their units"},
      {"gradient", guarded<gradient>, "output?: integer", "table<string, number>, pl.Vector?",
       "of the log likelihood by the logarithm of each hyperparameter; of a sparse process also by its inducing "
       "inputs"},
      {"inducing", guarded<inducing>, "output?: integer", "pl.Vector",
       "the inducing inputs of a sparse Gaussian process, a row of regressors each"},
      {"leave_one_out", guarded<leave_one_out>, "output?: integer", "table",
       "each target of a Gaussian process predicted from the others: mean, variance (with noise), log_density, and "
       "their "
       "sum log_probability"},
      {"uncertain", guarded<uncertain>,
       "data: pl.DataSet, options?: {propagation?: \"naive\"|\"first_order\"|\"moment_matching\", trajectories?: "
       "integer, seed?: integer, noise?: boolean}",
       "pl.Vector, pl.Vector, pl.Vector",
       "free run of a Gaussian process: mean and variance of the function, and, of several outputs, their covariances "
       "with each other, row by row; trajectories: drawn at random instead; noise: that the outputs fed back have "
       "noise"},
      {"propagate", guarded<propagate>,
       "x: pl.Vector, covariance: pl.Vector, options?: {propagation?: \"naive\"|\"first_order\"|\"moment_matching\"}",
       "pl.Vector, pl.Vector, pl.Vector",
       "a Gaussian process where the regressors are uncertain themselves, with that mean and covariance: means and "
       "covariances of the outputs, and covariances of each output (a row) with the regressors"},
      {"add", guarded<add>, "data: pl.DataSet", "pl.LearnedModel",
       "a Gaussian process with more measurements; its hyperparameters stay"},
  };
}

}  // namespace plantloop::lua
