// `simulation:`, `record:` and `checks:`.

#include <algorithm>
#include <unordered_map>

#include "engine/base/text.h"
#include "engine/diagram/read.h"
#include "engine/diagram/section.h"

namespace plantloop {
namespace {

// A column's name stands in a CSV header and in Lua without quotes: names and element numbers with dots between.
bool is_column_name(std::string_view text) {
  if (text.empty() || !is_letter(text[0])) return false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool point = text[i] == '.' && i + 1 < text.size() && text[i - 1] != '.';
    if (!is_letter(text[i]) && !is_digit(text[i]) && !point) return false;
  }
  return true;
}

class Columns {
 public:
  explicit Columns(Report& report) : report_(report) {}

  void add(std::string column, const Mark& mark, ExpressionPtr signal) {
    if (!signal) return;
    if (column == "time") {
      report_.error(mark, "the column 'time' is always there").named("name");
      return;
    }
    const auto [first, is_new] = marks_.try_emplace(column, mark);
    if (!is_new) {
      report_.error(mark, "the column '{}' is recorded twice", column)
          .also(first->second, "first recorded here")
          .named("duplicate-name");
      return;
    }
    list.push_back({std::move(column), mark, std::move(signal)});
  }

  std::vector<RecordDecl> list;

 private:
  Report& report_;
  std::unordered_map<std::string, Mark> marks_;
};

}  // namespace

SimulationDecl read_simulation(const Node& node, const Mark& mark, Report& report) {
  SimulationDecl simulation;
  simulation.mark = mark;
  const Section section(node, "simulation",
                        {"start", "stop", "solver", "step", "rtol", "atol", "max_step", "output_interval", "event_tol",
                         "max_steps", "max_rows", "zeno", "loops", "seed", "strict"},
                        report);
  section.require("stop", mark, "simulation: {stop: 10}");
  simulation.start = section.expression("start");
  simulation.stop = section.expression("stop");
  simulation.step = section.expression("step");
  simulation.rtol = section.expression("rtol");
  simulation.atol = section.expression("atol");
  simulation.max_step = section.expression("max_step");
  simulation.output_interval = section.expression("output_interval");
  simulation.event_tol = section.expression("event_tol");
  simulation.max_steps = section.expression("max_steps");
  simulation.max_rows = section.expression("max_rows");
  simulation.seed = section.expression("seed");
  simulation.solver = section.text("solver", "dopri5");
  simulation.solver_mark = section.find("solver") ? section.find("solver")->mark : mark;
  simulation.zeno = section.choice("zeno", {"error", "hold", "ignore"}, "error");
  simulation.loops = section.choice("loops", {"error", "solve"}, "solve");
  simulation.strict = section.boolean("strict", false);
  return simulation;
}

namespace {

void report_check_name(const std::string& name, const Mark& mark, const CheckInfo* info, Report& report) {
  if (info) {
    report.error(mark, "'{}' is an error in any case: nothing runs with it", name).named("choice");
    return;
  }
  std::vector<std::string> names;
  for (const CheckInfo& check : checks()) {
    if (!check.fixed) names.emplace_back(check.id);
  }
  report.error(mark, "there is no check '{}'", name).suggest(name, names).named("unknown-key");
}

}  // namespace

std::map<std::string, std::string> read_checks(const Node& node, Report& report) {
  std::map<std::string, std::string> checks;
  if (!node.is_mapping()) {
    report
        .error(node.mark, "'checks' is a mapping from checks to note, warning, error or off; here is {}",
               describe(node))
        .named("kind");
    return checks;
  }
  constexpr std::string_view levels[] = {"note", "warning", "error", "off"};
  for (std::size_t i = 0; i < node.items.size(); ++i) {
    const Node& value = node.items[i];
    const CheckInfo* const info = find_check(node.keys[i]);
    if (!info || info->fixed) {
      report_check_name(node.keys[i], node.key_marks[i], info, report);
    }
    if (value.is_scalar() && std::find(std::begin(levels), std::end(levels), value.text) != std::end(levels)) {
      checks[node.keys[i]] = value.text;
      continue;
    }
    report
        .error(value.mark, "the check '{}' is set to note, warning, error or off; here is {}", node.keys[i],
               describe(value))
        .named("choice");
  }
  return checks;
}

std::vector<RecordDecl> read_record(const Node& node, Report& report) {
  Columns columns(report);
  if (node.is_sequence()) {
    for (const Node& item : node.items) {
      if (!item.is_scalar()) {
        report.error(item.mark, "'record' lists names, here is {}", describe(item))
            .hint("columns with names of their own are written as a mapping: record: {error: r - y}")
            .named("kind");
        continue;
      }
      ExpressionPtr signal = parse_expression(item, report);
      if (signal && signal->kind != Expression::Kind::name) {
        report.error(item.mark, "the expression '{}' needs a column name", to_string(*signal))
            .hint(fmt::format("all columns as a mapping: record: {{my_column: {}}}", to_string(*signal)))
            .named("kind");
        continue;
      }
      columns.add(item.text, item.mark, std::move(signal));
    }
  } else if (node.is_mapping()) {
    for (std::size_t i = 0; i < node.items.size(); ++i) {
      if (!is_column_name(node.keys[i])) {
        report.error(node.key_marks[i], "'{}' cannot be the name of a column", node.keys[i])
            .hint("names are ASCII letters, digits and _, with dots between parts")
            .named("name");
      }
      columns.add(node.keys[i], node.key_marks[i], parse_expression(node.items[i], report));
    }
  } else {
    Finding& finding =
        report
            .error(node.mark, "'record' is a list of names or a mapping from columns to expressions; here is {}",
                   describe(node))
            .named("kind");
    if (node.is_scalar()) finding.hint(fmt::format("write record: [{}]", node.text));
  }
  return std::move(columns.list);
}

}  // namespace plantloop
