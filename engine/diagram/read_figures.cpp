// `figures:`: panels, curves, lines and bands.

#include <utility>

#include "engine/diagram/read.h"
#include "engine/diagram/section.h"

namespace plantloop {
namespace {

// `[lower, upper]`
void read_limits(const Section& section, ExpressionPtr& lower, ExpressionPtr& upper, Report& report) {
  const Node* node = section.find("limits");
  if (!node) return;
  if (!node->is_sequence() || node->items.size() != 2) {
    report.error(node->mark, "'limits' are two numbers, [lower, upper]; here is {}", describe(*node)).named("kind");
    return;
  }
  lower = parse_expression(node->items[0], report);
  upper = parse_expression(node->items[1], report);
}

FigureSignal read_signal(const Node& node, Report& report) {
  FigureSignal signal;
  signal.mark = node.mark;
  if (!node.is_mapping()) {
    signal.signal = parse_expression(node, report);
    return signal;
  }
  const Section section(node, "a curve", {"signal", "label", "style"}, report);
  section.require("signal", node.mark, "{signal: y, label: position}");
  signal.signal = section.expression("signal");
  signal.label = section.text("label");
  signal.style =
      section.choice("style", {"solid", "dashed", "dotted", "dashdot", "points", "line_points", "steps"}, "");
  return signal;
}

std::vector<FigureSignal> read_signals(const Node* node, Report& report) {
  std::vector<FigureSignal> signals;
  if (!node) return signals;
  if (!node->is_sequence()) {
    signals.push_back(read_signal(*node, report));
  } else {
    for (const Node& item : node->items) signals.push_back(read_signal(item, report));
    if (node->items.empty()) report.error(node->mark, "a panel shows at least one signal").named("missing-key");
  }
  std::erase_if(signals, [](const FigureSignal& signal) { return !signal.signal; });
  return signals;
}

void read_labels(const Section& section, FigurePanel& panel, Report& report) {
  const Node* labels = section.find("labels");
  const Node* curves = section.find("y");
  if (!labels || !curves) return;
  const std::size_t n = curves->is_sequence() ? curves->items.size() : 1;
  if (!labels->is_sequence() || labels->items.size() != n) {
    report
        .error(labels->mark, "'labels' has one text for each entry of 'y', {} in all; here is {}", n, describe(*labels))
        .named("kind");
    return;
  }
  if (panel.y.size() != n) return;  // reported
  for (std::size_t i = 0; i < n; ++i) {
    if (require_text(labels->items[i], "a label", report)) {
      panel.y[i].label = plain_text(labels->items[i], "a label", report);
    }
  }
}

FigureLine read_line(const Node& node, Report& report) {
  FigureLine line;
  const Section section(node, "a line", {"x", "y", "label"}, report);
  if (section && !section.find("x") == !section.find("y")) {
    report.error(node.mark, "a line has either x or y").hint("for example {y: 1.5, label: limit}").named("missing-key");
  }
  line.x = section.expression("x");
  line.y = section.expression("y");
  line.label = section.text("label");
  return line;
}

FigureBand read_band(const Node& node, Report& report) {
  FigureBand band;
  const Section section(node, "a band", {"lower", "upper", "from", "until", "label"}, report);
  section.require("lower", node.mark, "{lower: 0.98, upper: 1.02}");
  section.require("upper", node.mark, "{lower: 0.98, upper: 1.02}");
  band.lower = section.expression("lower");
  band.upper = section.expression("upper");
  band.from = section.expression("from");
  band.until = section.expression("until");
  band.label = section.text("label");
  return band;
}

// The entries of a list, each read by `read`.
template <typename Read>
auto read_list(const Section& section, std::string_view key, Report& report, Read read) {
  std::vector<decltype(read(std::declval<const Node&>(), report))> list;
  const Node* node = section.find(key);
  if (!node) return list;
  if (!node->is_sequence()) {
    report.error(node->mark, "'{}' is a list, here is {}", key, describe(*node)).named("kind");
    return list;
  }
  for (const Node& item : node->items) list.push_back(read(item, report));
  return list;
}

FigurePanel read_panel(const Node& node, Report& report) {
  FigurePanel panel;
  panel.mark = node.mark;
  const Section section(
      node, "a panel",
      {"y", "x", "label", "labels", "x_label", "limits", "scale", "right", "right_label", "lines", "bands", "equal"},
      report);
  section.require("y", node.mark, "panels: [{y: [r, y]}]");
  panel.y = read_signals(section.find("y"), report);
  read_labels(section, panel, report);
  panel.right = read_signals(section.find("right"), report);
  panel.x.mark = node.mark;
  if (const Node* x = section.find("x")) panel.x = read_signal(*x, report);
  panel.label = section.text("label");
  panel.x_label = section.text("x_label");
  panel.right_label = section.text("right_label");
  panel.scale = section.choice("scale", {"linear", "log"}, "linear");
  read_limits(section, panel.lower_limit, panel.upper_limit, report);
  panel.lines = read_list(section, "lines", report, read_line);
  panel.bands = read_list(section, "bands", report, read_band);
  panel.equal = section.boolean("equal", false);
  return panel;
}

FigureDecl read_figure(const std::string& name, const Mark& mark, const Node& node, Report& report) {
  FigureDecl figure;
  figure.name = name;
  figure.mark = mark;
  check_name(name, mark, "figure", report);
  const Section section(node, fmt::format("figure '{}'", name), {"title", "x", "theme", "width", "panels"}, report);
  figure.title = section.text("title");
  figure.theme = section.choice("theme", {"light", "dark", "print"}, "");
  figure.width = section.expression("width");
  if (const Node* x = section.find("x"); x && x->is_scalar()) {
    figure.x_label = plain_text(*x, "'x'", report);
  } else if (x) {
    const Section axis(*x, "the x axis", {"label", "limits"}, report);
    figure.x_label = axis.text("label");
    read_limits(axis, figure.x_lower, figure.x_upper, report);
  }
  section.require("panels", mark, "panels: [{y: [r, y], label: \"position [m]\"}]");
  figure.panels = read_list(section, "panels", report, read_panel);
  if (section.find("panels") && section.find("panels")->is_sequence() && figure.panels.empty()) {
    report.error(section.mark_of("panels"), "figure '{}' has no panels", name).named("missing-key");
  }
  return figure;
}

}  // namespace

std::vector<FigureDecl> read_figures(const Node& node, Report& report) {
  std::vector<FigureDecl> figures;
  if (!node.is_mapping()) {
    report.error(node.mark, "'figures' is a mapping from names to figures, here is {}", describe(node)).named("kind");
    return figures;
  }
  for (std::size_t i = 0; i < node.items.size(); ++i) {
    figures.push_back(read_figure(node.keys[i], node.key_marks[i], node.items[i], report));
  }
  return figures;
}

}  // namespace plantloop
