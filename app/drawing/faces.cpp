// Formulas come from the types' icons, curves from short runs of the block alone.

#include "app/drawing/faces.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "app/drawing/formulas.h"
#include "engine/base/error.h"
#include "engine/base/numbers.h"
#include "engine/run/diagram.h"
#include "render/diagram/arrangement.h"

namespace plantloop {
namespace {

constexpr double widest = 190;  // pixels, of a formula with its numbers

class Face {
 public:
  Face(const Graph& graph, const GraphBlock& block) : g_(graph), b_(block), kind_(*block.type->block) {}

  void give(SheetBlock& into) const {
    if (b_.type->name == "sum" || b_.type->name == "product") return circle(into);
    if (b_.type->name == "concat") {
      into.shape = SheetBlock::Shape::bar;
      return;
    }
    if (b_.type->name == "gain") into.shape = SheetBlock::Shape::gain;
    if (!b_.type->icon.empty()) {
      into.formula = from_icon();
      into.note = limits_text();
      return;
    }
    if (can_draw_curve() && draw_curve(into)) return;
    if (const std::string word = choice_word(); !word.empty()) {
      into.formula = word;
      return;
    }
    into.formula = in_lines(b_.type->name);
  }

 private:
  // ---- circles

  std::string text_of(std::string_view name) const {
    for (std::size_t i = 0; i < kind_.texts.size(); ++i)
      if (kind_.texts[i]->name == name) return g_.texts[b_.first_text + kind_.choices.size() + i];
    return {};
  }

  void circle(SheetBlock& into) const {
    const bool adds = b_.type->name == "sum";
    if (b_.inputs < 2) {
      into.formula = adds ? "Σ" : "Π";
      return;
    }
    into.shape = SheetBlock::Shape::circle;
    const std::string signs = text_of(adds ? "signs" : "operations");
    for (std::uint32_t i = 0; i < b_.inputs; ++i) {
      const char sign = i < signs.size() ? signs[i] : adds ? '+' : '*';
      into.inputs[i] = sign == '+' ? "+" : sign == '-' ? "−" : sign == '/' ? "÷" : "×";
    }
  }

  // ---- formulas

  struct Setting {
    const GraphParameter* parameter = nullptr;  // null: not given, or wired
    bool is_table = false;
  };

  std::optional<Setting> setting(std::string_view name) const {
    const std::size_t count = kind_.numbers.size() + kind_.tables.size() + kind_.counts.size();
    for (std::size_t i = 0; i < count; ++i) {
      const GraphParameter& p = g_.parameters[b_.first_parameter + i];
      if (p.name != name) continue;
      const bool table = i >= kind_.numbers.size() && i < kind_.numbers.size() + kind_.tables.size();
      return Setting{p.is_set ? &p : nullptr, table};
    }
    for (std::size_t i = 0; i < kind_.inputs.size(); ++i) {
      if (kind_.inputs[i]->name != name) continue;
      const GraphNet& net = g_.nets[b_.first_input + i];
      return Setting{net.by_parameter ? &g_.parameters[net.parameter] : nullptr, false};
    }
    return std::nullopt;
  }

  Formula from_icon() const {
    Report report;
    const ExpressionPtr icon = parse_expression(b_.type->icon, {}, report);
    if (!icon) return in_rows(b_.type->icon);
    Formula with_values =
        formula_of(*icon, [this](const Expression& name, bool is_factor) { return value_of(name, is_factor, true); });
    if (measure(with_values, sheet_style.text).width <= widest) return with_values;
    return formula_of(*icon,
                      [this](const Expression& name, bool is_factor) { return value_of(name, is_factor, false); });
  }

  // What the formula does not say: between which values the output is held.
  std::string limits_text() const {
    const auto value = [this](std::string_view name) -> std::string {
      const auto found = setting(name);
      if (!found || !found->parameter || found->parameter->is_default || !found->parameter->expression) return {};
      return spoken(formula_of(*found->parameter->expression.code->tree));
    };
    const std::string lower = value("lower"), upper = value("upper");
    if (lower.empty() && upper.empty()) return {};
    if (lower.empty()) return "u ≤ " + upper;
    return lower + " ≤ u" + (upper.empty() ? "" : " ≤ " + upper);
  }

  // Equations that are no expressions, as they stand; "; " ends a line.
  static Formula in_rows(std::string_view text) {
    std::vector<Formula> lines;
    for (std::size_t begin = 0; begin < text.size();) {
      const std::size_t end = std::min(text.find("; ", begin), text.size());
      lines.emplace_back(std::string(text.substr(begin, end - begin)));
      begin = end + 2;
    }
    return {Formula::Kind::lines, std::move(lines)};
  }

  std::string variable() const { return kind_.discretes.empty() ? "s" : "z"; }

  std::optional<Formula> value_of(const Expression& name, bool is_factor, bool with_values) const {
    const auto found = setting(name.parts[0]);
    if (!found) return std::nullopt;
    if (found->is_table && !(found->parameter != nullptr && with_values && !is_list(*found->parameter))) {
      if (kind_.states.empty() && kind_.discretes.empty()) return std::nullopt;  // a matrix: by its name
      if (!with_values || found->parameter == nullptr || !is_polynomial(*found->parameter))
        return Formula(name.parts[0] + "(" + variable() + ")");
      return polynomial_of(*found->parameter);
    }
    if (!with_values || found->parameter == nullptr) return std::nullopt;
    const GraphParameter& p = *found->parameter;
    if (p.is_default && p.value.all_known() && p.shape.is_scalar()) return Formula(pretty_number(p.value[0].number()));
    if (!p.expression) return std::nullopt;
    const Expression& tree = *p.expression.code->tree;
    if (tree.kind == Expression::Kind::vector) return std::nullopt;
    return formula_of(tree, {}, is_factor);
  }

  static bool is_list(const GraphParameter& p) {
    return !p.expression || p.expression.code->tree->kind == Expression::Kind::vector;
  }
  static bool is_polynomial(const GraphParameter& p) {
    return p.expression && p.expression.code->tree->kind == Expression::Kind::vector &&
           !p.expression.code->tree->arguments.empty() &&
           p.expression.code->tree->arguments[0]->kind != Expression::Kind::vector;
  }

  Formula polynomial_of(const GraphParameter& p) const {
    std::vector<Formula> coefficients;
    std::vector<std::optional<double>> numbers;
    for (const ExpressionPtr& a : p.expression.code->tree->arguments) {
      coefficients.push_back(formula_of(*a, {}, true));
      std::optional<double> number;
      if (a->kind == Expression::Kind::number) number = a->number;
      if (a->kind == Expression::Kind::unary && a->text == "-" && a->arguments[0]->kind == Expression::Kind::number)
        number = -a->arguments[0]->number;
      numbers.push_back(number);
    }
    return polynomial(coefficients, numbers, variable());
  }

  // ---- words

  // Of a block with one choice only, the chosen word: what it compares or which function it is.
  std::string choice_word() const {
    if (kind_.choices.size() != 1 || !kind_.numbers.empty() || !kind_.tables.empty()) return {};
    return g_.texts[b_.first_text];
  }

  static Formula in_lines(std::string_view words) {
    std::vector<Formula> lines;
    std::size_t begin = 0;
    while (begin <= words.size()) {
      const std::size_t end = std::min(words.find('_', begin), words.size());
      const std::string word(words.substr(begin, end - begin));
      // Short words share a line.
      if (!lines.empty() && lines.back().text.size() + word.size() < 9) {
        lines.back().text += " " + word;
      } else {
        lines.emplace_back(word);
      }
      begin = end + 1;
    }
    return lines.size() == 1 ? lines[0] : Formula(Formula::Kind::lines, std::move(lines));
  }

  // ---- curves

  bool is_source() const { return kind_.inputs.empty() && kind_.lists.empty(); }

  std::size_t required_inputs() const {
    return static_cast<std::size_t>(std::count_if(kind_.inputs.begin(), kind_.inputs.end(),
                                                  [](const Input* i) { return std::isnan(i->spec.init); }));
  }

  bool can_draw_curve() const {
    if (!kind_.states.empty() || !kind_.lists.empty() || b_.type->group == "run") return false;
    if (std::any_of(kind_.texts.begin(), kind_.texts.end(), [](const Text* t) { return t->spec.file; })) return false;
    if (is_source()) return true;
    return required_inputs() == 1 && kind_.outputs_declared.size() == 1 &&
           (kind_.discretes.empty() || kind_.rate_kind() == RateKind::any) && kind_.rate_kind() != RateKind::continuous;
  }

  static std::string text_of(const Array& value) {
    if (value.is_scalar()) return shortest(value[0].number());
    std::string text;
    for (int r = 0; r < value.rows(); ++r) {
      std::string row;
      for (int c = 0; c < value.columns(); ++c) row += (c > 0 ? ", " : "") + shortest(value(r, c).number());
      text += (r > 0 ? ", " : "") + (value.shape().rank == 2 ? "[" + row + "]" : row);
    }
    return "[" + text + "]";
  }

  // "p: value" for everything that the block was told; nothing when something is not known before the run.
  std::optional<std::string> settings_text() const {
    std::string text;
    const std::size_t count = kind_.numbers.size() + kind_.tables.size() + kind_.counts.size();
    for (std::size_t i = 0; i < count; ++i) {
      const GraphParameter& p = g_.parameters[b_.first_parameter + i];
      if (!p.is_set) continue;
      if (p.reads_signals || !p.value.all_known()) {
        if (p.reads_signals) continue;  // an initial value
        return std::nullopt;
      }
      text += fmt::format(", {}: {}", p.name, text_of(p.value));
    }
    for (std::size_t i = 0; i < kind_.choices.size(); ++i)
      text += fmt::format(", {}: {}", kind_.choices[i]->name, g_.texts[b_.first_text + i]);
    for (std::size_t i = 0; i < kind_.texts.size(); ++i)
      if (const std::string& word = g_.texts[b_.first_text + kind_.choices.size() + i]; !word.empty())
        text += fmt::format(", {}: \"{}\"", kind_.texts[i]->name, word);
    return text;
  }

  // Numbers that say how wide the characteristic is: the points of an ascending table, else all that are finite.
  std::pair<double, double> range() const {
    std::vector<double> numbers;
    bool ascending = false;
    const auto take = [&](const GraphParameter& p) {
      for (const Value& v : p.value.values())
        if (v.is_known() && std::isfinite(v.number())) numbers.push_back(v.number());
    };
    for (std::size_t i = 0; i < kind_.tables.size() && !ascending; ++i)
      if (kind_.tables[i]->spec.ascending) {
        ascending = true;
        take(g_.parameters[b_.first_parameter + kind_.numbers.size() + i]);
      }
    for (std::size_t i = 0; i < kind_.numbers.size() && !ascending; ++i) {
      const GraphParameter& p = g_.parameters[b_.first_parameter + i];
      if (p.is_set && p.value.all_known() && !p.reads_signals) take(p);
    }
    if (numbers.empty()) return {-2, 2};
    double least = *std::min_element(numbers.begin(), numbers.end()),
           most = *std::max_element(numbers.begin(), numbers.end());
    if (most - least < 1e-300) {
      const double size = most == 0 ? 1 : std::abs(most);
      return {-2.4 * size, 2.4 * size};
    }
    const double margin = (most - least) * (ascending ? 0.2 : 0.55);
    return {least - margin, most + margin};
  }

  // How long a source must be watched: twice the period of what swings, a bit longer than what begins or ends.
  double duration() const {
    double longest = 0, period = 0;
    for (std::size_t i = 0; i < kind_.numbers.size() + kind_.tables.size(); ++i) {
      const GraphParameter& p = g_.parameters[b_.first_parameter + i];
      if (!p.is_set || !p.value.all_known()) continue;
      for (const Value& v : p.value.values()) {
        const double x = std::abs(v.number());
        if (!std::isfinite(x) || x == 0) continue;
        if (p.unit == "rad/s") period = std::max(period, 4 * 3.14159265358979 / x);
        if (p.unit == "Hz" || p.unit == "1/s") period = std::max(period, 2 / x);
        if (p.unit == "s") longest = std::max(longest, x);
      }
    }
    if (period > 0) return period;
    if (longest > 0) return p_is_period() ? 2.5 * longest : 1.8 * longest;
    return 1;
  }
  bool p_is_period() const {
    return std::any_of(kind_.numbers.begin(), kind_.numbers.end(), [](const Number* n) { return n->name == "period"; });
  }

  bool draw_curve(SheetBlock& into) const {
    const auto settings = settings_text();
    if (!settings) return false;
    std::string rate, first;
    double start = 0, stop = 1;
    if (is_source()) {
      stop = duration();
      if (kind_.rate_kind() == RateKind::discrete) {
        if (b_.rate.kind != GraphRate::Kind::discrete) return false;
        const Rational period = g_.rates[b_.rate.index].period;
        rate = fmt::format(", rate: {}", period.to_string());
        stop = 16 * period.to_double();
      } else {
        start = -0.35 * stop;
      }
      first = "u: time";
    } else {
      const auto [from, until] = range();
      // There and, of what remembers, back; that twice, for it begins somewhere.
      first = fmt::format("u: \"{} + {}*(1 - abs(1 - mod(time, 2)))\"", shortest(from), shortest(until - from));
      if (!remembers()) first = fmt::format("u: \"{} + {}*time\"", shortest(from), shortest(until - from));
      stop = remembers() ? 4 : 1;
    }
    std::string input;
    if (!is_source())
      for (const Input* i : kind_.inputs)
        if (std::isnan(i->spec.init)) input = fmt::format(", in: {{{}: u}}", i->name);
    const std::string text = fmt::format(
        "plantloop: 1\nblocks:\n  {}\n  y: {{type: {}{}{}{}}}\nsimulation: {{start: {}, stop: {}}}\nrecord: [u, y]\n",
        first, b_.type->name, input, *settings, rate, shortest(start), shortest(stop));
    Report report;
    const auto diagram = Diagram::from_text(text, g_.model->path, report);
    if (!diagram || report.has_errors()) return false;
    try {
      const auto run = diagram->run({}, report);
      if (!run) return false;
      return scale(run->recording, !is_source() && remembers() ? 2 : start, into);
    } catch (const RunError&) {
      return false;
    }
  }

  // Whether the output depends on what was before.
  bool remembers() const {
    return !kind_.discretes.empty() ||
           std::any_of(kind_.numbers.begin(), kind_.numbers.end(), [](const Number* n) { return n->spec.initial; });
  }

  // What happens from that time on.
  bool scale(const Recording& recording, double since, SheetBlock& into) const {
    std::vector<Curve> curves;
    double left = INFINITY, right = -INFINITY, low = INFINITY, high = -INFINITY;
    for (std::size_t c = 1; c < recording.columns.size() && c <= 4; ++c) {
      Curve curve;
      const std::vector<double> x = recording.column(0), y = recording.column(c);
      const bool stairs = recording.columns[c].rate != 0;
      for (std::size_t i = 0; i < x.size(); ++i) {
        if (recording.time()[i] < since) continue;
        if (!std::isfinite(x[i]) || !std::isfinite(y[i])) return false;
        if (stairs && !curve.empty() && curve.back().y != y[i]) curve.push_back({x[i], curve.back().y});
        curve.push_back({x[i], y[i]});
        left = std::min(left, x[i]);
        right = std::max(right, x[i]);
        low = std::min(low, y[i]);
        high = std::max(high, y[i]);
      }
      curves.push_back(std::move(curve));
    }
    if (curves.empty() || !(right > left)) return false;
    const bool is_level = high - low < 1e-12 * std::max(1.0, std::abs(high));
    // A characteristic shows the axes through zero where they are near.
    if (!is_source()) {
      if (low > 0 && low < 0.6 * high) low = 0;
      if (high < 0 && high > 0.6 * low) high = 0;
    }
    const auto x_of = [&](double x) { return (x - left) / (right - left); };
    const auto y_of = [&](double y) { return is_level ? 0.5 : (y - low) / (high - low); };
    for (Curve& curve : curves) {
      for (Spot& s : curve) s = {x_of(s.x), y_of(s.y)};
      into.curves.push_back(std::move(curve));
    }
    if (is_source() || is_level) return true;
    if (left < 0 && right > 0) into.axes.push_back({{x_of(0), -0.12}, {x_of(0), 1.12}});
    if (low <= 0 && high >= 0) into.axes.push_back({{0, y_of(0)}, {1, y_of(0)}});
    return true;
  }

  const Graph& g_;
  const GraphBlock& b_;
  const Block& kind_;
};

}  // namespace

void give_face(const Graph& graph, const GraphBlock& block, SheetBlock& into) { Face(graph, block).give(into); }

}  // namespace plantloop
