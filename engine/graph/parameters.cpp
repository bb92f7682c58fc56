// The values of parameters, in the order of their dependencies, with their bounds.

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/base/numbers.h"
#include "engine/graph/elaboration.h"
#include "engine/graph/static_instance.h"

namespace plantloop {

Shape BoundNames::shape(std::uint32_t name) {
  const Reference& r = reference(name);
  Shape whole = Shape::scalar();
  if (r.kind == Reference::Kind::missing) return Shape::unknown();
  if (r.kind == Reference::Kind::parameter) whole = graph_.parameters[r.index].shape;
  if (r.kind == Reference::Kind::net) whole = graph_.nets[r.index].shape;
  if (r.whole) return whole;
  return r.last > 0 ? Shape::vector(r.last - r.first + 1) : Shape::scalar();
}

Array BoundNames::value(std::uint32_t name) {
  const Array* array = known(name);
  return array ? *array : Array();
}

const Array* BoundNames::known(std::uint32_t name) {
  const Reference& r = reference(name);
  if (r.kind == Reference::Kind::number) return &(held_ = r.number);
  if (r.kind != Reference::Kind::parameter) return nullptr;
  const GraphParameter& p = graph_.parameters[r.index];
  if (!p.shape.is_known() || p.reads_signals || p.bad) return nullptr;
  if (r.whole) return &p.value;
  return &(held_ = element_of(p.value, r.first, r.last, r.column));
}

void mark_structural(Graph& graph, std::uint32_t parameter, std::uint8_t level) {
  std::vector<std::pair<std::uint32_t, std::uint8_t>> open{{parameter, level}};
  bool first = true;
  while (!open.empty()) {
    const auto [index, wanted] = open.back();
    open.pop_back();
    GraphParameter& p = graph.parameters[index];
    if (p.structural >= wanted && !first) continue;
    first = false;
    p.structural = std::max(p.structural, wanted);
    if (!p.expression) continue;
    // Whether a sum is zero is not known from its terms.
    std::uint8_t below = wanted;
    for (const Step& s : p.expression.code->steps) {
      const bool keeps_zero = s.kind == Step::Kind::number || s.kind == Step::Kind::name ||
                              s.kind == Step::Kind::join || (s.kind == Step::Kind::unary && s.op == Op::neg);
      if (!keeps_zero) below = 2;
    }
    for (std::size_t i = 0; i < p.expression.code->names.size(); ++i) {
      const Reference& r = graph.references[p.expression.first_reference + i];
      if (r.kind == Reference::Kind::parameter) open.emplace_back(r.index, below);
    }
  }
}

void mark_structural(Graph& graph, const BoundExpression& bound, std::uint8_t level) {
  for (std::size_t i = 0; i < bound.code->names.size(); ++i) {
    const Reference& r = graph.references[bound.first_reference + i];
    if (r.kind == Reference::Kind::parameter) mark_structural(graph, r.index, level);
  }
}

namespace {

class Evaluation final : public Checking {
 public:
  explicit Evaluation(Elaboration& e) : e_(e), g_(e.g), instance_(e.g) {}

  void run() {
    order_parameters();
    for (const std::uint32_t index : e_.parameter_order) evaluate_one(index);
    for (std::uint32_t i = 0; i < g_.parameters.size(); ++i) {
      if (g_.parameters[i].structural > 0) mark_structural(g_, i, g_.parameters[i].structural);
    }
    mark_sizes();
    check_blocks();
  }

  // Checking, for the block in hand.
  std::vector<double> of(const Number& n) const override { return numbers_of(slot(n)); }
  std::vector<double> of(const Table& t) const override { return numbers_of(slot(t)); }
  Shape shape(const Table& t) const override { return slot(t).shape; }
  bool given(const Declared& declared) const override {
    const GraphParameter* p = find(declared);
    return p && p->is_set;
  }
  void problem(const Declared& declared, const std::string& text) override {
    add_origin(e_.findings.error(mark_of(declared), "{}: {}", title_of(g_, *block_), text).named("parameter"),
               find(declared));
  }
  void note(const Declared& declared, std::string_view check, const std::string& text) override {
    e_.findings.check(check, mark_of(declared), "{}: {}", title_of(g_, *block_), text);
  }

 private:
  Mark mark_of(const Declared& declared) const {
    if (const GraphParameter* p = find(declared)) return p->mark;
    for (const FieldDecl& field : block_->declaration->fields) {
      if (field.name == declared.name) return field.mark;
    }
    return block_->declaration->mark;
  }

  // Depth first, without recursion; parameters in a circle are reported once and left out.
  void order_parameters() {
    const auto count = static_cast<std::uint32_t>(g_.parameters.size());
    std::vector<std::uint8_t> state(count, 0);  // 0 new, 1 open, 2 done
    struct Open {
      std::uint32_t parameter, next;
    };
    std::vector<Open> open;
    e_.parameter_order.reserve(count);
    for (std::uint32_t start = 0; start < count; ++start) {
      if (state[start] != 0) continue;
      open.push_back({start, 0});
      state[start] = 1;
      while (!open.empty()) {
        Open& top = open.back();
        const GraphParameter& p = g_.parameters[top.parameter];
        const std::size_t names = p.expression ? p.expression.code->names.size() : 0;
        if (top.next == names || p.bad) {
          state[top.parameter] = 2;
          e_.parameter_order.push_back(top.parameter);
          open.pop_back();
          continue;
        }
        const Reference& r = g_.references[p.expression.first_reference + top.next++];
        if (r.kind != Reference::Kind::parameter) continue;
        if (state[r.index] == 0) {
          state[r.index] = 1;
          open.push_back({r.index, 0});
        } else if (state[r.index] == 1) {
          std::string path;
          auto from = std::find_if(open.begin(), open.end(), [&](const Open& o) { return o.parameter == r.index; });
          for (; from != open.end(); ++from) {
            path += path_of(g_, g_.parameters[from->parameter]) + " -> ";
            g_.parameters[from->parameter].bad = true;
          }
          const GraphParameter& again = g_.parameters[r.index];
          e_.findings
              .error(again.expression.mark, "parameters depend on each other in a circle: {}{}", path,
                     path_of(g_, again))
              .named("parameter-cycle");
        }
      }
    }
  }

  void evaluate_one(std::uint32_t index) {
    GraphParameter& p = g_.parameters[index];
    if (!p.expression || p.bad || p.text != nowhere) return;
    const Code& code = *p.expression.code;
    for (std::size_t i = 0; i < code.names.size(); ++i) {
      const Reference& r = g_.references[p.expression.first_reference + i];
      if (r.kind != Reference::Kind::parameter) continue;
      const GraphParameter& used = g_.parameters[r.index];
      p.bad |= used.bad || (!r.whole && !has_element(p, code, i, r, used.shape));
      p.reads_signals |= used.reads_signals;
    }
    if (p.bad || p.reads_signals) return;
    BoundNames names(g_, p.expression);
    p.shape = shape_of(code, names, &e_.findings);
    p.bad = !p.shape.is_known();
    if (p.bad) return;
    p.value = evaluate(code, names);
    if (is_infinite(p.value) && !mentions_infinity(code, names)) {
      e_.findings.error(p.expression.mark, "the value of '{}' is infinite: {}", path_of(g_, p), to_string(*code.tree))
          .hint("where nothing limits a value, write inf")
          .named("not-a-number");
      p.bad = true;
      return;
    }
    for (const Value& v : p.value.values()) {
      if (!std::isnan(v.number())) continue;
      e_.findings
          .error(p.expression.mark, "the value of '{}' is not a number: {}", path_of(g_, p), to_string(*code.tree))
          .named("not-a-number");
      p.bad = true;
      return;
    }
    if (!p.of_scope) check_declared(index);
    if (!p.bad) check_bounds(p);
  }

  static bool is_infinite(const Array& value) {
    const auto values = value.values();
    return std::any_of(values.begin(), values.end(), [](const Value& v) { return std::isinf(v.number()); });
  }

  static bool has_inf(const Expression& node) {
    if (node.kind == Expression::Kind::name && node.parts.size() == 1 && node.parts[0] == "inf") return true;
    if (node.kind == Expression::Kind::number && std::isinf(node.number)) return true;
    return std::any_of(node.arguments.begin(), node.arguments.end(), [](const auto& a) { return a && has_inf(*a); });
  }

  // Whether an infinite value is as written: it reads inf, or a parameter that is infinite.
  static bool mentions_infinity(const Code& code, BoundNames& names) {
    if (has_inf(*code.tree)) return true;
    for (std::uint32_t i = 0; i < code.names.size(); ++i) {
      const Array* const read = names.known(i);
      if (read != nullptr && is_infinite(*read)) return true;
    }
    return false;
  }

  bool has_element(const GraphParameter& p, const Code& code, std::size_t name, const Reference& r,
                   const Shape& shape) {
    (void)p;
    if (!shape.is_known()) return true;
    return element_exists(e_.findings, *code.names[name], r, shape);
  }

  // Counts are whole, single numbers are single.
  void check_declared(std::uint32_t index) {
    GraphParameter& p = g_.parameters[index];
    const GraphBlock& block = g_.blocks[p.owner];
    const Block& kind = *block.type->block;
    const std::size_t at = index - block.first_parameter;
    const std::size_t counts = kind.numbers.size() + kind.tables.size();
    if (at >= counts + kind.counts.size()) return;  // an input's default
    const bool one =
        at >= counts || (at < kind.numbers.size() && kind.numbers[at]->spec.size.kind == Size::Kind::scalar);
    if (one && p.shape.size() != 1) {
      add_origin(e_.findings.error(p.mark, "'{}' of {} is one number, got {}", p.name, title_of(g_, block),
                                   to_string(p.shape)),
                 &p);
      p.bad = true;
      return;
    }
    if (one && !p.shape.is_scalar()) {
      p.value = p.value.spread(Shape::scalar());
      p.shape = Shape::scalar();
    }
    if (at < counts) return;
    const CountSpec& spec = kind.counts[at - counts]->spec;
    const double number = p.value[0].number();
    if (number != std::floor(number) || number < spec.min || number > spec.max) {
      add_origin(e_.findings.error(p.mark, "'{}' of {} is a whole number from {} to {}, got {}", p.name,
                                   title_of(g_, block), spec.min, spec.max, shortest(number)),
                 &p)
          .named("bounds");
      p.bad = true;
      p.value = Value(static_cast<double>(spec.init));
    }
  }

  void check_bounds(GraphParameter& p) {
    const std::string unit = p.unit.empty() ? "" : fmt::format(" {}", p.unit);
    double before = -unbounded;
    for (int i = 0; i < p.value.size(); ++i) {
      const double v = p.value[i].number();
      std::string must;
      if (v < p.min) must = fmt::format("must be at least {}{}", shortest(p.min), unit);
      if (v <= p.above && p.above != -unbounded)
        must = fmt::format("must be greater than {}{}", shortest(p.above), unit);
      if (v > p.max) must = fmt::format("must be at most {}{}", shortest(p.max), unit);
      if (p.ascending && i > 0 && !(v > before)) {
        must = fmt::format("must ascend: element {} must be greater than {}", i + 1, shortest(before));
      }
      before = v;
      if (must.empty()) continue;
      const std::string element = p.value.is_scalar() || p.ascending ? "" : fmt::format(".{}", i + 1);
      const std::string owner = p.of_scope ? "'" + g_.scopes[p.owner].path + "'" : title_of(g_, g_.blocks[p.owner]);
      add_origin(e_.findings.error(p.mark, "'{}{}' of {} {}, got {}", p.name, element, owner, must, shortest(v)), &p)
          .named("bounds");
      p.bad = true;
      return;
    }
  }

  // Where the number was written, when the parameter only hands it on.
  Finding& add_origin(Finding& finding, const GraphParameter* p) {
    const GraphParameter* from = p;
    while (from && from->expression && from->expression.code->is_name()) {
      const Reference& r = g_.references[from->expression.first_reference];
      if (r.kind != Reference::Kind::parameter) break;
      from = &g_.parameters[r.index];
    }
    if (from && from != p) finding.also(from->mark, fmt::format("'{}' was set here", path_of(g_, *from)));
    return finding;
  }

  // Numbers that sizes depend on: zeros(n) anywhere.
  void mark_sizes() {
    for (const BoundExpression& count : e_.counts) mark_structural(g_, count, 2);
    const auto visit = [this](const BoundExpression& bound) {
      if (!bound || !bound.code->has_sizes) return;
      for (std::size_t i = 0; i < bound.code->steps.size(); ++i) {
        const Step& s = bound.code->steps[i];
        if (s.kind != Step::Kind::function || s.function < Function::zeros || s.function > Function::eye) continue;
        for (std::size_t k = s.begin; k < i; ++k) {
          if (bound.code->steps[k].kind != Step::Kind::name) continue;
          const Reference& r = g_.references[bound.first_reference + bound.code->steps[k].name];
          if (r.kind == Reference::Kind::parameter) mark_structural(g_, r.index, 2);
        }
      }
    };
    for (const GraphParameter& p : g_.parameters) visit(p.expression);
    for (const GraphNet& net : g_.nets) visit(net.driver);
  }

  void check_blocks() {
    for (GraphBlock& block : g_.blocks) {
      if (!block.type) continue;
      const Block& kind = *block.type->block;
      const std::size_t count = kind.numbers.size() + kind.tables.size() + kind.counts.size();
      for (std::size_t i = 0; i < count; ++i) block.bad |= g_.parameters[block.first_parameter + i].bad;
      if (block.bad) continue;
      block_ = &block;
      instance_.stand_for(block);
      kind.check(*this);
    }
  }

  const GraphParameter& slot(const Number& n) const {
    return g_.parameters[block_->first_parameter + static_cast<std::uint32_t>(n.index)];
  }
  const GraphParameter& slot(const Table& t) const {
    return g_
        .parameters[block_->first_parameter + block_->type->block->numbers.size() + static_cast<std::size_t>(t.index)];
  }
  const GraphParameter* find(const Declared& declared) const {
    const Block& kind = *block_->type->block;
    const std::size_t count = kind.numbers.size() + kind.tables.size() + kind.counts.size();
    for (std::size_t i = 0; i < count; ++i) {
      const GraphParameter& p = g_.parameters[block_->first_parameter + i];
      if (p.name == declared.name) return &p;
    }
    return nullptr;
  }
  static std::vector<double> numbers_of(const GraphParameter& p) {
    std::vector<double> numbers;
    if (!p.is_set || p.reads_signals || !p.shape.is_known()) return numbers;
    for (const Value& v : p.value.values()) numbers.push_back(v.number());
    return numbers;
  }

  Elaboration& e_;
  Graph& g_;
  StaticInstance instance_;
  const GraphBlock* block_ = nullptr;
};

}  // namespace

bool element_exists(Findings& findings, const Expression& node, const Reference& r, const Shape& shape) {
  const std::string& name = node.parts.front();
  if (r.column > 0) {
    if (shape.rank == 2 && r.first <= shape.rows && r.column <= shape.columns) return true;
    findings.error(node.mark, "'{}' does not exist: it is {}", to_string(node), to_string(shape)).named("element");
    return false;
  }
  if (shape.rank == 2) {
    findings
        .error(node.mark, "'{}': an element of a matrix has two numbers, .1.2; it is {}", to_string(node),
               to_string(shape))
        .named("element");
    return false;
  }
  if (std::max(r.first, r.last) <= shape.size()) return true;
  (void)name;
  findings.error(node.mark, "'{}' does not exist: it is {}", to_string(node), to_string(shape)).named("element");
  return false;
}

void evaluate_parameters(Elaboration& e) { Evaluation(e).run(); }

}  // namespace plantloop
