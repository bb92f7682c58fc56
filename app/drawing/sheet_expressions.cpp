// Sums become circles, constant factors gains, and the rest one box with its formula.

#include "app/drawing/sheet_maker.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

#include "app/drawing/faces.h"
#include "app/drawing/formulas.h"
#include "render/diagram/arrangement.h"

namespace plantloop {

namespace {

using Kind = Expression::Kind;

// A term of a sum, or a factor of a product.
struct Part {
  const Expression* node = nullptr;
  bool inverse = false;  // subtracted; divided by
};

void flatten(const Expression& e, bool inverse, const char* direct, const char* opposite, std::vector<Part>& into) {
  if (e.kind == Kind::binary && e.text == direct) {
    flatten(*e.arguments[0], inverse, direct, opposite, into);
    flatten(*e.arguments[1], inverse, direct, opposite, into);
  } else if (e.kind == Kind::binary && e.text == opposite) {
    flatten(*e.arguments[0], inverse, direct, opposite, into);
    flatten(*e.arguments[1], !inverse, direct, opposite, into);
  } else {
    into.push_back({&e, inverse});
  }
}

void collect_factors(const Expression& e, bool inverse, std::vector<Part>& into, bool& minus) {
  if (e.kind == Kind::unary && e.text == "-") {
    minus = !minus;
    collect_factors(*e.arguments[0], inverse, into, minus);
  } else if (e.kind == Kind::binary && (e.text == "*" || e.text == "/")) {
    collect_factors(*e.arguments[0], inverse, into, minus);
    collect_factors(*e.arguments[1], e.text == "/" ? !inverse : inverse, into, minus);
  } else {
    into.push_back({&e, inverse});
  }
}

bool is_word(const Expression& e) { return e.kind == Kind::name && !is_symbol(e.parts.back()); }

Formula gain_formula(const std::vector<Part>& numbers, bool minus) {
  std::vector<Formula> over, under;
  const Expression* before[2] = {nullptr, nullptr};
  const auto below = std::count_if(numbers.begin(), numbers.end(), [](const Part& p) { return p.inverse; });
  const auto above = static_cast<std::ptrdiff_t>(numbers.size()) - below;
  for (const Part& p : numbers) {
    // A sum needs brackets only beside others, or behind a minus.
    const bool is_factor = (p.inverse ? below : above) > 1 || (minus && below == 0);
    std::vector<Formula>& into = p.inverse ? under : over;
    if (const Expression* last = before[p.inverse]) {
      const bool dot = p.node->kind == Kind::number || is_word(*p.node) || is_word(*last);
      into.emplace_back(dot ? " · " : " ");
    }
    into.push_back(formula_of(*p.node, {}, is_factor));
    before[p.inverse] = p.node;
  }
  if (over.empty()) over.emplace_back("1");
  Formula top(Formula::Kind::row, std::move(over));
  if (!under.empty()) {
    Formula bottom(Formula::Kind::row, std::move(under));
    top = Formula(Formula::Kind::fraction, {std::move(top), std::move(bottom)});
  }
  if (!minus) return top;
  if (top.kind == Formula::Kind::row && top.parts.size() == 1 && top.parts[0].text == "1") return "−1";
  return {Formula::Kind::row, {"−", std::move(top)}};
}

}  // namespace

SheetPort SheetMaker::build(const Expression& e, const std::string& path) {
  if (!reads_signals(e)) return terminal(formula_of(e), path);
  if (e.kind != Kind::name && !reads_nets(e)) return build_box(e, path);  // a waveform
  if (e.kind == Kind::name) return build_name(e, path);
  if (e.kind == Kind::unary && e.text == "+") return build(*e.arguments[0], path);
  if (e.kind == Kind::binary && (e.text == "+" || e.text == "-")) return build_sum(e, path);
  if ((e.kind == Kind::unary && e.text == "-") || (e.kind == Kind::binary && (e.text == "*" || e.text == "/"))) {
    if (const auto port = build_product(e, path)) return *port;
  }
  if (e.kind == Kind::vector) return build_vector(e, path);
  return build_box(e, path);
}

SheetPort SheetMaker::terminal(Formula formula, const std::string& path) {
  SheetBlock b;
  b.path = path;
  b.shape = Shape::value;
  b.formula = std::move(formula);
  b.outputs = {""};
  return {add(std::move(b)), 0};
}

SheetPort SheetMaker::build_name(const Expression& e, const std::string& path) {
  const Reference& r = *meaning(e);
  if (r.kind == Reference::Kind::time) return terminal("t", path + "t");
  if (r.whole) return source_of(r.index);
  return build_box(e, path);
}

SheetPort SheetMaker::build_sum(const Expression& e, const std::string& path) {
  std::vector<Part> terms;
  flatten(e, false, "+", "-", terms);
  SheetBlock b;
  b.path = path;
  b.shape = Shape::circle;
  b.outputs = {""};
  for (Part& term : terms) {
    // -k*x is k*x subtracted.
    while (term.node->kind == Kind::unary && term.node->text == "-") {
      term.node = term.node->arguments[0].get();
      term.inverse = !term.inverse;
    }
    b.inputs.emplace_back(term.inverse ? "−" : "+");
  }
  const int index = add(std::move(b));
  for (std::size_t i = 0; i < terms.size(); ++i) {
    const SheetPort from = build(*terms[i].node, fmt::format("{}+{}", path, i + 1));
    wire_from(from).to.push_back({index, static_cast<int>(i)});
  }
  return {index, 0};
}

std::optional<SheetPort> SheetMaker::build_product(const Expression& e, const std::string& path) {
  std::vector<Part> factors;
  bool minus = false;
  collect_factors(e, false, factors, minus);
  std::vector<Part> numbers, signals;
  for (const Part& f : factors) (reads_signals(*f.node) ? signals : numbers).push_back(f);
  const bool quotient = std::any_of(signals.begin(), signals.end(), [](const Part& p) { return p.inverse; });
  if (quotient && signals.size() == 1) return std::nullopt;
  if (signals.size() > 3) return std::nullopt;
  SheetPort port;
  const bool has_gain = !numbers.empty() || minus;
  if (signals.size() == 1) {
    port = build(*signals[0].node, has_gain ? path + "*" : path);
  } else {
    SheetBlock b;
    b.path = has_gain ? path + "*" : path;
    b.shape = Shape::circle;
    b.outputs = {""};
    for (const Part& f : signals) b.inputs.emplace_back(f.inverse ? "÷" : "×");
    const int index = add(std::move(b));
    for (std::size_t i = 0; i < signals.size(); ++i) {
      const SheetPort from = build(*signals[i].node, fmt::format("{}*{}", path, i + 1));
      wire_from(from).to.push_back({index, static_cast<int>(i)});
    }
    port = {index, 0};
  }
  if (!has_gain) return port;
  SheetBlock gain;
  gain.path = path;
  gain.shape = Shape::gain;
  gain.formula = gain_formula(numbers, minus);
  gain.inputs = {""};
  gain.outputs = {""};
  const int index = add(std::move(gain));
  wire_from(port).to.push_back({index, 0});
  return SheetPort{index, 0};
}

SheetPort SheetMaker::build_vector(const Expression& e, const std::string& path) {
  SheetBlock b;
  b.path = path;
  b.shape = Shape::bar;
  b.outputs = {""};
  b.inputs.assign(e.arguments.size(), "");
  const int index = add(std::move(b));
  for (std::size_t i = 0; i < e.arguments.size(); ++i) {
    const SheetPort from = build(*e.arguments[i], fmt::format("{},{}", path, i + 1));
    wire_from(from).to.push_back({index, static_cast<int>(i)});
  }
  return {index, 0};
}

SheetPort SheetMaker::build_box(const Expression& e, const std::string& path, bool later) {
  std::vector<std::uint32_t> read;
  std::map<std::uint32_t, std::string> text;
  collect(e, read, text);
  SheetBlock b;
  b.path = path;
  b.formula = formula_of(e, [this](const Expression& name, bool is_factor) { return element_of(name, is_factor); });
  b.outputs = {""};
  for (const std::uint32_t net : read) b.inputs.push_back(text[net]);
  const FormulaSize size = measure(b.formula, sheet_style.text);
  if (size.width > 420) {
    std::vector<Formula> words{"f("};
    for (std::size_t i = 0; i < read.size(); ++i) words.emplace_back((i > 0 ? ", " : "") + text[read[i]]);
    words.emplace_back(")");
    b.formula = Formula(Formula::Kind::row, std::move(words));
  }
  const int index = add(std::move(b));
  for (std::size_t i = 0; i < read.size(); ++i) {
    if (later)
      unwired_.push_back({read[i], {index, static_cast<int>(i)}});
    else
      wire_from(source_of(read[i])).to.push_back({index, static_cast<int>(i)});
  }
  return {index, 0};
}

std::optional<Formula> SheetMaker::element_of(const Expression& name, bool) const {
  const Reference* r = meaning(name);
  if (r != nullptr && r->kind == Reference::Kind::time) return Formula("t");
  return std::nullopt;
}

void SheetMaker::collect(const Expression& e, std::vector<std::uint32_t>& read,
                         std::map<std::uint32_t, std::string>& text) const {
  if (e.kind == Kind::name) {
    const Reference* r = meaning(e);
    if (r == nullptr || r->kind != Reference::Kind::net) return;
    if (std::find(read.begin(), read.end(), r->index) == read.end()) read.push_back(r->index);
    std::size_t names = e.parts.size();
    while (names > 1 && e.parts[names - 1][0] >= '0' && e.parts[names - 1][0] <= '9') --names;
    text.emplace(r->index, pretty_name(e.parts[names - 1]));
    return;
  }
  for (const ExpressionPtr& a : e.arguments) collect(*a, read, text);
}

}  // namespace plantloop
