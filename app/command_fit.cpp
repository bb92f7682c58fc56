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
  std::string file, data, out, solver;
  std::vector<std::string> set, parameters, bounds, signals, weights;
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
bool find_column(const FitOptions& o, const CsvTable& table, const std::string& name, std::size_t& column) {
  const int found = table.find(name);
  column = static_cast<std::size_t>(std::max(found, 0));
  if (found >= 0) return true;
  Report report;
  report.error({}, "the data {} have no column '{}'", o.data, name).suggest(name, table.names);
  print(report);
  return false;
}

// Columns "theta" or, where the file calls it otherwise, "theta=angle"; false after complaining.
bool choose_columns(const FitOptions& o, const CsvTable& table, FitRequest& request) {
  std::size_t time = 0, column = 0;
  if (!find_column(o, table, "time", time)) return false;
  std::vector<std::string> chosen = o.signals;
  for (std::size_t i = 0; chosen.empty() && i < table.names.size(); ++i) {
    if (i != time) request.data.columns.push_back({table.names[i], table.columns[i]});
  }
  for (const std::string& text : chosen) {
    const auto [signal, rest] = parts_of(text);
    if (!find_column(o, table, rest.empty() ? signal : rest, column)) return false;
    request.data.columns.push_back({signal, table.columns[column]});
  }
  request.data.time = table.columns[time];
  for (const std::string& text : o.weights) {
    const auto [signal, rest] = parts_of(text);
    const auto weight = parse_number(rest);
    const auto it = std::find_if(request.data.columns.begin(), request.data.columns.end(),
                                 [&signal = signal](const FitData::Column& c) { return c.signal == signal; });
    if (!weight || it == request.data.columns.end()) {
      complain(fmt::format("--weight {}: it must be signal=number with one of the fitted signals, as in --weight {}=10",
                           text, request.data.columns.empty() ? "y" : request.data.columns.front().signal));
      return false;
    }
    it->weight = *weight;
  }
  return true;
}

bool read_data(const FitOptions& o, FitRequest& request) {
  const FileResult file = read_file(o.data);
  if (!file.ok()) {
    complain(fmt::format("cannot read '{}': {}", o.data, file.error));
    return false;
  }
  CsvResult read = read_csv(file.value, MissingCells::as_nan);
  if (!read.ok()) {
    complain(read.line > 0 ? fmt::format("{}:{}:{}: {}", o.data, read.line, read.column, read.error)
                           : fmt::format("cannot read '{}': {}", o.data, read.error));
    return false;
  }
  if (read.table.columns.size() < 2) {
    complain(fmt::format("{}: data have a column of times and one or more of signals", o.data));
    return false;
  }
  return choose_columns(o, read.table, request);
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
  for (const FitResult::Column& c : r.columns) json["signals"][c.signal] = {{"rms", c.rms}, {"values", c.values}};
  return json.dump(2) + "\n";
}

std::string csv_of(const FitRequest& request, const FitResult& r) {
  std::string text = "time";
  for (const FitResult::Column& c : r.columns) text += fmt::format(",{0},{0} fitted", c.signal);
  text += "\n";
  for (std::size_t i = 0; i < request.data.time.size(); ++i) {
    text += digits17(request.data.time[i]);
    for (std::size_t c = 0; c < r.columns.size(); ++c)
      text += "," + digits17(request.data.columns[c].values[i]) + "," + digits17(r.columns[c].fitted[i]);
    text += "\n";
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
  if (!diagram || !read_data(o, request)) return input_wrong;
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
      .add_option("DATA", o->data, "a CSV file: a column time and one for each signal; empty cells are missing values")
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
  parser.add_option("--solver", o->solver, "as for run");
  parser.add_option("--rtol", o->rtol, "relative tolerance of the runs, 1e-10 where it is not given");
  parser.add_flag("--differences", o->differences, "derivatives by differences, to compare with the exact ones");
  parser.add_option("--out", o->out, "file for the estimates (.json) or for data and fitted signals (.csv)")
      ->type_name("FILE");
  parser.footer(
      "Exit status 1 when no minimum is reached.\n\n"
      "Examples:\n"
      "  plantloop fit pendulum.yaml swing.csv --parameter length --parameter damping --bound damping=0:1\n"
      "  plantloop fit tank.yaml log.csv --parameter k=0.4 --signal level=sensor_3 --weight level=50 --out fit.json");
  return [o] { return run_fit(*o); };
}
