// pl.identify: networks, local models and Gaussian processes, trained on data.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "identify/gp/gp_map.h"
#include "identify/local_models/local_model_network.h"
#include "identify/mlp/fit_mlp.h"
#include "identify/mlp/prune.h"
#include "identify/rbf/rbf_network.h"
#include "scripts/host/identify_models.h"
#include "scripts/host/identify_objects.h"

namespace plantloop::lua {

using identify::RegressorSet;

RegressorSet plain_regressors(const Options& o, const identify::DataSet& data) {
  if (!o.has("regressors")) throw ScriptError("'regressors' are missing, as in regressors = \"y(k-1), u(k-1..2)\"");
  return identify::parse_regressors(o.text("regressors"), data);
}

std::uint64_t seed_of(const Options& o) {
  const int seed = integer(o, "seed", 1);
  if (seed < 0) o.wrong("seed", "a whole number, 0 or more");
  return static_cast<std::uint64_t>(seed);
}

namespace {

using Eigen::Index;
using identify::DataSet;
using identify::NarxModel;

// What the name of a structure asks for, against what the regressors and orders give.
void check_structure(const Options& o, const RegressorSet& set, identify::MlpOptions& m) {
  if (!o.has("structure")) return;
  const std::string structure = o.text("structure");
  const bool noise = set.errors > 0 || m.nc > 0 || m.nd > 0;
  if (structure == "NOE" || structure == "NBJ") {
    m.simulation = true;
  } else if (structure != "NFIR" && structure != "NARX" && structure != "NARMAX") {
    o.wrong("structure", "NFIR, NARX, NOE, NARMAX or NBJ");
  } else if (m.simulation && structure == "NARMAX") {
    throw ScriptError("NARMAX is fitted to prediction errors; the structure for 'simulation' with noise is NBJ");
  }
  if ((structure == "NARMAX" || structure == "NBJ") && !noise)
    throw ScriptError(structure == "NBJ" ? "NBJ needs an order of its noise filter, as in nc = 1, nd = 1"
                                         : "NARMAX needs a noise model: regressors such as e(k-1), or nc = 1");
  if (structure != "NARMAX" && structure != "NBJ" && noise)
    throw ScriptError(
        fmt::format("{} has no noise model, but there are prediction errors e(k-1) or orders nc, nd", structure));
  if (structure == "NFIR" && set.uses_outputs()) throw ScriptError("NFIR has no regressors of outputs");
  if (structure != "NFIR" && !set.uses_outputs())
    throw ScriptError(fmt::format("{} has past outputs among its regressors, as y(k-1)", structure));
}

int mlp(lua_State* L) {
  const DataSet& data = data_argument(L, 1);
  const Options o(
      L, 2, "the options of mlp",
      {"regressors", "hidden", "activation", "method", "starts", "iterations", "decay", "simulation", "validation",
       "patience", "spread", "seed", "direct", "refined", "horizons", "one_step_iterations", "structure", "nc", "nd"});
  identify::MlpOptions m;
  if (o.has("hidden")) m.hidden = integers(L, o, "hidden");
  if (o.has("activation")) m.activation = identify::find_activation(o.text("activation"));
  if (o.has("method")) m.training.method = identify::find_training_method(o.text("method"));
  m.starts = integer(o, "starts", m.starts);
  m.training.iterations = integer(o, "iterations", m.training.iterations);
  m.training.patience = integer(o, "patience", m.training.patience);
  m.training.decay = o.number("decay").value_or(0);
  m.spread = o.number("spread").value_or(m.spread);
  m.simulation = o.flag("simulation");
  m.direct = o.flag("direct");
  m.refined = integer(o, "refined", m.refined);
  m.one_step_iterations = integer(o, "one_step_iterations", 0);
  if (o.has("horizons")) m.horizons = integers(L, o, "horizons");
  m.seed = seed_of(o);
  m.nc = integer(o, "nc", 0);
  m.nd = integer(o, "nd", 0);
  const RegressorSet set = plain_regressors(o, data);
  check_structure(o, set, m);
  DataSet none;
  const DataSet* validation = &none;
  if (o.push("validation")) validation = &data_argument(L, -1);
  push_learned_model(L, identify::fit_narx_mlp(data, set, *validation, m, control_of(L)).model);
  return 1;
}

// The report, with a warning of the rows that missing values cost.
identify::FitReport with_gaps(identify::FitReport report, const identify::Regression& rows) {
  if (rows.left_out > 0)
    report.warnings.push_back(fmt::format("{} rows with missing values were left out.", rows.left_out));
  return report;
}

int rbf_network(lua_State* L) {
  const DataSet& data = data_argument(L, 1);
  const Options o(L, 2, "the options of rbf_network",
                  {"regressors", "function", "centres", "functions", "width", "constant", "ridge", "tolerance",
                   "optimise", "iterations", "seed"});
  identify::RbfOptions r;
  if (o.has("function")) r.function = identify::find_radial(o.text("function"));
  if (o.has("centres")) r.centres = identify::find_rbf_centres(o.text("centres"));
  r.functions = integer(o, "functions", r.functions);
  r.width = o.number("width").value_or(r.width);
  if (o.has("constant")) r.constant = o.flag("constant");
  r.ridge = o.number("ridge").value_or(r.ridge);
  r.tolerance = o.number("tolerance").value_or(0);
  r.optimise = o.flag("optimise");
  r.iterations = integer(o, "iterations", r.iterations);
  r.seed = seed_of(o);
  const RegressorSet set = plain_regressors(o, data);
  const identify::Regression rows = identify::make_regression(data, set);
  const identify::RbfFit fit = identify::fit_rbf(rows.X, rows.Y, r, control_of(L));
  push_learned_model(L, identify::make_narx(fit.model, set, data, with_gaps(fit.report, rows)));
  return 1;
}

int local_models(lua_State* L) {
  const DataSet& data = data_argument(L, 1);
  const Options o(L, 2, "the options of local_models",
                  {"regressors", "models", "cells", "scheduling", "estimation", "width", "ridge"});
  identify::LocalModelOptions l;
  for (const int number : integers(L, o, "scheduling")) l.scheduling.push_back(number - 1);
  const std::string estimation = o.text("estimation", "local");
  if (estimation != "local" && estimation != "global") o.wrong("estimation", "local or global");
  if (estimation == "global") l.estimation = identify::LocalEstimation::global;
  l.width = o.number("width").value_or(l.width);
  l.ridge = o.number("ridge").value_or(l.ridge);
  if (o.has("models") && o.has("cells")) throw ScriptError("a tree has 'models', a grid has 'cells'; give one of them");
  const RegressorSet set = plain_regressors(o, data);
  const identify::Regression rows = identify::make_regression(data, set);
  const identify::LocalModelFit fit =
      o.has("cells") ? identify::fit_local_grid(rows.X, rows.Y, integer(o, "cells", 3), l, control_of(L))
                     : identify::fit_lolimot(rows.X, rows.Y, integer(o, "models", 10), l, control_of(L));
  push_learned_model(L, identify::make_narx(fit.model, set, data, with_gaps(fit.report, rows)));
  return 1;
}

const NarxModel& self(lua_State* L) { return held_self<NarxModel>(L, learned_kind); }

int simulate(lua_State* L) {
  const NarxModel& m = self(L);
  const auto run = [&m](const DataSet& data) { return identify::free_run(m, data); };
  const DataSet& data = data_argument(L, 2);
  push_outputs(L, starts_at_zero(L, 3) ? identify::from_zero(data, m.regressors.longest_lag(), run) : run(data));
  return 1;
}

int residuals(lua_State* L) {
  const DataSet& data = data_argument(L, 2);
  push_residuals(L, data, identify::one_step(self(L), data));
  return 1;
}

// At points of the user's own: rows of regressors.
int predict_points(lua_State* L) {
  const identify::Approximator& map = *self(L).map;
  const Eigen::MatrixXd X = matrix_of(L, 2, "X");
  if (X.cols() != map.inputs())
    throw ScriptError(fmt::format("X has {} column{}, the model {} regressor{}; each row of X is a point", X.cols(),
                                  X.cols() == 1 ? "" : "s", map.inputs(), map.inputs() == 1 ? "" : "s"));
  const auto* gp = dynamic_cast<const identify::GpMap*>(&map);
  Eigen::MatrixXd y(X.rows(), map.outputs()), variance = y, measured = y;
  std::vector<double> scratch(static_cast<std::size_t>(map.scratch_size()));
  Eigen::VectorXd x(map.inputs()), row(map.outputs());
  const double each = gp == nullptr ? 1e3 : 1e3 + std::pow(static_cast<double>(gp->process(0).x().rows()), 2);
  constexpr Index some = 256;  // variances of many points at a time are several times faster
  for (Index first = 0; first < X.rows(); first += some) {
    const Index rows = std::min(some, X.rows() - first);
    session_of(L).sandbox.work(L, static_cast<double>(rows) * each / 8);
    for (Index i = first; i < first + rows; ++i) {
      x = X.row(i).transpose();
      map.evaluate(x.data(), row.data(), scratch.data());
      y.row(i) = row.transpose();
    }
    for (Index o = 0; gp != nullptr && o < y.cols(); ++o) {
      const Eigen::MatrixXd points = gp->x_scaling().normalised(X.middleRows(first, rows));
      const double scale = gp->y_scaling().scale[o];
      variance.col(o).segment(first, rows) = scale * scale * gp->process(o).predict(points).variance;
    }
  }
  for (Index o = 0; gp != nullptr && o < y.cols(); ++o)
    measured.col(o) = variance.col(o).array() + gp->noise_variance(o);
  push_columns(L, y);
  if (gp == nullptr) return 1;
  push_columns(L, variance);
  push_columns(L, measured);
  return 3;
}

int predict(lua_State* L) {
  if (test_array(L, 2) != nullptr || lua_istable(L, 2)) return predict_points(L);
  const std::int64_t steps = is_given(L, 3) ? integer_argument(L, 3, "steps", 1, 1'000'000) : 1;
  push_outputs(L, identify::k_step(self(L), data_argument(L, 2), static_cast<int>(steps)));
  return 1;
}

int prune(lua_State* L) {
  const NarxModel& model = self(L);
  const Options o(L, 3, "the options of prune", {"test", "decay", "iterations", "least"});
  const auto* map = dynamic_cast<const identify::Mlp*>(model.map.get());
  if (map == nullptr) throw ScriptError(fmt::format("only an mlp can be pruned, this is a {}", model.map->type()));
  if (model.has_noise_model())
    throw ScriptError(fmt::format("a network with a noise model ({}) is not pruned; prune the NARX model",
                                  identify::structure_name(model)));
  identify::PruneOptions p;
  p.decay = o.number("decay").value_or(0);
  p.iterations = integer(o, "iterations", p.iterations);
  p.least = integer(o, "least", p.least);
  const DataSet& data = data_argument(L, 2);
  identify::check_data(model, data);
  const identify::Regression rows = identify::make_regression(data, model.regressors);
  identify::Regression test;
  if (o.push("test")) {
    identify::check_data(model, data_argument(L, -1));
    test = identify::make_regression(data_argument(L, -1), model.regressors);
  }
  const identify::Pruned pruned = identify::prune(*map, rows.X, rows.Y, test.X, test.Y, p, control_of(L));
  push_learned_model(L, identify::make_narx(pruned.model, model.regressors, data, pruned.report));
  return 1;
}

int fit_free_run(lua_State* L) {
  const NarxModel& model = self(L);
  const Options o(L, 3, "the options of fit_free_run", {"iterations", "decay", "horizons", "validation", "patience"});
  const auto* map = dynamic_cast<const identify::Mlp*>(model.map.get());
  if (map == nullptr)
    throw ScriptError(fmt::format("only an mlp is fitted to its free run, this is a {}", model.map->type()));
  if (model.has_noise_model())
    throw ScriptError(
        fmt::format("a network with a noise model ({}) is fitted to its prediction errors, not to its "
                    "free run alone",
                    identify::structure_name(model)));
  identify::MlpOptions m;
  m.simulation = true;
  m.training.iterations = integer(o, "iterations", 100);
  m.training.patience = integer(o, "patience", m.training.patience);
  m.training.decay = o.number("decay").value_or(0);
  if (o.has("horizons")) m.horizons = integers(L, o, "horizons");
  DataSet none;
  const DataSet* validation = &none;
  if (o.push("validation")) validation = &data_argument(L, -1);
  identify::check_data(model, data_argument(L, 2));
  if (validation != &none) identify::check_data(model, *validation);
  push_learned_model(
      L, identify::refine_narx_mlp(data_argument(L, 2), model.regressors, *map, m, false, control_of(L), *validation)
             .model);
  return 1;
}

int save(lua_State* L) {
  write_and_push(L, text_argument(L, 2, "path"), identify::to_yaml(self(L)), {".yaml"});
  return 1;
}

const identify::Network& network_of(const NarxModel& model) {
  const auto* map = dynamic_cast<const identify::Mlp*>(model.map.get());
  if (map == nullptr) throw ScriptError(fmt::format("only an mlp has layers, this is a {}", model.map->type()));
  return map->network();
}

Eigen::VectorXd layers_of(const NarxModel& model) {
  const identify::Network& network = network_of(model);
  Eigen::VectorXd sizes(static_cast<Index>(network.layers.size()) + 1);
  sizes[0] = static_cast<double>(network.inputs());
  for (std::size_t i = 0; i < network.layers.size(); ++i)
    sizes[static_cast<Index>(i) + 1] = static_cast<double>(network.layers[i].neurons());
  return sizes;
}

Eigen::VectorXd weights_of(const NarxModel& model) {
  const identify::Network& network = network_of(model);
  std::vector<double> weights;
  for (const identify::Layer& layer : network.layers) {
    for (Index n = 0; n < layer.neurons(); ++n)
      for (Index i = 0; i < layer.inputs(); ++i) weights.push_back(layer.w(n, i));
  }
  return Eigen::VectorXd::Map(weights.data(), static_cast<Index>(weights.size()));
}

Eigen::VectorXd joined(const std::vector<Eigen::VectorXd>& list) {
  Index size = 0;
  for (const Eigen::VectorXd& each : list) size += each.size();
  Eigen::VectorXd all(size);
  size = 0;
  for (const Eigen::VectorXd& each : list) {
    all.segment(size, each.size()) = each;
    size += each.size();
  }
  return all;
}

const std::vector<Field<NarxModel>>& fields() {
  using M = NarxModel;
  static const std::vector<Field<M>> list{
      {"type", "string", "mlp, rbf_network, local_model_network, gaussian_process",
       [](lua_State* L, const M& m) { push_text(L, m.map->type()); }},
      {"structure", "string", "NFIR, NARX (NOE too), NARMAX or NBJ",
       [](lua_State* L, const M& m) { push_text(L, identify::structure_name(m)); }},
      {"C", "pl.Vector", "of a linear noise filter C e = D (y - map): C of each output one after the other, else empty",
       [](lua_State* L, const M& m) { push_numbers(L, joined(m.noise.C)); }},
      {"D", "pl.Vector", "the same of D", [](lua_State* L, const M& m) { push_numbers(L, joined(m.noise.D)); }},
      {"noise_covariance", "pl.Vector", "of c1 ..., d1 ... of each output one after the other",
       [](lua_State* L, const M& m) { push_matrix(L, m.noise.covariance); }},
      {"names", "string[]", "the regressors",
       [](lua_State* L, const M& m) {
         std::vector<std::string> names;
         for (const identify::Regressor& r : m.regressors.list) names.push_back(to_text(r, m.regressors));
         push_texts(L, names);
       }},
      {"longest_lag", "integer", "samples before the first prediction",
       [](lua_State* L, const M& m) { lua_pushinteger(L, m.regressors.longest_lag()); }},
      {"layers", "pl.Vector", "of an mlp: its inputs and the neurons of each layer, as pl.figure:network takes them",
       [](lua_State* L, const M& m) { push_numbers(L, layers_of(m)); }},
      {"weights", "pl.Vector",
       "of an mlp: the weights of its layers between normalised signals, neuron by neuron without the biases; 0 was "
       "pruned",
       [](lua_State* L, const M& m) { push_numbers(L, weights_of(m)); }},
      {"Ts", "number", "s", [](lua_State* L, const M& m) { lua_pushnumber(L, m.channels.Ts); }},
      {"report", "table", "method, samples, reached, measure, iterations, stopped, tried, warnings, text",
       [](lua_State* L, const M& m) { push_report(L, m.fit); }},
  };
  return list;
}

}  // namespace

void push_learned_model(lua_State* L, NarxModel model) {
  // About what its file needs; a Gaussian process holds a factor too.
  std::size_t bytes = 4000;
  if (const auto* gp = dynamic_cast<const identify::GpMap*>(model.map.get())) {
    for (const auto& process : gp->processes()) {
      bytes += sizeof(double) * static_cast<std::size_t>(process->factor().size() + process->x().size());
      if (process->is_sparse())
        bytes += sizeof(double) *
                 static_cast<std::size_t>(2 * process->inner().size() + process->samples() * (process->inputs() + 1));
    }
  }
  push_held(L, learned_kind, std::move(model), bytes);
}

Entries identify_learned_functions() {
  return {
      {"mlp", guarded<mlp>,
       "data: pl.DataSet, options: {regressors: string, hidden?: integer|integer[], activation?: string, method?: "
       "string, starts?: integer, iterations?: integer, decay?: number, simulation?: boolean, validation?: pl.DataSet, "
       "patience?: integer, spread?: number, seed?: integer, direct?: boolean, refined?: integer, horizons?: "
       "integer|integer[], one_step_iterations?: integer, structure?: "
       "\"NFIR\"|\"NARX\"|\"NOE\"|\"NARMAX\"|\"NBJ\", nc?: integer, nd?: integer}",
       "pl.LearnedModel",
       "a multilayer perceptron from many starts; simulation: trained through time for the error of the free run; "
       "validation: each start ends where its error there is least; direct: from the inputs to the outputs too, "
       "beginning with the linear model; horizons: samples of the free runs, one training after the other, 0 the whole "
       "record; structure: NARMAX has prediction errors, e(k-1), among its regressors or a filter C of order nc, NBJ a "
       "simulated map and C e = D (y - map)"},
      {"rbf_network", guarded<rbf_network>,
       "data: pl.DataSet, options: {regressors: string, function?: string, centres?: \"ols\"|\"box\"|\"spread\", "
       "functions?: integer, width?: number, constant?: boolean, ridge?: number, tolerance?: number, optimise?: "
       "boolean, iterations?: integer, seed?: integer}",
       "pl.LearnedModel", "radial basis functions; their width is relative to the range of each regressor"},
      {"local_models", guarded<local_models>,
       "data: pl.DataSet, options: {regressors: string, models?: integer, cells?: integer, scheduling?: "
       "integer|integer[], estimation?: \"local\"|\"global\", width?: number, ridge?: number}",
       "pl.LearnedModel",
       "affine local models: a tree that grows to `models` of them, or a grid of `cells` along each scheduling "
       "variable, which are numbers of regressors"},
  };
}

Entries learned_model_methods() {
  Entries all = gaussian_process_methods();
  const Entries own{
      {"simulate", guarded<simulate>, "data: pl.DataSet, options?: {start?: \"measured\"|\"zero\"}", "pl.Vector",
       "free run: the outputs are the model's own, the first ones measured; start = \"zero\": all are its own, inputs "
       "and "
       "outputs were 0 before"},
      {"residuals", guarded<residuals>, "data: pl.DataSet", "pl.Vector",
       "measured less predicted one step ahead; the first ones, without a past, are NaN"},
      {"predict", guarded<predict>, "data: pl.DataSet|pl.Vector, steps?: integer", "pl.Vector, pl.Vector?, pl.Vector?",
       "the output that many steps after the last measured one; at points X, a row of regressors each: the output, and "
       "of "
       "a Gaussian process the variances of the function and of a measurement"},
      {"prune", guarded<prune>,
       "data: pl.DataSet, options?: {test?: pl.DataSet, decay?: number, iterations?: integer, least?: integer}",
       "pl.LearnedModel", "an mlp without the weights that are missed least (optimal brain surgeon)"},
      {"fit_free_run", guarded<fit_free_run>,
       "data: pl.DataSet, options?: {iterations?: integer, decay?: number, horizons?: integer|integer[], validation?: "
       "pl.DataSet, patience?: integer}",
       "pl.LearnedModel", "the same mlp trained on through time, for the error of its free run"},
      {"save", guarded<save>, "path: string", "string", "writes a model file, .yaml; gives the path"},
  };
  all.insert(all.begin(), own.begin(), own.end());
  return all;
}

std::vector<FieldInfo> learned_model_fields() { return infos_of(fields()); }

void open_learned_models(lua_State* L) { open_held<NarxModel>(L, learned_kind, learned_model_methods(), fields()); }

}  // namespace plantloop::lua
