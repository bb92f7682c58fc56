// What the phases of elaboration share. Private to engine/graph.

#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "engine/graph/evaluate.h"
#include "engine/graph/findings.h"
#include "engine/graph/graph.h"

namespace plantloop {

// What a name of a type's own scope is.
struct TypeName {
  enum class Kind : std::uint8_t { parameter, input, block };
  Kind kind;
  std::uint32_t index;
};
struct TypeTable {
  std::unordered_map<std::string_view, TypeName> names;
  std::unordered_map<std::string_view, std::uint32_t> outputs;
};

// What a name means in a block's declaration.
struct BlockName {
  enum class Kind : std::uint8_t { input, list, number, table, count, choice, text };
  Kind kind;
  std::uint32_t index;
};
struct BlockTable {
  std::unordered_map<std::string_view, BlockName> names;  // inputs and settable things
  std::unordered_map<std::string_view, std::uint32_t> outputs;
  std::vector<ExpressionPtr> defaults;  // of numbers, tables and counts; null: none
};

// The overrides as a tree by the parts of their paths.
struct OverrideNode {
  std::map<std::string, std::shared_ptr<OverrideNode>, std::less<>> children;  // shared with those of copies
  const Override* given = nullptr;
  std::shared_ptr<const Source> source;  // "theta.initial=1"
  bool used = false;
  OverrideNode* find(std::string_view name) const {
    const auto it = children.find(name);
    return it == children.end() ? nullptr : it->second.get();
  }
};

// Where an expression stands decides what its names may mean.
enum class Context : std::uint8_t {
  wire,       // signals, and parameters of the own scope
  parameter,  // parameters, also those of instances
  initial,    // both
  inside,     // everything, inside subsystems too: record, figures, expect
};

struct Elaboration {
  Elaboration(std::shared_ptr<const Model> of, Findings& into);

  std::shared_ptr<Graph> graph;
  Graph& g;
  const Model& model;
  Findings& findings;
  OverrideNode overrides;
  std::deque<Override> override_list;
  std::unordered_map<const TypeDecl*, TypeTable> types;
  std::unordered_map<const BlockType*, BlockTable> blocks;
  std::unordered_map<const Node*, ExpressionPtr> parsed;
  std::unordered_map<const WireDecl*, ExpressionPtr> joined;
  std::vector<std::uint32_t> parameter_order;                       // dependencies first
  std::vector<OverrideNode*> scope_overrides;                       // by scope; null: none below
  std::set<std::pair<const TypeDecl*, std::string>> unknown_names;  // said already
  std::deque<BlockDecl> made_up;  // instances of types that are looked at on their own
  // Of state machines: the instance of a type that was made from what the instance says; null where that is wrong.
  struct MadeMachine {
    BlockDecl instance;
    std::shared_ptr<const TypeDecl> type;
  };
  std::map<const BlockDecl*, std::shared_ptr<const MadeMachine>> machines;
  std::vector<BoundExpression> counts;      // numbers that the structure was made from, to be resolved
  std::deque<OverrideNode> copy_overrides;  // what is set for all copies and for one of them

  const TypeTable& table_of(const TypeDecl& type);
  const BlockTable& table_of(const BlockType& type);
  ExpressionPtr parse(const Node& node);  // a tree that is read once; null after reporting
  BoundExpression bind(const ExpressionPtr& tree, std::uint32_t scope);
};

// The values and shapes behind the names of a bound expression, as far as they are known while compiling.
class BoundNames final : public Names {
 public:
  BoundNames(const Graph& graph, const BoundExpression& bound) : graph_(graph), bound_(bound) {}
  Shape shape(std::uint32_t name) override;
  Array value(std::uint32_t name) override;
  const Array* known(std::uint32_t name) override;

 private:
  const Reference& reference(std::uint32_t name) const { return graph_.references[bound_.first_reference + name]; }
  const Graph& graph_;
  const BoundExpression& bound_;
  Array held_;
};

// The phases, in their order.
void read_overrides(Elaboration& e, const Overrides& overrides);
void instantiate(Elaboration& e);  // scopes, blocks, nets and parameters, with their expressions bound to scopes
// The same for types that nothing uses, each on its own with its inputs left open: `diagram` is an empty type around
// them.
void instantiate_types(Elaboration& e, const TypeDecl& diagram, std::span<const TypeDecl* const> unused);
void resolve_names(Elaboration& e);  // what every name means
void evaluate_parameters(Elaboration& e);
void find_sizes(Elaboration& e);
void find_rates(Elaboration& e);
void check_activations(Elaboration& e);  // what is wrong with `enable:` and `trigger:`

// How many copies of a block there are: a whole number of parameters around it, which have no values yet. Nothing after
// reporting.
std::optional<std::uint32_t> count_copies(Elaboration& e, const BlockDecl& decl, std::uint32_t scope);
// What is set for copy `number` of a repeated block: `all` with its numbered part on top; null when nothing is.
OverrideNode* overrides_of_copy(Elaboration& e, OverrideNode* all, std::uint32_t number);
// The bus that a net stands for, or nowhere.
void find_buses(Elaboration& e);
// A state machine as an instance of a subsystem: its guards are wires of one block, its outputs expressions over that
// block's state. Null after reporting.
const Elaboration::MadeMachine* make_state_machine(Elaboration& e, const BlockDecl& decl, std::uint32_t scope);
bool is_machine_core(const BlockDecl& decl);  // that block
void check_state_machines(Elaboration& e);    // guards that are no single condition

// Binds the names of one expression; false after reporting that some mean nothing.
bool resolve(Elaboration& e, BoundExpression& bound, Context context);
// Marks a parameter and all that it depends on.
void mark_structural(Graph& graph, std::uint32_t parameter, std::uint8_t level);
void mark_structural(Graph& graph, const BoundExpression& bound, std::uint8_t level);
// Whether an element or slice lies within the shape; reports when not.
bool element_exists(Findings& findings, const Expression& node, const Reference& reference, const Shape& shape);
// A text in which `$name` stands for text parameters of the scope.
std::string expand_text(Elaboration& e, const std::string& text, std::uint32_t scope, const Mark& mark);
// "'theta' (integrator)" for findings.
std::string title_of(const Graph& graph, const GraphBlock& block);

// Which nets and blocks read a net: items below nets.size() are nets, above they are blocks.
struct Readers {
  std::vector<std::uint32_t> first;  // by net, one more at the end
  std::vector<std::uint32_t> items;
  std::span<const std::uint32_t> of(std::uint32_t net) const {
    return std::span(items).subspan(first[net], first[net + 1] - first[net]);
  }
};
Readers find_readers(const Graph& graph);

}  // namespace plantloop
