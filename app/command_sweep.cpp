// plantloop sweep: many runs of a diagram with other parameters, summed up in a table with a row for each.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "app/command.h"
#include "app/progress.h"
#include "app/request.h"
#include "engine/analysis/sweep.h"
#include "engine/base/error.h"
#include "engine/base/files.h"
#include "engine/base/numbers.h"
#include "engine/run/measures.h"

namespace plantloop::app {

namespace {

struct SweepOptions {
  std::string file, out, solver;
  std::vector<std::string> set, grid, list, random, measures;
  std::size_t draws = 1, threads = 0;
  std::uint64_t seed = 1;
  double stop = NAN, rtol = NAN, atol = NAN;
  bool quiet = false;
};

struct Measure {
  std::string name, signal;  // "max", "x"
};

// "a=1,2,f(3, 4)" at commas outside of brackets.
std::vector<std::string> split(const std::string& text) {
  std::vector<std::string> parts(1);
  int depth = 0;
  for (const char c : text) {
    if (c == '(' || c == '[') ++depth;
    if (c == ')' || c == ']') --depth;
    if (c == ',' && depth == 0) {
      parts.emplace_back();
    } else if (c != ' ' || !parts.back().empty()) {
      parts.back() += c;
    }
  }
  return parts;
}

// "0:1:5" is five numbers from 0 to 1; else the text itself.
std::vector<std::string> expand(const std::string& text) {
  const std::size_t first = text.find(':'), second = text.find(':', first + 1);
  if (first == std::string::npos || second == std::string::npos) return {text};
  const auto from = parse_number(text.substr(0, first)), to = parse_number(text.substr(first + 1, second - first - 1));
  const auto count = parse_integer(text.substr(second + 1));
  if (!from || !to || !count || *count < 2 || *count > 1'000'000) return {text};
  std::vector<std::string> values;
  for (long i = 0; i < *count; ++i) {
    const double share = static_cast<double>(i) / static_cast<double>(*count - 1);
    values.push_back(shortest(i + 1 == *count ? *to : *from + (*to - *from) * share));
  }
  return values;
}

// "path=value,value,from:to:count"; false after complaining.
bool read_values(const std::vector<std::string>& texts, const char* option, std::vector<SweepPlan::Values>& into) {
  for (const std::string& text : texts) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos || equals == 0 || equals + 1 == text.size()) {
      complain(fmt::format("{0} {1}: it must be path=values, as in {0} k=1,2,5 or {0} k=0:1:11", option, text));
      return false;
    }
    SweepPlan::Values& values = into.emplace_back();
    values.path = text.substr(0, equals);
    for (const std::string& part : split(text.substr(equals + 1))) {
      for (std::string& value : expand(part)) values.texts.push_back(std::move(value));
    }
  }
  return true;
}

// "path=normal(1, 0.1)"; false after complaining.
bool read_random(const std::vector<std::string>& texts, std::vector<SweepPlan::Random>& into) {
  for (const std::string& text : texts) {
    const std::size_t equals = text.find('='), open = text.find('(');
    const std::size_t comma = text.find(',');
    if (equals != std::string::npos && equals > 0 && open != std::string::npos && comma != std::string::npos &&
        equals < open && open < comma && text.back() == ')') {
      const auto number = [&](std::size_t from, std::size_t to) {
        while (from < to && text[from] == ' ') ++from;
        return parse_number(text.substr(from, to - from));
      };
      const auto a = number(open + 1, comma), b = number(comma + 1, text.size() - 1);
      if (a && b) {
        into.push_back({text.substr(0, equals), text.substr(equals + 1, open - equals - 1), *a, *b});
        continue;
      }
    }
    std::vector<std::string> forms;
    for (const DistributionInfo& d : distributions()) forms.push_back(fmt::format("{}({})", d.name, d.arguments));
    complain(fmt::format("--random {}: it must be path=distribution, as in --random k=normal(1,0.1); there are: {}",
                         text, fmt::join(forms, ", ")));
    return false;
  }
  return true;
}

// "max:x"; false after complaining.
bool read_measures(const std::vector<std::string>& texts, std::vector<Measure>& into) {
  std::vector<std::string> names;
  for (const MeasureInfo& info : measures()) names.emplace_back(info.name);
  for (const std::string& text : texts) {
    const std::size_t colon = text.find(':');
    if (colon == std::string::npos || colon + 1 == text.size() ||
        std::find(names.begin(), names.end(), text.substr(0, colon)) == names.end()) {
      complain(fmt::format("--measure {}: it must be measure:signal, as in --measure max:x; measures are: {}", text,
                           fmt::join(names, ", ")));
      return false;
    }
    into.push_back({text.substr(0, colon), text.substr(colon + 1)});
  }
  return true;
}

// One row for each point: its parameters, then what was measured.
struct Table {
  std::vector<std::string> header;
  std::vector<std::vector<double>> rows;  // measured; NaN where a run failed
};

std::string cell(const std::string& text) {
  if (parse_number(text)) return digits17(*parse_number(text));
  return text.find_first_of(",\"\n") == std::string::npos ? text : "\"" + text + "\"";
}

std::string to_csv(const Table& table, const std::vector<SweepPoint>& points) {
  std::string text = "point";
  for (const Override& o : points.front().set) text += "," + o.path;
  for (const std::string& name : table.header) text += "," + name;
  text += "\n";
  for (std::size_t i = 0; i < points.size(); ++i) {
    text += std::to_string(i + 1);
    for (const Override& o : points[i].set) text += "," + cell(o.text);
    for (std::size_t j = 0; j < table.header.size(); ++j)
      text += "," + (j < table.rows[i].size() ? digits17(table.rows[i][j]) : std::string("nan"));
    text += "\n";
  }
  return text;
}

// What is measured of a run, by the table's columns.
std::vector<double> measured(const DiagramRun& run, const std::vector<Measure>& wanted) {
  std::vector<double> values;
  for (const Measure& m : wanted) {
    const int column = run.recording.find(m.signal);  // a parameter may have changed what there is
    values.push_back(column < 0 ? NAN : measure(run.recording, static_cast<std::size_t>(column), m.name));
  }
  bool met = true;
  for (const Verdict& v : run.verdicts) met = met && v.met;
  if (!run.verdicts.empty()) values.push_back(met ? 1 : 0);
  return values;
}

// Without --measure the last value of every recorded signal; false after complaining.
bool choose_measures(Diagram& diagram, const SweepRequest& request, std::vector<Measure>& wanted, Table& table) {
  Report report;
  std::optional<PreparedRun> first;
  for (std::size_t i = 0; i < request.points.size() && !first; ++i) {  // the first that can run tells the columns
    RunRequest run = request.run;
    run.set.insert(run.set.end(), request.points[i].begin(), request.points[i].end());
    Report of_point;
    first = diagram.prepare(run, of_point);
    if (!first && i == 0) report = std::move(of_point);
  }
  if (!first) {
    print(report);
    return false;
  }
  std::vector<std::string> columns;
  for (const RecordedColumn& column : first->columns) columns.push_back(column.name);
  const bool by_default = wanted.empty();
  for (const RecordedColumn& column : first->columns) {
    if (by_default && !column.hidden) wanted.push_back({"final", column.name});
  }
  for (const Measure& m : wanted) {
    if (std::find(columns.begin(), columns.end(), m.signal) == columns.end()) {
      Report missing;
      missing.error({}, "--measure {}:{}: '{}' is not recorded", m.name, m.signal, m.signal).suggest(m.signal, columns);
      print(missing);
      return false;
    }
    table.header.push_back(by_default ? m.signal : fmt::format("{}({})", m.name, m.signal));
  }
  if (!diagram.model().expect.empty()) table.header.emplace_back("met");
  return true;
}

int run_sweep(const SweepOptions& o) {
  SweepPlan plan;
  SweepRequest request;
  std::vector<Measure> wanted;
  if (!read_overrides(o.set, request.run.set) || !read_values(o.grid, "--grid", plan.grid) ||
      !read_values(o.list, "--list", plan.list) || !read_random(o.random, plan.random) ||
      !read_measures(o.measures, wanted))
    return input_wrong;
  if (!o.out.empty() && extension_of(o.out) != ".csv") {
    complain(fmt::format("--out {}: the name must end in .csv", o.out));
    return input_wrong;
  }
  if (!o.out.empty()) {
    if (const std::string why = why_not_writable(o.out); !why.empty()) {
      complain(fmt::format("--out {}: it cannot be written: {}", o.out, why));
      return input_wrong;
    }
  }
  plan.draws = o.draws;
  plan.seed = o.seed;
  const auto given = [](double value) { return std::isnan(value) ? std::nullopt : std::optional(value); };
  request.run.stop = given(o.stop);
  request.run.rtol = given(o.rtol);
  request.run.atol = given(o.atol);
  if (!o.solver.empty()) request.run.solver = o.solver;
  request.threads = o.threads;

  Report report;
  const auto diagram = load_diagram(o.file, report);
  if (!diagram) return input_wrong;
  const auto points = sweep_points(plan, report);
  if (!points) {
    print(report);
    return input_wrong;
  }
  request.points = *points;
  Table table;
  if (!choose_measures(*diagram, request, wanted, table)) return input_wrong;
  table.rows.resize(points->size());
  request.finished = [&](std::size_t i, SweepPoint& point) {
    if (!point.run) return;
    table.rows[i] = measured(*point.run, wanted);
    point.run.reset();
  };
  Progress progress(!o.quiet);
  SweepControl control;
  control.cancel = &interrupted;
  control.progress = [&](std::size_t done, std::size_t all) {
    progress(static_cast<double>(done) / static_cast<double>(all));
  };
  std::optional<std::vector<SweepPoint>> result;
  try {
    result = sweep(*diagram, request, report, control);
  } catch (const RunError& e) {
    progress.clear();
    complain(e.what());
    return run_failed;
  }
  progress.clear();
  print(report);
  if (!result) return input_wrong;
  std::size_t failures = 0;
  for (std::size_t i = 0; i < result->size(); ++i) {
    const SweepPoint& point = (*result)[i];
    if (point.failure.empty()) continue;
    ++failures;
    std::vector<std::string> where;
    for (const Override& p : point.set) where.push_back(p.path + " = " + p.text);
    constexpr std::size_t most_told = 20;
    if (failures <= most_told)
      complain(fmt::format("point {} ({}) failed: {}", i + 1, fmt::join(where, ", "), point.failure));
  }
  if (failures > 0) complain(fmt::format("{} of {} points failed", failures, result->size()));
  const std::string csv = to_csv(table, *result);
  const bool written = o.out.empty() ? write_out(csv) : write_result(o.out, csv);
  return written && failures == 0 ? done : run_failed;
}

}  // namespace

}  // namespace plantloop::app

PLANTLOOP_COMMAND(sweep) {
  using namespace plantloop::app;
  const auto o = std::make_shared<SweepOptions>();
  parser.description(
      "Run a diagram for many parameters, on threads, and write a table with a row for each: its parameters and what "
      "was measured. The result does not depend on the number of threads.");
  parser.add_option("DIAGRAM", o->file, "the diagram")->required();
  const auto many = [&](const char* name, std::vector<std::string>& into, const char* help, const char* type) {
    parser.add_option(name, into, help)->allow_extra_args(false)->type_name(type);
  };
  many("--grid", o->grid, "values of a parameter; several grids are combined, the last one changing fastest",
       "PATH=VALUES");
  many("--list", o->list, "values of a parameter that go side by side with those of the other lists", "PATH=VALUES");
  many("--random", o->random,
       "a random parameter: uniform(lower,upper), log_uniform(lower,upper), normal(mean,deviation)",
       "PATH=DISTRIBUTION");
  parser.add_option("--draws", o->draws, "how many times the random parameters are drawn")->capture_default_str();
  parser.add_option("--seed", o->seed, "of the draws")->capture_default_str();
  many("--measure", o->measures,
       "what a row tells of a signal; without it the last value of each recorded signal. With `expect:` a column says "
       "whether all was met",
       "MEASURE:SIGNAL");
  add_set_option(parser, o->set);
  parser.add_option("--stop", o->stop, "stop time in s");
  parser.add_option("--solver", o->solver, "as for run");
  parser.add_option("--rtol", o->rtol, "relative tolerance");
  parser.add_option("--atol", o->atol, "absolute tolerance");
  parser.add_option("--threads", o->threads, "at most so many at once; 0: LP_NUM_THREADS, or all processors")
      ->capture_default_str();
  parser.add_option("--out", o->out, "file for the table, .csv; else standard output")->type_name("FILE");
  parser.add_flag("--quiet", o->quiet, "no progress");
  parser.footer(
      "VALUES are expressions separated by commas, or from:to:count. A run that fails is told and leaves an empty row "
      "(nan); the exit status is 1 then.\n\n"
      "Examples:\n"
      "  plantloop sweep loop.yaml --grid controller.K1=10:60:11 --measure max:y\n"
      "  plantloop sweep loop.yaml --random 'plant.T=normal(1,0.1)' --draws 200 --seed 7 --out monte_carlo.csv");
  return [o] { return run_sweep(*o); };
}
