// Model -> Graph: the phases in their order.

#include "engine/graph/graph.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "engine/base/numbers.h"
#include "engine/base/text.h"
#include "engine/graph/elaboration.h"

namespace plantloop {

Elaboration::Elaboration(std::shared_ptr<const Model> of, Findings& into)
    : graph(std::make_shared<Graph>()), g(*graph), model(*of), findings(into) {
  graph->model = std::move(of);
  g.rates.resize(1);
}

const TypeTable& Elaboration::table_of(const TypeDecl& type) {
  const auto [it, is_new] = types.try_emplace(&type);
  TypeTable& table = it->second;
  if (!is_new) return table;
  // Of two equal names, which diagram/ has reported, the first one counts.
  table.names.reserve(type.parameters.size() + type.inputs.size() + type.blocks.size());
  std::uint32_t i = 0;
  for (const ParameterDecl& p : type.parameters)
    table.names.try_emplace(p.name, TypeName{TypeName::Kind::parameter, i++});
  i = 0;
  for (const InputDecl& p : type.inputs) table.names.try_emplace(p.name, TypeName{TypeName::Kind::input, i++});
  i = 0;
  for (const BlockDecl& b : type.blocks) table.names.try_emplace(b.name, TypeName{TypeName::Kind::block, i++});
  i = 0;
  for (const OutputDecl& o : type.outputs) table.outputs.try_emplace(o.name, i++);
  return table;
}

const BlockTable& Elaboration::table_of(const BlockType& type) {
  const auto [it, is_new] = blocks.try_emplace(&type);
  BlockTable& table = it->second;
  if (!is_new) return table;
  const Block& kind = *type.block;
  const auto add = [&table](const auto& list, BlockName::Kind what) {
    std::uint32_t i = 0;
    for (const auto* thing : list) table.names.try_emplace(thing->name, BlockName{what, i++});
  };
  add(kind.inputs, BlockName::Kind::input);
  add(kind.lists, BlockName::Kind::list);
  add(kind.numbers, BlockName::Kind::number);
  add(kind.tables, BlockName::Kind::table);
  add(kind.counts, BlockName::Kind::count);
  add(kind.choices, BlockName::Kind::choice);
  add(kind.texts, BlockName::Kind::text);
  std::uint32_t i = 0;
  for (const Output* output : kind.outputs_declared) table.outputs.try_emplace(output->name, i++);
  for (const Number* n : kind.numbers) {
    table.defaults.push_back(std::isnan(n->spec.init) ? nullptr : number_expression(n->spec.init));
  }
  for (const Table* t : kind.tables) {
    table.defaults.push_back(t->spec.init.empty() ? nullptr : parse_expression(t->spec.init, {}, findings.report()));
  }
  for (const Count* c : kind.counts) table.defaults.push_back(number_expression(c->spec.init));
  return table;
}

ExpressionPtr Elaboration::parse(const Node& node) {
  const auto [it, is_new] = parsed.try_emplace(&node);
  if (is_new) it->second = parse_expression(node, findings.report());
  return it->second;
}

BoundExpression Elaboration::bind(const ExpressionPtr& tree, std::uint32_t scope) {
  if (!tree) return {};
  return {.code = g.codes.of(tree), .scope = scope, .mark = tree->mark};
}

std::string title_of(const Graph& graph, const GraphBlock& block) {
  (void)graph;
  return fmt::format("'{}' ({})", block.declaration->name,
                     block.type ? std::string_view(block.type->name) : "an expression");
}

void read_overrides(Elaboration& e, const Overrides& overrides) {
  for (const Override& given : overrides) {
    const Override& kept = e.override_list.emplace_back(given);
    auto source = std::make_shared<Source>();
    source->name = "--set";
    source->text = kept.path + "=" + kept.text;
    e.g.sources.push_back(source);
    e.findings.report().keep(source);
    OverrideNode* node = &e.overrides;
    std::size_t at = 0;
    while (at <= kept.path.size()) {
      const std::size_t dot = std::min(kept.path.find('.', at), kept.path.size());
      std::shared_ptr<OverrideNode>& child = node->children[kept.path.substr(at, dot - at)];
      if (!child) child = std::make_shared<OverrideNode>();
      node = child.get();
      at = dot + 1;
    }
    node->given = &kept;  // of two, the later one holds
    node->source = std::move(source);
    node->used = false;
  }
}

std::string expand_text(Elaboration& e, const std::string& text, std::uint32_t scope, const Mark& mark) {
  if (text.find('$') == std::string::npos) return text;
  std::string result;
  for (std::size_t i = 0; i < text.size();) {
    std::size_t end = i + 1;
    while (end < text.size() && (is_letter(text[end]) || is_digit(text[end]))) ++end;
    if (text[i] != '$' || end == i + 1) {
      result += text[i++];
      continue;
    }
    const std::string name = text.substr(i + 1, end - i - 1);
    i = end;
    const GraphScope& s = e.g.scopes[scope];
    const TypeTable& table = e.table_of(*s.type);
    const auto found = table.names.find(name);
    if (found == table.names.end() || found->second.kind != TypeName::Kind::parameter) {
      std::vector<std::string> names;
      for (const ParameterDecl& p : s.type->parameters) {
        if (p.text) names.push_back(p.name);
      }
      Finding& finding = e.findings.error(mark, "there is no text parameter '{}'", name);
      if (!names.empty()) finding.suggest(name, names);
      continue;
    }
    const std::uint32_t index = s.first_parameter + found->second.index;
    if (index >= e.g.parameters.size() ||
        (e.g.parameters[index].text == nowhere && s.type->parameters[found->second.index].text)) {
      e.findings.error(mark, "'${}' is used before it is declared: texts see those above them", name);
      continue;
    }
    const GraphParameter& p = e.g.parameters[index];
    if (p.text == nowhere) {
      e.findings.error(mark, "'{}' is a number, not a text", name)
          .hint(fmt::format("a text parameter is declared as {}: {{text: ...}}", name));
      continue;
    }
    result += e.g.texts[p.text];
  }
  return result;
}

namespace {

// Overrides that met nothing: what is wrong with their path.
void report_unused(Elaboration& e, const OverrideNode& node, std::uint32_t scope);

void report_path(Elaboration& e, const OverrideNode& node, const std::string& key, std::uint32_t s) {
  const GraphScope& scope = e.g.scopes[s];
  const Mark mark{node.source.get(), 1, 1, static_cast<std::uint32_t>(node.given->path.size())};
  const TypeTable& table = e.table_of(*scope.type);
  const auto found = table.names.find(key);
  std::vector<std::string> names;
  for (const ParameterDecl& p : scope.type->parameters) names.push_back(p.name);
  if (found != table.names.end() && found->second.kind == TypeName::Kind::block) {
    const GraphChild child = e.g.children[scope.first_child + found->second.index];
    std::string example;
    if (child.kind == GraphChild::Kind::block && e.g.blocks[child.index].type) {
      const auto& settable = e.g.blocks[child.index].type->block->settable;
      if (!settable.empty()) example = settable.front();
    } else if (child.kind == GraphChild::Kind::scope && !e.g.scopes[child.index].type->parameters.empty()) {
      example = e.g.scopes[child.index].type->parameters.front().name;
    }
    Finding& finding = e.findings.error(mark, "'{}' is a block, not a parameter", node.given->path);
    finding.named("set");
    if (!example.empty()) finding.hint(fmt::format("its parameters can be set, e.g. {}.{}", node.given->path, example));
    return;
  }
  if (found != table.names.end() && found->second.kind == TypeName::Kind::input) {
    e.findings.error(mark, "'{}' is an input without default: a wire feeds it", node.given->path).named("set");
    return;
  }
  for (const BlockDecl& b : scope.type->blocks) names.push_back(b.name);
  Finding& finding = s == 0
                         ? e.findings.error(mark, "there is no parameter '{}'", key)
                         : e.findings.error(mark, "'{}' ({}) has no parameter '{}'", scope.path, scope.type->name, key);
  finding.suggest(key, names).named("set");
}

void report_block_path(Elaboration& e, const OverrideNode& node, const std::string& key, const GraphBlock& block) {
  const Mark mark{node.source.get(), 1, 1, static_cast<std::uint32_t>(node.given->path.size())};
  if (!block.type) {
    e.findings.error(mark, "'{}' is an expression: it has no parameters", block.path).named("set");
    return;
  }
  const auto& settable = block.type->block->settable;
  if (std::find(settable.begin(), settable.end(), key) != settable.end()) {
    e.findings.error(mark, "'{}' of {} has no part named like that: '{}'", key, title_of(e.g, block), node.given->path)
        .named("set");
    return;
  }
  Finding& finding = e.findings.error(mark, "{} has no parameter '{}'", title_of(e.g, block), key);
  finding.suggest(key, {settable.begin(), settable.end()}).named("set");
}

// Reports every unused override at or below the node by the same sentence maker.
template <typename Say>
void for_unused(const OverrideNode& node, const Say& say) {
  if (node.given && !node.used) say(node);
  for (const auto& [key, child] : node.children) for_unused(*child, say);
}

// What is set below a block's name, of which `child` is the block; `s` is the scope around it.
void report_unused_child(Elaboration& e, const OverrideNode& node, const std::string& name, std::uint32_t s,
                         GraphChild child) {
  if (child.kind == GraphChild::Kind::scope) return report_unused(e, node, child.index);
  for (const auto& [part, below] : node.children) {
    const std::string& parameter = part;
    if (child.kind == GraphChild::Kind::block) {
      for_unused(*below, [&](const OverrideNode& n) { report_block_path(e, n, parameter, e.g.blocks[child.index]); });
    } else if (child.kind == GraphChild::Kind::bus) {
      for_unused(*below, [&](const OverrideNode& n) {
        const Mark mark{n.source.get(), 1, 1, static_cast<std::uint32_t>(n.given->path.size())};
        e.findings.error(mark, "'{}' is a bus: it groups signals and has no parameters", name).named("set");
      });
    } else if (child.kind != GraphChild::Kind::repeat) {
      for_unused(*below, [&](const OverrideNode& n) { report_path(e, n, name, s); });
    }
  }
  if (child.kind != GraphChild::Kind::repeat) return;
  // `cell.3.k` is of one copy, `cell.k` of all: the first one speaks for them.
  const GraphRepeat& repeat = e.g.repeats[child.index];
  OverrideNode of_all;
  for (const auto& [part, below] : node.children) {
    const long number = parse_integer(part).value_or(0);
    if (number >= 1 && number <= static_cast<long>(repeat.count)) {
      const std::uint32_t copy = repeat.first_copy + static_cast<std::uint32_t>(number) - 1;
      report_unused_child(e, *below, name, s, e.g.copies[copy]);
    } else if (is_digit(part[0])) {
      for_unused(*below, [&, wanted = part](const OverrideNode& n) {
        const Mark mark{n.source.get(), 1, 1, static_cast<std::uint32_t>(n.given->path.size())};
        e.findings.error(mark, "there is no copy '{}.{}': '{}' is repeated {} times", name, wanted, name, repeat.count)
            .named("set");
      });
    } else {
      of_all.children.emplace(part, below);
    }
  }
  report_unused_child(e, of_all, name, s, e.g.copies[repeat.first_copy]);
}

void report_unused(Elaboration& e, const OverrideNode& node, std::uint32_t s) {
  const GraphScope& scope = e.g.scopes[s];
  const TypeTable& table = e.table_of(*scope.type);
  for (const auto& [key, child] : node.children) {
    if (child->given && !child->used) report_path(e, *child, key, s);
    if (child->children.empty()) continue;
    const auto found = table.names.find(key);
    GraphChild inner;
    if (found != table.names.end() && found->second.kind == TypeName::Kind::block) {
      inner = e.g.children[scope.first_child + found->second.index];
      if (inner.kind == GraphChild::Kind::bad) continue;
    }
    report_unused_child(e, *child, key, s, inner);
  }
}

void give_order(Graph& g) {
  g.order.resize(g.blocks.size());
  std::iota(g.order.begin(), g.order.end(), 0U);
  std::sort(g.order.begin(), g.order.end(),
            [&g](std::uint32_t a, std::uint32_t b) { return g.blocks[a].path < g.blocks[b].path; });
  g.scope_order.resize(g.scopes.size());
  std::iota(g.scope_order.begin(), g.scope_order.end(), 0U);
  std::sort(g.scope_order.begin(), g.scope_order.end(),
            [&g](std::uint32_t a, std::uint32_t b) { return g.scopes[a].path < g.scopes[b].path; });
}

// ---- what is shown

// Columns that `record:` gives a name of their own: figures and expectations mean them by it.
using NamedColumns = std::unordered_map<std::string_view, const RecordDecl*>;

NamedColumns named_columns(const Model& model) {
  NamedColumns columns;
  for (const RecordDecl& record : model.record) {
    if (!record.signal || record.signal->kind == Expression::Kind::number) continue;
    if (record.signal->kind == Expression::Kind::name && record.column == to_string(*record.signal)) continue;
    columns.emplace(record.column, &record);
  }
  return columns;
}

class Showing {
 public:
  explicit Showing(Elaboration& e) : e_(e), g_(e.g), columns_(named_columns(e.model)) {}

  void run() {
    const Model& m = e_.model;
    for (const RecordDecl& record : m.record) {
      show(record.signal, record.signal);
      const auto at = g_.shown_at.find(record.signal.get());
      if (at != g_.shown_at.end()) g_.columns.push_back({record.column, at->second, nowhere});
    }
    for (const FigureDecl& figure : m.figures) {
      for (const ExpressionPtr& signal : figure.signals()) show(signal, with_columns(signal));
      for (const ExpressionPtr& number : figure.numbers()) numbers({number});
    }
    for (const ExpectDecl& x : m.expect) {
      show(x.signal, with_columns(x.signal));
      numbers({x.at, x.value, x.lower, x.upper, x.abs, x.rel, x.shift, x.from, x.until, x.band, x.step_at, x.step_until,
               x.step_from, x.step_to});
    }
  }

 private:
  // The tree with the names of columns replaced by what they show; the same tree when there are none.
  ExpressionPtr with_columns(const ExpressionPtr& tree) {
    if (!tree || columns_.empty()) return tree;
    if (tree->kind == Expression::Kind::name) return column_of(tree);
    std::shared_ptr<Expression> copy;
    for (std::size_t i = 0; i < tree->arguments.size(); ++i) {
      const ExpressionPtr argument = with_columns(tree->arguments[i]);
      if (argument == tree->arguments[i]) continue;
      if (!copy) copy = std::make_shared<Expression>(*tree);
      copy->arguments[i] = argument;
    }
    return copy ? copy : tree;
  }

  ExpressionPtr column_of(const ExpressionPtr& name) {
    const auto whole = columns_.find(to_string(*name));
    if (whole != columns_.end()) return whole->second->signal;
    const auto found = columns_.find(name->parts.front());
    if (found == columns_.end() || name->parts.size() < 2 || !is_digit(name->parts[1][0])) return name;
    const ExpressionPtr& column = found->second->signal;
    if (column->kind != Expression::Kind::name) return element_of_column(name, column);
    if (column->slice_end != 0) return name;
    auto element = std::make_shared<Expression>(*name);  // `mu.2` of a column `mu`
    element->parts = column->parts;
    element->parts.insert(element->parts.end(), name->parts.begin() + 1, name->parts.end());
    return element;
  }

  // Element i of an expression is its scalar product with a vector of zeros and a one, which records nothing but the
  // element.
  ExpressionPtr element_of_column(const ExpressionPtr& name, const ExpressionPtr& column) {
    const auto known = g_.shown_at.find(column.get());
    const std::optional<long> i = parse_integer(name->parts[1]);
    if (known == g_.shown_at.end() || name->parts.size() != 2 || name->slice_end != 0 || !i) return name;
    const Shape shape = g_.shown[known->second].shape;
    if (shape.rank != 1 || *i < 1 || *i > shape.size()) return name;
    auto unit = std::make_shared<Expression>();
    unit->kind = Expression::Kind::vector;
    unit->mark = name->mark;
    for (int k = 1; k <= shape.size(); ++k) unit->arguments.push_back(number_expression(k == *i ? 1 : 0));
    auto product = std::make_shared<Expression>();
    product->kind = Expression::Kind::call;
    product->text = "dot";
    product->mark = name->mark;
    product->arguments = {unit, column};
    return product;
  }

  void show(const ExpressionPtr& tree, const ExpressionPtr& meant) {
    if (!tree || g_.shown_at.contains(tree.get())) return;
    GraphShown shown;
    shown.expression = tree.get();
    shown.bound = e_.bind(meant, 0);
    if (!resolve(e_, shown.bound, Context::inside)) return;
    const Code& code = *shown.bound.code;
    for (std::size_t i = 0; i < code.names.size(); ++i) {
      const Reference& r = g_.references[shown.bound.first_reference + i];
      if (r.kind == Reference::Kind::net && g_.nets[r.index].bad) return;
      if (r.kind == Reference::Kind::parameter && g_.parameters[r.index].bad) return;
      const Shape whole = r.kind == Reference::Kind::net         ? g_.nets[r.index].shape
                          : r.kind == Reference::Kind::parameter ? g_.parameters[r.index].shape
                                                                 : Shape::unknown();
      if (!r.whole && whole.is_known() && !element_exists(e_.findings, *code.names[i], r, whole)) return;
    }
    if (code.is_name()) {
      const Reference& r = g_.references[shown.bound.first_reference];
      if (r.kind == Reference::Kind::net) shown.unit = g_.nets[r.index].unit;
      if (r.kind == Reference::Kind::parameter) shown.unit = g_.parameters[r.index].unit;
    }
    BoundNames names(g_, shown.bound);
    shown.shape = shape_of(code, names, &e_.findings);
    g_.shown_at.emplace(tree.get(), static_cast<std::uint32_t>(g_.shown.size()));
    g_.shown.push_back(std::move(shown));
  }

  // Numbers over parameters: what is wrong with them is found here, together with everything else.
  void numbers(std::initializer_list<ExpressionPtr> trees) {
    for (const ExpressionPtr& tree : trees) {
      if (!tree) continue;
      BoundExpression bound = e_.bind(tree, 0);
      if (resolve(e_, bound, Context::parameter) && all_exist(bound)) g_.numbers.emplace_back(tree.get(), bound);
    }
  }

  // Whether the elements that an expression over parameters names are there; says of those of sound ones when not.
  bool all_exist(const BoundExpression& bound) {
    const Code& code = *bound.code;
    for (std::size_t i = 0; i < code.names.size(); ++i) {
      const Reference& r = g_.references[bound.first_reference + i];
      if (r.kind != Reference::Kind::parameter) continue;
      const GraphParameter& p = g_.parameters[r.index];
      if (p.bad || !p.shape.is_known()) return false;
      if (!r.whole && !element_exists(e_.findings, *code.names[i], r, p.shape)) return false;
    }
    return true;
  }

  Elaboration& e_;
  Graph& g_;
  NamedColumns columns_;
};

// Without `record:` every output of every top-level block, at most 200 columns.
void show_default(Elaboration& e) {
  constexpr int most = 200;
  Graph& g = e.g;
  if (e.model.has_record || g.scopes.empty()) return;
  int count = 0;
  const auto add = [&](std::uint32_t net) {
    if (g.nets[net].bus != nowhere) return;
    const int size = g.nets[net].shape.is_known() ? g.nets[net].shape.size() : 1;
    g.columns_cut |= count + size > most;
    if (g.columns_cut) return;
    count += size;
    g.columns.push_back({path_of(g, g.nets[net]), nowhere, net});
  };
  const GraphScope& top = g.scopes[0];
  const auto add_child = [&](const GraphChild& child, const auto& again) -> void {
    if (child.kind == GraphChild::Kind::block) {
      for (std::uint32_t k = 0; k < g.blocks[child.index].outputs; ++k) add(g.blocks[child.index].first_output + k);
    } else if (child.kind == GraphChild::Kind::scope) {
      for (std::uint32_t k = 0; k < g.scopes[child.index].type->outputs.size(); ++k)
        add(g.scopes[child.index].first_output + k);
    } else if (child.kind == GraphChild::Kind::repeat) {
      const GraphRepeat& repeat = g.repeats[child.index];
      for (std::uint32_t k = 0; k < repeat.count; ++k) again(g.copies[repeat.first_copy + k], again);
    } else if (child.kind == GraphChild::Kind::bus) {
      const GraphBus& bus = g.buses[child.index];
      for (std::uint32_t k = 0; k < bus.declaration->in.size(); ++k) add(bus.first_member + k);
    }
  };
  for (std::size_t i = 0; i < top.type->blocks.size(); ++i) add_child(g.children[top.first_child + i], add_child);
  if (g.columns_cut) {
    e.findings.check("columns", {}, "only the first {} columns are recorded: name what you want under record:", most);
  }
}

// Periods, stop times and the like come from parameters: a new value of these needs a new compilation.
void mark_simulation(Elaboration& e) {
  const SimulationDecl& s = e.model.simulation;
  for (const ExpressionPtr& tree : {s.start, s.stop, s.step, s.rtol, s.atol, s.max_step, s.output_interval, s.event_tol,
                                    s.max_steps, s.max_rows, s.seed}) {
    if (!tree) continue;
    BoundExpression bound = e.bind(tree, 0);
    if (resolve(e, bound, Context::parameter)) mark_structural(e.g, bound, 2);
  }
}

// ---- resets

// `reset:` needs states, `to:` exactly one of them, and without `to:` an initial value that is known at any time.
class Resets {
 public:
  explicit Resets(Elaboration& e) : e_(e), g_(e.g) {}

  void run() {
    for (const GraphBlock& block : g_.blocks) {
      if (block.reset_when && block.type) check(*block.declaration, title_of(g_, block), {&block}, block.common);
    }
    for (std::uint32_t s = 0; s < g_.scopes.size(); ++s) {
      const GraphScope& scope = g_.scopes[s];
      if (!scope.reset_when) continue;
      std::vector<const GraphBlock*> inside;
      for (const GraphBlock& block : g_.blocks) {
        std::uint32_t up = block.scope;
        while (up != nowhere && up != s) up = g_.scopes[up].parent;
        if (up == s && block.type) inside.push_back(&block);
      }
      check(*scope.declaration, fmt::format("'{}' ({})", scope.declaration->name, scope.type->name), inside,
            Shape::scalar());
    }
  }

 private:
  void check(const BlockDecl& decl, const std::string& title, const std::vector<const GraphBlock*>& blocks,
             const Shape& common) {
    std::size_t states = 0;
    const GraphParameter* signals = nullptr;
    for (const GraphBlock* block : blocks) {
      const Block& kind = *block->type->block;
      states += kind.states.size() + kind.discretes.size();
      if (kind.states.empty() && kind.discretes.empty()) continue;
      for (std::size_t i = 0; i < kind.numbers.size() + kind.tables.size(); ++i) {
        const GraphParameter& p = g_.parameters[block->first_parameter + i];
        if (p.reads_signals && !p.bad) signals = &p;
      }
    }
    const ResetDecl& reset = *decl.reset;
    if (states == 0) {
      e_.findings.error(reset.mark, "{} has no state that could be reset", title).named("reset");
    } else if (reset.to && states > 1) {
      e_.findings
          .error(reset.mark, "{} has {} states: `to:` is for one, without it each goes to its initial value", title,
                 states)
          .named("reset");
    } else if (!reset.to && signals) {
      e_.findings
          .error(reset.mark, "{}: '{}' reads signals, so there is no value to reset to", title, path_of(g_, *signals))
          .hint("say it: reset: {when: ..., to: ...}")
          .named("reset");
    }
    check_shape(blocks.size() == 1 ? blocks[0]->reset_when : BoundExpression(), reset, title, common);
  }

  // One condition, or one for each element of the state.
  void check_shape(const BoundExpression& when, const ResetDecl& reset, const std::string& title, const Shape& common) {
    if (!when) return;
    BoundNames names(g_, when);
    const Shape shape = shape_of(*when.code, names, nullptr);
    if (!shape.is_known() || shape.is_scalar() || shape == common) return;
    e_.findings
        .error(reset.mark, "{}: the condition is {}, the state is {}", title, to_string(shape), to_string(common))
        .named("reset");
  }

  Elaboration& e_;
  Graph& g_;
};

// What is wrong with the types of this file that nothing uses; of a library these are all.
void check_unused_types(Elaboration& e) {
  const FileScope* file = e.model.top->file;
  if (!file) return;
  std::vector<const TypeDecl*> unused;
  for (const auto& [name, type] : file->types) {
    if (type->file == file && !type->bad && !e.types.contains(type.get())) unused.push_back(type.get());
  }
  if (unused.empty()) return;
  TypeDecl diagram;
  diagram.file = file;
  Elaboration alone(e.graph->model, e.findings);
  alone.parsed = e.parsed;
  instantiate_types(alone, diagram, unused);
  give_order(alone.g);
  resolve_names(alone);
  evaluate_parameters(alone);
  find_sizes(alone);
  Resets(alone).run();
  check_activations(alone);
  check_state_machines(alone);
}

}  // namespace

std::shared_ptr<const Graph> elaborate(std::shared_ptr<const Model> model, const Overrides& overrides, Report& report) {
  if (!model || !model->top || model->is_broken) return nullptr;
  Findings findings(report);
  Elaboration e(std::move(model), findings);
  read_overrides(e, overrides);
  instantiate(e);
  report_unused(e, e.overrides, 0);
  give_order(e.g);
  resolve_names(e);
  mark_simulation(e);
  evaluate_parameters(e);
  find_sizes(e);
  Resets(e).run();
  check_activations(e);
  check_state_machines(e);
  find_rates(e);
  Showing(e).run();
  show_default(e);
  check_unused_types(e);
  if (e.findings.failed() || e.model.has_errors) return nullptr;
  return e.graph;
}

std::string path_of(const Graph& graph, const GraphNet& net) {
  const auto join = [](const std::string& path, std::string_view name) {
    std::string joined;
    joined.reserve(path.size() + name.size() + 1);
    joined += path;
    if (!path.empty()) joined += '.';
    joined += name;
    return joined;
  };
  switch (net.kind) {
    case GraphNet::Kind::expression:
      return graph.blocks[net.owner].path;
    case GraphNet::Kind::output: {
      const GraphBlock& block = graph.blocks[net.owner];
      if (block.outputs == 1) return block.path;
      return join(block.path, block.type->block->outputs_declared[net.port]->name);
    }
    case GraphNet::Kind::block_input: {
      const GraphBlock& block = graph.blocks[net.owner];
      const Block& kind = *block.type->block;
      if (kind.lists.empty()) return join(block.path, kind.inputs[net.port]->name);
      const std::string path = join(block.path, kind.lists[0]->name);
      return block.reduces ? path : fmt::format("{}.{}", path, net.port + 1);
    }
    case GraphNet::Kind::scope_input:
      return join(graph.scopes[net.owner].path, graph.scopes[net.owner].type->inputs[net.port].name);
    case GraphNet::Kind::scope_output:
      return join(graph.scopes[net.owner].path, graph.scopes[net.owner].type->outputs[net.port].name);
    case GraphNet::Kind::copies:
      return graph.repeats[net.owner].path;
    case GraphNet::Kind::member:
      return join(graph.buses[net.owner].path, graph.buses[net.owner].declaration->in[net.port].port);
  }
  return {};
}

std::string path_of(const Graph& graph, const GraphParameter& parameter) {
  const std::string& path =
      parameter.of_scope ? graph.scopes[parameter.owner].path : graph.blocks[parameter.owner].path;
  std::string joined;
  joined.reserve(path.size() + parameter.name.size() + 1);
  joined += path;
  if (!path.empty()) joined += '.';
  joined += parameter.name;
  return joined;
}

}  // namespace plantloop
