// pl.identify: neural state-space models.

#include <fmt/format.h>

#include "identify/model_file/model_file.h"
#include "identify/neural_state_space/fit_neural_state_space.h"
#include "scripts/host/identify_models.h"
#include "scripts/host/identify_objects.h"

namespace plantloop::lua {
namespace {

using identify::NeuralStateSpace;

// Neurons of hidden layers; 0 is none.
std::vector<int> layers(lua_State* L, const Options& o, const char* key) {
  std::vector<int> list = integers(L, o, key);
  if (list == std::vector<int>{0}) list.clear();
  return list;
}

int neural_state_space(lua_State* L) {
  const Options o(L, 2, "the options of neural_state_space",
                  {"order", "hidden", "output_hidden", "projections", "integrating", "activation", "delay",
                   "feedthrough", "decay", "iterations", "starts", "refined", "seed"});
  identify::NeuralStateSpaceOptions n;
  n.order = integer(o, "order", n.order);
  if (o.has("hidden")) n.hidden = layers(L, o, "hidden");
  if (o.has("output_hidden")) n.output_hidden = layers(L, o, "output_hidden");
  if (o.has("activation")) n.activation = identify::find_activation(o.text("activation"));
  n.integrating = o.flag("integrating");
  n.projections = integer(o, "projections", 0);
  n.delay = integers(L, o, "delay");
  if (o.has("feedthrough")) n.feedthrough = o.flag("feedthrough");
  n.decay = o.number("decay").value_or(n.decay);
  n.iterations = integer(o, "iterations", n.iterations);
  n.starts = integer(o, "starts", n.starts);
  n.refined = integer(o, "refined", n.refined);
  n.seed = static_cast<std::uint64_t>(std::max(0, integer(o, "seed", 1)));
  push_neural_state_space(L, identify::fit_neural_state_space(data_argument(L, 1), n, control_of(L)));
  return 1;
}

const NeuralStateSpace& self(lua_State* L) { return held_self<NeuralStateSpace>(L, neural_state_space_kind); }

int simulate(lua_State* L) {
  const Options o(L, 3, "the options of simulate", {"start", "samples"});
  push_outputs(L, identify::simulate(self(L), data_argument(L, 2), start_of(o), start_samples(o)));
  return 1;
}

// Without a model of the noise, what is measured tells the state at the start and nothing later.
std::vector<Eigen::MatrixXd> predicted_neural(lua_State* L, const identify::DataSet& data) {
  return identify::simulate(self(L), data, identify::StateStart::estimated);
}

int predict(lua_State* L) {
  if (is_given(L, 3)) integer_argument(L, 3, "steps", 1, 1'000'000);
  push_outputs(L, predicted_neural(L, data_argument(L, 2)));
  return 1;
}

int residuals(lua_State* L) {
  const identify::DataSet& data = data_argument(L, 2);
  push_residuals(L, data, predicted_neural(L, data));
  return 1;
}

int fit_free_run(lua_State* L) {
  const Options o(L, 3, "the options of fit_free_run", {"iterations", "decay"});
  identify::NeuralStateSpaceOptions n;
  n.iterations = integer(o, "iterations", n.iterations);
  n.decay = o.number("decay").value_or(n.decay);
  push_neural_state_space(L, identify::refine(self(L), data_argument(L, 2), n, control_of(L)));
  return 1;
}

int save(lua_State* L) {
  write_and_push(L, text_argument(L, 2, "path"), identify::to_yaml("neural_state_space", identify::to_item(self(L))),
                 {".yaml"});
  return 1;
}

const std::vector<Field<NeuralStateSpace>>& fields() {
  using M = NeuralStateSpace;
  static const std::vector<Field<M>> list{
      {"order", "integer", "states", [](lua_State* L, const M& m) { lua_pushinteger(L, m.order()); }},
      {"deviations", "pl.Vector", "root mean square of each output's error over the data of the fit",
       [](lua_State* L, const M& m) { push_numbers(L, m.deviations); }},
      {"Ts", "number", "s", [](lua_State* L, const M& m) { lua_pushnumber(L, m.Ts); }},
      {"report", "table", "method, samples, reached, measure, iterations, stopped, tried, warnings, text",
       [](lua_State* L, const M& m) { push_report(L, m.fit); }},
  };
  return list;
}

}  // namespace

void push_neural_state_space(lua_State* L, NeuralStateSpace model) {
  const auto weights = model.transition->network().parameters() + model.output->network().parameters();
  push_held(L, neural_state_space_kind, std::move(model), static_cast<std::size_t>(weights) * sizeof(double) + 4000);
}

Entries identify_state_space_functions() {
  return {
      {"neural_state_space", guarded<neural_state_space>,
       "data: pl.DataSet, options?: {order?: integer, hidden?: integer|integer[], output_hidden?: integer|integer[], "
       "projections?: integer, integrating?: boolean, "
       "activation?: string, delay?: integer|integer[], feedthrough?: boolean, decay?: number, iterations?: integer, "
       "starts?: integer, refined?: integer, seed?: integer}",
       "pl.NeuralStateSpace",
       "x(k+1) = f(x, u), y = g(x, u): a linear model and beside it `hidden` neurons in f, `output_hidden` in g (0: "
       "none), trained through time for the error of the free run"},
  };
}

Entries neural_state_space_methods() {
  return {
      {"simulate", guarded<simulate>, "data: pl.DataSet, options?: {start?: \"estimated\"|\"zero\", samples?: integer}",
       "pl.Vector", "free run from the most probable state given the first samples, or from the state 0"},
      {"predict", guarded<predict>, "data: pl.DataSet, steps?: integer", "pl.Vector",
       "the output for any number of steps ahead: as there is no model of the noise, that of the free run from the "
       "estimated start"},
      {"residuals", guarded<residuals>, "data: pl.DataSet", "pl.Vector", "measured less predicted"},
      {"fit_free_run", guarded<fit_free_run>, "data: pl.DataSet, options?: {iterations?: integer, decay?: number}",
       "pl.NeuralStateSpace", "the same model trained on"},
      {"save", guarded<save>, "path: string", "string", "writes a model file, .yaml; gives the path"},
  };
}

std::vector<FieldInfo> neural_state_space_fields() { return infos_of(fields()); }

void open_neural_state_space(lua_State* L) {
  open_held<NeuralStateSpace>(L, neural_state_space_kind, neural_state_space_methods(), fields());
}

}  // namespace plantloop::lua
