// `repeat: n`: how many copies there are, and what `--set` says of each.
//
// The number decides which blocks there are, so it is needed before names are resolved and parameters have values. It
// is worked out from the parameters of the scope alone, through their texts; the same texts are resolved and checked
// like all others later on.

#include <cmath>
#include <utility>

#include "engine/base/numbers.h"
#include "engine/graph/elaboration.h"

namespace plantloop {
namespace {

constexpr int deepest = 200;  // parameters that depend on parameters; a circle is reported with the parameters

std::optional<Array> early_value(Elaboration& e, const BoundExpression& bound, int depth);

// The names of an expression over parameters of its scope.
class EarlyNames final : public Names {
 public:
  EarlyNames(Elaboration& e, const BoundExpression& bound, int depth) : values_(bound.code->names.size()) {
    for (std::size_t i = 0; i < values_.size() && sound_; ++i) {
      std::optional<Array> value = look_up(e, bound, *bound.code->names[i], depth);
      sound_ = value.has_value();
      if (sound_) values_[i] = std::move(*value);
    }
  }
  bool sound() const { return sound_; }
  Shape shape(std::uint32_t name) override { return values_[name].shape(); }
  Array value(std::uint32_t name) override { return values_[name]; }
  const Array* known(std::uint32_t name) override { return &values_[name]; }

 private:
  static std::optional<Array> look_up(Elaboration& e, const BoundExpression& bound, const Expression& node, int depth) {
    const std::string& name = node.parts[0];
    if (node.parts.size() == 1) {
      if (name == "pi") return Array(3.14159265358979323846);
      if (name == "inf") return Array(unbounded);
      if (name == "true" || name == "false") return Array(name == "true" ? 1.0 : 0.0);
      if (name == "index" && bound.copy > 0) return Array(static_cast<double>(bound.copy));
    }
    const GraphScope& scope = e.g.scopes[bound.scope];
    const TypeTable& table = e.table_of(*scope.type);
    const auto found = table.names.find(name);
    if (found == table.names.end() || found->second.kind != TypeName::Kind::parameter) return {};
    const std::uint32_t index = scope.first_parameter + found->second.index;
    if (index >= e.g.parameters.size()) return {};
    const BoundExpression inner = e.g.parameters[index].expression;
    if (!inner || depth >= deepest) return {};
    const std::optional<Array> whole = early_value(e, inner, depth + 1);
    return whole ? part_of(*whole, node) : std::nullopt;
  }

  static std::optional<Array> part_of(const Array& whole, const Expression& node) {
    if (node.parts.size() == 1) return whole;
    const long row = parse_integer(node.parts[1]).value_or(0);
    const long column = node.parts.size() == 3 ? parse_integer(node.parts[2]).value_or(0) : 0;
    const bool matrix = whole.shape().rank == 2;
    if (node.parts.size() > 3 || node.slice_end != 0 || row < 1 || row > whole.rows() ||
        matrix != (node.parts.size() == 3) || (matrix && (column < 1 || column > whole.columns())))
      return {};
    return element_of(whole, static_cast<int>(row), 0, static_cast<int>(column));
  }

  std::vector<Array> values_;
  bool sound_ = true;
};

std::optional<Array> early_value(Elaboration& e, const BoundExpression& bound, int depth) {
  EarlyNames names(e, bound, depth);
  if (!names.sound() || !shape_of(*bound.code, names, nullptr).is_known()) return {};
  return evaluate(*bound.code, names);
}

// Shares the leaves, so that what one copy uses counts as used.
void lay_over(OverrideNode& under, const OverrideNode& over) {
  if (over.given) under.given = over.given, under.source = over.source;
  for (const auto& [key, child] : over.children) {
    std::shared_ptr<OverrideNode>& place = under.children[key];
    if (!place || child->children.empty()) {
      place = child;
    } else {
      auto both = std::make_shared<OverrideNode>(*place);
      lay_over(*both, *child);
      place = std::move(both);
    }
  }
}

}  // namespace

std::optional<std::uint32_t> count_copies(Elaboration& e, const BlockDecl& decl, std::uint32_t scope) {
  constexpr double most = 1e6;
  const BoundExpression bound = e.bind(decl.repeat, scope);
  if (!bound) return {};
  e.counts.push_back(bound);
  const std::optional<Array> value = early_value(e, bound, 0);
  if (value && value->size() == 1) {
    const double n = (*value)[0].number();
    if (n == std::floor(n) && n >= 1 && n <= most) return static_cast<std::uint32_t>(n);
    e.findings
        .error(decl.repeat->mark, "'repeat' of '{}' is a whole number from 1 to {}, got {}", decl.name,
               static_cast<long>(most), shortest(n))
        .named("repeat");
    return {};
  }
  if (value) {
    e.findings.error(decl.repeat->mark, "'repeat' of '{}' is one number, got {}", decl.name, to_string(value->shape()))
        .named("repeat");
    return {};
  }
  // A name that means nothing is reported with all others.
  const TypeTable& table = e.table_of(*e.g.scopes[scope].type);
  for (const Expression* name : bound.code->names) {
    const auto found = table.names.find(name->parts[0]);
    if (found == table.names.end() || found->second.kind != TypeName::Kind::parameter) return {};
  }
  e.findings
      .error(decl.repeat->mark, "the number of copies of '{}' cannot be worked out: {}", decl.name,
             to_string(*decl.repeat))
      .hint("it depends on numbers and on parameters of the same scope, whose values are known before all others")
      .named("repeat");
  return {};
}

OverrideNode* overrides_of_copy(Elaboration& e, OverrideNode* all, std::uint32_t number) {
  if (!all) return nullptr;
  OverrideNode* one = all->find(std::to_string(number));
  if (!one) return all;
  OverrideNode& both = e.copy_overrides.emplace_back(*all);
  both.given = nullptr;
  lay_over(both, *one);
  return &both;
}

}  // namespace plantloop
