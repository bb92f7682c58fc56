// pl.identify: data sets and signals that excite.

#include <fmt/format.h>

#include <algorithm>

#include "identify/data/advice.h"
#include "identify/data/data_csv.h"
#include "identify/data/excitation.h"
#include "identify/data/preprocess.h"
#include "identify/validation/folds.h"
#include "scripts/host/identify_objects.h"

namespace plantloop::lua {
namespace {

using Eigen::Index;
using identify::Channel;
using identify::DataSet;

std::vector<Channel> channels(lua_State* L, const Options& options, const char* key) {
  std::vector<Channel> list;
  for (const std::string& header : texts(L, options, key)) list.push_back(identify::channel_of(header));
  return list;
}

int data(lua_State* L) {
  const Options options(L, 1, "the options of data", {"u", "y", "Ts", "inputs", "outputs"});
  const auto matrix = [&](const char* key) {
    Eigen::MatrixXd m;
    if (options.push(key)) {
      m = matrix_of(L, -1, key);
      lua_pop(L, 1);
    }
    return m;
  };
  if (!options.has("y")) throw ScriptError("the data need 'y', a vector, or a matrix with a column for each output");
  if (!options.has("Ts")) throw ScriptError("the data need 'Ts', the sampling time in s");
  Eigen::MatrixXd u = matrix("u");
  Eigen::MatrixXd y = matrix("y");
  if (u.size() == 0) u.resize(y.rows(), 0);
  push_data(L, identify::make_data_set(std::move(u), std::move(y), *options.number("Ts"),
                                       channels(L, options, "inputs"), channels(L, options, "outputs")));
  return 1;
}

int read(lua_State* L) {
  const std::string path = text_argument(L, 1, "path");
  const Options options(L, 2, "the options of read", {"inputs", "outputs", "Ts"});
  const std::string text = read_text(L, path);
  push_data(L, identify::read_data_csv(
                   text, path, {texts(L, options, "inputs"), texts(L, options, "outputs"), options.number("Ts")}));
  return 1;
}

int join(lua_State* L) {
  DataSet all = data_argument(L, 1);
  for (int i = 2; i <= lua_gettop(L); ++i) all = identify::join(all, data_argument(L, i));
  push_data(L, std::move(all));
  return 1;
}

Index samples_of(const Options& options) {
  const int samples = integer(options, "samples", 0);
  if (samples < 1) throw ScriptError("'samples' must be 1 or more");
  return samples;
}

int prbs(lua_State* L) {
  const Options o(L, 1, "the options of prbs", {"bits", "hold", "amplitude", "samples"});
  push_numbers(L, identify::prbs(integer(o, "bits", 7), integer(o, "hold", 1), o.number("amplitude").value_or(1),
                                 integer(o, "samples", 0)));
  return 1;
}

int staircase(lua_State* L) {
  const Options o(L, 1, "the options of staircase", {"samples", "hold", "lower", "upper", "seed"});
  std::vector<int> hold = integers(L, o, "hold");
  if (hold.empty()) hold = {1};
  if (hold.size() > 2) throw ScriptError("'hold' is one number of samples, or the least and the greatest");
  push_numbers(L,
               identify::staircase(samples_of(o), hold.front(), hold.back(), o.number("lower").value_or(-1),
                                   o.number("upper").value_or(1), static_cast<std::uint64_t>(integer(o, "seed", 1))));
  return 1;
}

int white_noise(lua_State* L) {
  const Options o(L, 1, "the options of white_noise", {"samples", "deviation", "seed", "portable"});
  const double deviation = o.number("deviation").value_or(1);
  const int seed = integer(o, "seed", 1);
  push_numbers(L,
               o.flag("portable")
                   ? identify::portable_noise(samples_of(o), deviation, static_cast<std::uint32_t>(std::max(0, seed)))
                   : identify::white_noise(samples_of(o), deviation, static_cast<std::uint64_t>(seed)));
  return 1;
}

int multisine(lua_State* L) {
  const Options o(L, 1, "the options of multisine", {"samples", "period", "first", "last", "amplitude"});
  const Index samples = samples_of(o);
  const int period = integer(o, "period", static_cast<int>(samples));
  push_numbers(L, identify::multisine(samples, period, integer(o, "first", 1), integer(o, "last", period / 4),
                                      o.number("amplitude").value_or(1)));
  return 1;
}

int chirp(lua_State* L) {
  const Options o(L, 1, "the options of chirp", {"samples", "Ts", "from", "to", "amplitude"});
  if (!o.has("Ts") || !o.has("to")) throw ScriptError("a chirp needs 'Ts' in s, and 'to' in rad/s");
  push_numbers(L, identify::chirp(samples_of(o), *o.number("Ts"), o.number("from").value_or(0), *o.number("to"),
                                  o.number("amplitude").value_or(1)));
  return 1;
}

int square_wave(lua_State* L) {
  const Options o(L, 1, "the options of square_wave", {"samples", "half", "amplitude"});
  push_numbers(L, identify::square_wave(samples_of(o), integer(o, "half", 1), o.number("amplitude").value_or(1)));
  return 1;
}

const DataSet& self(lua_State* L) { return held_self<DataSet>(L, data_kind); }

int split(lua_State* L) {
  const auto [first, second] = identify::split(self(L), number_argument(L, 2, "fraction"));
  push_data(L, first);
  push_data(L, second);
  return 2;
}

int folds(lua_State* L) {
  const std::int64_t count = is_given(L, 2) ? integer_argument(L, 2, "count", 2, 1000) : 5;
  lua_newtable(L);
  lua_Integer at = 0;
  for (auto& [train, test] : identify::data_folds(self(L), static_cast<int>(count))) {
    lua_createtable(L, 0, 2);
    push_data(L, std::move(train));
    lua_setfield(L, -2, "train");
    push_data(L, std::move(test));
    lua_setfield(L, -2, "test");
    lua_rawseti(L, -2, ++at);
  }
  return 1;
}

// From 1 and both ends included, as Lua counts.
int part(lua_State* L) {
  constexpr std::int64_t most = std::int64_t{1} << 40;
  const std::int64_t from = integer_argument(L, 2, "first", 1, most);
  const std::int64_t until = is_given(L, 3) ? integer_argument(L, 3, "last", from, most) : most;
  push_data(L, identify::part(self(L), from - 1, until));
  return 1;
}

int experiment(lua_State* L) {
  const auto count = static_cast<std::int64_t>(self(L).experiments.size());
  push_data(L, identify::choose(self(L), {static_cast<std::size_t>(integer_argument(L, 2, "number", 1, count) - 1)}));
  return 1;
}

int detrend(lua_State* L) {
  const std::string kind = is_given(L, 2) ? text_argument(L, 2, "kind") : "mean";
  if (kind != "mean" && kind != "line") throw ScriptError(fmt::format("a trend is a mean or a line, not '{}'", kind));
  const auto trends =
      identify::fit_trends(self(L), kind == "mean" ? identify::TrendKind::mean : identify::TrendKind::line);
  push_data(L, identify::remove(self(L), trends));
  return 1;
}

int resample(lua_State* L) {
  push_data(L, identify::resample(self(L), static_cast<int>(integer_argument(L, 2, "up", 1, 1000)),
                                  static_cast<int>(integer_argument(L, 3, "down", 1, 1000))));
  return 1;
}

int filter(lua_State* L) {
  push_data(L, identify::filter(self(L), vector_of(L, 2, "B"), vector_of(L, 3, "A")));
  return 1;
}

int fill(lua_State* L) {
  const std::string kind = is_given(L, 2) ? text_argument(L, 2, "kind") : "line";
  if (kind != "line" && kind != "hold")
    throw ScriptError(fmt::format("a gap is filled by a line or hold, not '{}'", kind));
  const std::int64_t longest = is_given(L, 3) ? integer_argument(L, 3, "longest", 0, 1'000'000'000) : 0;
  push_data(L, identify::fill_missing(self(L), kind == "line" ? identify::Fill::line : identify::Fill::hold, longest));
  return 1;
}

// The scale of `of`, or of the data themselves.
int normalise(lua_State* L) {
  push_data(L, identify::fit_normalisation(is_given(L, 2) ? data_argument(L, 2) : self(L)).apply(self(L)));
  return 1;
}

int save(lua_State* L) {
  write_and_push(L, text_argument(L, 2, "path"), identify::to_csv(self(L)), {".csv"});
  return 1;
}

int advice(lua_State* L) {
  push_texts(L, identify::advice(self(L)));
  return 1;
}

int column(lua_State* L) {
  const DataSet& d = self(L);
  const std::string name = text_argument(L, 2, "name");
  std::vector<std::string> names;
  for (const bool output : {true, false}) {
    const auto& list = output ? d.outputs : d.inputs;
    for (std::size_t i = 0; i < list.size(); ++i) {
      names.push_back(list[i].name);
      if (list[i].name != name) continue;
      push_numbers(L, (output ? d.all_y() : d.all_u()).col(static_cast<Index>(i)));
      return 1;
    }
  }
  throw ScriptError(fmt::format("the data have no signal '{}'{}", name, suggestion(name, names)));
}

void push_time(lua_State* L, const DataSet& d) {
  Eigen::VectorXd time(d.samples());
  Index at = 0;
  for (const identify::Experiment& e : d.experiments) {
    for (Index k = 0; k < e.samples(); ++k) time[at++] = e.start + static_cast<double>(k) * d.Ts;
  }
  push_numbers(L, time);
}

std::vector<std::string> names_of(const std::vector<Channel>& list) {
  std::vector<std::string> names;
  for (const Channel& c : list) names.push_back(c.name);
  return names;
}

const std::vector<Field<DataSet>>& fields() {
  static const std::vector<Field<DataSet>> list{
      {"u", "pl.Vector", "the inputs, one column each, experiments below each other",
       [](lua_State* L, const DataSet& d) { push_columns(L, d.all_u()); }},
      {"y", "pl.Vector", "the outputs, one column each",
       [](lua_State* L, const DataSet& d) { push_columns(L, d.all_y()); }},
      {"time", "pl.Vector", "s, of each sample", push_time},
      {"Ts", "number", "s, the sampling time", [](lua_State* L, const DataSet& d) { lua_pushnumber(L, d.Ts); }},
      {"samples", "integer", "of all experiments",
       [](lua_State* L, const DataSet& d) { lua_pushinteger(L, d.samples()); }},
      {"missing", "integer", "values that are missing",
       [](lua_State* L, const DataSet& d) { lua_pushinteger(L, d.missing()); }},
      {"experiments", "integer", "how many",
       [](lua_State* L, const DataSet& d) { lua_pushinteger(L, static_cast<lua_Integer>(d.experiments.size())); }},
      {"inputs", "string[]", "the names of the inputs",
       [](lua_State* L, const DataSet& d) { push_texts(L, names_of(d.inputs)); }},
      {"outputs", "string[]", "the names of the outputs",
       [](lua_State* L, const DataSet& d) { push_texts(L, names_of(d.outputs)); }},
      {"hash", "string", "changes with any bit of the data",
       [](lua_State* L, const DataSet& d) { push_text(L, identify::hash(d)); }},
  };
  return list;
}

}  // namespace

Entries identify_data_functions() {
  return {
      {"data", guarded<data>,
       "options: {u?: pl.Vector, y: pl.Vector, Ts: number, inputs?: string[], outputs?: string[]}", "pl.DataSet",
       "measured signals: vectors, or matrices with a column for each signal; names as \"flow [l/s]\""},
      {"read", guarded<read>, "path: string, options?: {inputs?: string[], outputs?: string[], Ts?: number}",
       "pl.DataSet",
       "a CSV file: time, columns u... and y..., or those that are named; empty cells are missing values"},
      {"join", guarded<join>, "...: pl.DataSet", "pl.DataSet", "the experiments of all"},
      {"prbs", guarded<prbs>, "options?: {bits?: integer, hold?: integer, amplitude?: number, samples?: integer}",
       "pl.Vector", "a pseudo-random binary sequence; one period unless told"},
      {"staircase", guarded<staircase>,
       "options: {samples: integer, hold?: integer|integer[], lower?: number, upper?: number, seed?: integer}",
       "pl.Vector", "random levels, each held for a number of samples, or a random one of {least, most}"},
      {"white_noise", guarded<white_noise>,
       "options: {samples: integer, deviation?: number, seed?: integer, portable?: boolean}", "pl.Vector",
       "normal white noise; portable: by the generator of Park and Miller"},
      {"multisine", guarded<multisine>,
       "options: {samples: integer, period?: integer, first?: integer, last?: integer, amplitude?: number}",
       "pl.Vector", "the harmonics first ... last of the period with equal amplitudes and a low crest"},
      {"chirp", guarded<chirp>,
       "options: {samples: integer, Ts: number, from?: number, to: number, amplitude?: number}", "pl.Vector",
       "a sine whose frequency grows from `from` to `to`, rad/s"},
      {"square_wave", guarded<square_wave>, "options: {samples: integer, half?: integer, amplitude?: number}",
       "pl.Vector", "plus and minus in turn, each for `half` samples"},
  };
}

Entries data_methods() {
  return {
      {"split", guarded<split>, "fraction: number", "pl.DataSet, pl.DataSet",
       "the first part of each experiment, and the rest"},
      {"folds", guarded<folds>, "count?: integer", "{train: pl.DataSet, test: pl.DataSet}[]",
       "contiguous folds for cross-validation; 5 unless told"},
      {"part", guarded<part>, "first: integer, last?: integer", "pl.DataSet",
       "samples first ... last of each experiment; what lies beyond its end is left out"},
      {"experiment", guarded<experiment>, "number: integer", "pl.DataSet", "one of the experiments"},
      {"detrend", guarded<detrend>, "kind?: \"mean\"|\"line\"", "pl.DataSet",
       "without the means of all data, or without a straight line in each experiment"},
      {"normalise", guarded<normalise>, "of?: pl.DataSet", "pl.DataSet",
       "mean 0 and standard deviation 1 of these data, or the same scale as `of` would get"},
      {"filter", guarded<filter>, "B: pl.Vector, A: pl.Vector", "pl.DataSet",
       "every signal filtered by B/A, coefficients from delay 0 on"},
      {"resample", guarded<resample>, "up: integer, down: integer", "pl.DataSet",
       "the sampling time times down/up, low-passed without phase"},
      {"fill", guarded<fill>, "kind?: \"line\"|\"hold\", longest?: integer", "pl.DataSet",
       "missing values inside gaps of at most `longest` samples filled"},
      {"column", guarded<column>, "name: string", "pl.Vector", "a signal by its name"},
      {"advice", guarded<advice>, "", "string[]", "what a careful engineer says about these data"},
      {"save", guarded<save>, "path: string", "string", "writes a CSV file; gives the path"},
  };
}

std::vector<FieldInfo> data_fields() { return infos_of(fields()); }

void open_data(lua_State* L) { open_held<DataSet>(L, data_kind, data_methods(), fields()); }

}  // namespace plantloop::lua
