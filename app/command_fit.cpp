// plantloop fit: parameters of a diagram fitted to measured signals.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "app/command.h"
#include "app/request.h"
#include "engine/analysis/fit.h"
#include "engine/base/csv.h"
#include "engine/base/error.h"
#include "engine/base/files.h"
#include "engine/base/numbers.h"

namespace plantloop::app {

namespace {

struct FitOptions {
  std::string file, out, solver;
  std::vector<std::string> data, set, set_in, parameters, bounds, signals, weights;
  std::size_t starts = 1, threads = 0;
  std::uint64_t seed = 1;
  double confidence = 95, rtol = NAN;
  bool absolute = false, differences = false;
};

// "name=rest" apart; `rest` is empty without "=".
std::pair<std::string, std::string> parts_of(const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos) return {text, {}};
  return {text.substr(0, equals), text.substr(equals + 1)};
}

// "k" or "k=0.5"; false after complaining.
bool read_parameters(const FitOptions& o, FitRequest& request) {
  for (const std::string& text : o.parameters) {
    const auto [path, rest] = parts_of(text);
    const auto start = parse_number(rest);
    if (path.empty() || (text.find('=') != std::string::npos && !start)) {
      complain(fmt::format("--parameter {}: it must be path or path=start, as in --parameter tau=0.5", text));
      return false;
    }
    request.parameters.push_back({path, start});
  }
  for (const std::string& text : o.bounds) {
    const auto [path, rest] = parts_of(text);
    const std::size_t colon = rest.find(':');
    const auto lower = parse_number(rest.substr(0, colon));
    const auto upper = colon == std::string::npos ? std::nullopt : parse_number(rest.substr(colon + 1));
    if (!lower || !upper) {
      complain(fmt::format("--bound {}: it must be path=lower:upper, as in --bound tau=0:10", text));
      return false;
    }
    const auto it = std::find_if(request.parameters.begin(), request.parameters.end(),
                                 [&path = path](const FitParameter& p) { return p.path == path; });
    if (it == request.parameters.end()) {
      complain(fmt::format("--bound {}: '{}' is not among the fitted parameters", text, path));
      return false;
    }
    it->lower = *lower;
    it->upper = *upper;
  }
  return true;
}

// False after complaining.
bool find_column(const std::string& file, const CsvTable& table, const std::string& name, std::size_t& column) {
  const int found = table.find(name);
  column = static_cast<std::size_t>(std::max(found, 0));
  if (found >= 0) return true;
  Report report;
  report.error({}, "the data {} have no column '{}'", file, name).suggest(name, table.names);
  print(report);
  return false;
}

// Columns "theta" or, where the file calls it otherwise, "theta=angle"; false after complaining.
bool choose_columns(const FitOptions& o, const std::string& file, const CsvTable& table, FitData& data) {
  std::size_t time = 0, column = 0;
  if (!find_column(file, table, "time", time)) return false;
  std::vector<std::string> chosen = o.signals;
  for (std::size_t i = 0; chosen.empty() && i < table.names.size(); ++i) {
    if (i != time) data.columns.push_back({table.names[i], table.columns[i]});
  }
  for (const std::string& text : chosen) {
    const auto [signal, rest] = parts_of(text);
    if (!find_column(file, table, rest.empty() ? signal : rest, column)) return false;
    data.columns.push_back({signal, table.columns[column]});
  }
  data.time = table.columns[time];
  for (const std::string& text : o.weights) {
    const auto [signal, rest] = parts_of(text);
    const auto weight = parse_number(rest);
    const auto it = std::find_if(data.columns.begin(), data.columns.end(),
                                 [&signal = signal](const FitData::Column& c) { return c.signal == signal; });
    if (!weight || it == data.columns.end()) {
      complain(fmt::format("--weight {}: it must be signal=number with one of the fitted signals, as in --weight {}=10",
                           text, data.columns.empty() ? "y" : data.columns.front().signal));
      return false;
    }
    it->weight = *weight;
  }
  return true;
}

bool read_data(const FitOptions& o, const std::string& name, FitData& data) {
  const FileResult file = read_file(name);
  if (!file.ok()) {
    complain(fmt::format("cannot read '{}': {}", name, file.error));
    return false;
  }
  CsvResult read = read_csv(file.value, MissingCells::as_nan);
  if (!read.ok()) {
    complain(read.line > 0 ? fmt::format("{}:{}:{}: {}", name, read.line, read.column, read.error)
                           : fmt::format("cannot read '{}': {}", name, read.error));
    return false;
  }
  if (read.table.columns.size() < 2) {
    complain(fmt::format("{}: data have a column of times and one or more of signals", name));
    return false;
  }
  return choose_columns(o, name, read.table, data);
}

// One experiment for each file; "2:theta.initial=0.3" is set in that of the second file. False after complaining.
bool read_experiments(const FitOptions& o, FitRequest& request) {
  request.experiments.clear();
  for (const std::string& name : o.data) {
    if (!read_data(o, name, request.experiments.emplace_back().data)) return false;
  }
  for (const std::string& text : o.set_in) {
    const std::size_t colon = text.find(':');
    const auto number = parse_number(text.substr(0, colon));
    const auto count = static_cast<double>(o.data.size());
    if (colon == std::string::npos || !number || !(*number >= 1 && *number <= count) ||
        *number != std::floor(*number)) {
      complain(fmt::format("--set-in {}: it must be N:path=expression, where N is the number of a data file, 1 to {}",
                           text, o.data.size()));
      return false;
    }
    if (!read_overrides({text.substr(colon + 1)}, request.experiments[static_cast<std::size_t>(*number) - 1].set))
      return false;
  }
  return true;
}

nlohmann::json rows_of(const DenseMatrix& m) {
  nlohmann::json rows = nlohmann::json::array();
  for (std::size_t i = 0; i < m.rows; ++i) {
    nlohmann::json row = nlohmann::json::array();
    for (std::size_t j = 0; j < m.columns; ++j) row.push_back(m(i, j));
    rows.push_back(row);
  }
  return rows;
}

std::string json_of(const FitResult& r) {
  nlohmann::ordered_json json;
  json["converged"] = r.converged;
  json["why"] = r.why;
  json["derivatives"] = r.gradient;
  json["cost"] = r.cost;
  json["values"] = r.values;
  json["degrees_of_freedom"] = r.degrees;
  for (const FitResult::Estimate& e : r.parameters) {
    json["parameters"][e.path] = {{"value", e.value},
                                  {"start", e.start},
                                  {"deviation", e.deviation},
                                  {"interval", {e.lower, e.upper}},
                                  {"on_bound", e.on_bound}};
  }
  json["covariance"] = rows_of(r.covariance);
  json["correlation"] = rows_of(r.correlation);
  for (const FitResult::Column& c : r.columns) {
    auto& of = r.experiments > 1 ? json["experiments"][c.experiment]["signals"] : json["signals"];
    of[c.signal] = {{"rms", c.rms}, {"values", c.values}};
  }
  return json.dump(2) + "\n";
}

// The columns of the first experiment; with several the first column is the number of each.
std::string csv_of(const FitRequest& request, const FitResult& r) {
  const bool several = r.experiments > 1;
  std::string text = several ? "experiment,time" : "time";
  for (const FitResult::Column& c : r.columns)
    if (c.experiment == 0) text += fmt::format(",{0},{0} fitted", c.signal);
  text += "\n";
  std::size_t first = 0;  // column of the experiment
  for (std::size_t e = 0; e < r.experiments; ++e) {
    const FitData& data = request.experiments[e].data;
    for (std::size_t i = 0; i < data.time.size(); ++i) {
      if (several) text += fmt::format("{},", e + 1);
      text += digits17(data.time[i]);
      for (std::size_t c = 0; c < data.columns.size(); ++c)
        text += "," + digits17(data.columns[c].values[i]) + "," + digits17(r.columns[first + c].fitted[i]);
      text += "\n";
    }
    first += data.columns.size();
  }
  return text;
}

int run_fit(const FitOptions& o) {
  FitRequest request;
  if (!read_overrides(o.set, request.run.set) || !read_parameters(o, request)) return input_wrong;
  const std::string extension = extension_of(o.out);
  if (!o.out.empty() && extension != ".csv" && extension != ".json") {
    complain(fmt::format("--out {}: the name must end in .json (estimates) or .csv (data and fitted signals)", o.out));
    return input_wrong;
  }
  if (!(o.confidence > 0 && o.confidence < 100)) {
    complain(fmt::format("--confidence {:g}: it must lie between 0 and 100 %", o.confidence));
    return input_wrong;
  }
  Report report;
  const auto diagram = load_diagram(o.file, report);
  if (!diagram || !read_experiments(o, request)) return input_wrong;
  request.confidence = o.confidence / 100;
  request.starts = std::max<std::size_t>(o.starts, 1);
  request.seed = o.seed;
  request.threads = o.threads;
  request.absolute = o.absolute;
  request.differences = o.differences;
  if (!o.solver.empty()) request.run.solver = o.solver;
  if (!std::isnan(o.rtol)) request.run.rtol = o.rtol;
  std::optional<FitResult> result;
  try {
    result = fit(diagram->model_pointer(), request, report, {.cancel = &interrupted});
  } catch (const RunError& e) {
    print(report);
    complain(e.what());
    return run_failed;
  }
  print(report);
  if (!result) return input_wrong;
  if (!write_out(to_text(*result, request.confidence))) return run_failed;
  if (!o.out.empty() && !write_result(o.out, extension == ".json" ? json_of(*result) : csv_of(request, *result)))
    return run_failed;
  return result->converged ? done : run_failed;
}

}  // namespace

}  // namespace plantloop::app

PLANTLOOP_COMMAND(fit) {
  using namespace plantloop::app;
  const auto o = std::make_shared<FitOptions>();
  parser.description(
      "Fit parameters of a diagram to measured signals by least squares, with exact derivatives; tells the estimates, "
      "their confidence intervals and correlations.");
  parser.add_option("DIAGRAM", o->file, "the diagram")->required();
  parser
      .add_option("DATA", o->data,
                  "CSV files, one for each experiment: a column time and one for each signal; empty cells are missing "
                  "values")
      ->required();
  const auto many = [&](const char* name, std::vector<std::string>& into, const char* help, const char* type) {
    return parser.add_option(name, into, help)->allow_extra_args(false)->type_name(type);
  };
  many("--parameter", o->parameters,
       "a number to be fitted, with a start value that is not the diagram's: a parameter, an element, an initial value",
       "PATH[=START]")
      ->required();
  many("--bound", o->bounds, "bounds of a parameter", "PATH=LOWER:UPPER");
  many("--signal", o->signals, "a signal and the column that measures it; without, every column has a signal's name",
       "SIGNAL[=COLUMN]");
  many("--weight", o->weights, "how much a signal counts: 1/standard deviation of its noise; 1 where it is not given",
       "SIGNAL=NUMBER");
  parser.add_flag("--absolute", o->absolute,
                  "the weights are those of the true noise; else the residuals tell how strong it is");
  parser.add_option("--confidence", o->confidence, "of the intervals, in %")->capture_default_str();
  parser.add_option("--starts", o->starts, "begin so many times, at points drawn within the bounds")
      ->capture_default_str();
  parser.add_option("--seed", o->seed, "of the draws")->capture_default_str();
  parser.add_option("--threads", o->threads, "at most so many starts at once; 0: LP_NUM_THREADS, or all processors")
      ->capture_default_str();
  add_set_option(parser, o->set);
  many("--set-in", o->set_in, "as --set, in the experiment of the data file of that number alone, from 1",
       "N:PATH=EXPRESSION");
  parser.add_option("--solver", o->solver, "as for run");
  parser.add_option("--rtol", o->rtol, "relative tolerance of the runs, 1e-10 where it is not given");
  parser.add_flag("--differences", o->differences, "derivatives by differences, to compare with the exact ones");
  parser.add_option("--out", o->out, "file for the estimates (.json) or for data and fitted signals (.csv)")
      ->type_name("FILE");
  parser.footer(
      "Exit status 1 when no minimum is reached.\n\n"
      "Examples:\n"
      "  plantloop fit pendulum.yaml swing.csv --parameter length --parameter damping --bound damping=0:1\n"
      "  plantloop fit tank.yaml log.csv --parameter k=0.4 --signal level=sensor_3 --weight level=50 --out fit.json\n"
      "  plantloop fit pendulum.yaml small.csv large.csv --parameter damping --set-in 1:theta.initial=0.1 --set-in "
      "2:theta.initial=1.5");
  return [o] { return run_fit(*o); };
}
