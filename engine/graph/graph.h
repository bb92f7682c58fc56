// A diagram with everything resolved: which blocks there are, what drives what, of which size and at which rate.
//
//   Report report;
//   auto model = read_model("car.yaml", report);
//   auto graph = elaborate(model, {{"controller.ki", "20"}}, report);   // null when something is wrong
//   RecordedGraph recorded = record(*graph);                            // engine/graph/record.h
//
// Terms. A *scope* is the diagram itself (scope 0) or one instance of a subsystem type. A *block* is an instance of a
// block type, or an expression block (`type` is null). A *net* is what a name of a signal means: an output of a block,
// an input of a block or scope, an output of a scope. Nets are driven by a block's equations, by an expression, or by a
// parameter. Indices into the vectors of Graph are stable; `order` lists the blocks by the rank of their full path in
// byte order (S5).

#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "engine/base/rational.h"
#include "engine/base/report.h"
#include "engine/diagram/model.h"

#include "engine/block.h"
#include "engine/graph/code.h"
#include "engine/program/value.h"

namespace plantloop {

// `--set path=expression`: replaces the text of a parameter before anything is evaluated.
struct Override {
  std::string path;  // "Q", "theta.initial", "loop.controller.ki"
  std::string text;
};
using Overrides = std::vector<Override>;

inline constexpr std::uint32_t nowhere = 0xffffffff;

// What a name in an expression means at its place of use.
struct Reference {
  enum class Kind : std::uint8_t { missing, number, time, parameter, net, elapsed };
  Kind kind = Kind::missing;
  bool whole = true;        // no element, no slice
  std::uint32_t index = 0;  // of the parameter or net; of `elapsed`: into Graph::activations
  std::int32_t first = 0;   // element or first row, from 1; 0: all
  std::int32_t last = 0;    // last element of a slice; 0: no slice
  std::int32_t column = 0;  // second index of a matrix element; 0: none
  double number = 0;        // of kind number: pi, inf, true, false
};

// An expression at its place of use: its code and what its names mean there.
struct BoundExpression {
  const Code* code = nullptr;         // null: none
  std::uint32_t first_reference = 0;  // of code->names.size() references
  std::uint32_t scope = 0;            // where its names were looked up
  std::uint32_t repeat = nowhere;     // of a copy of a repeated block: into Graph::repeats
  std::uint32_t copy = 0;             // and which one, from 1
  Mark mark;
  explicit operator bool() const { return code != nullptr; }
};

// A number, vector or matrix that a diagram may set: of a scope, of a block, or the value of an unwired input.
struct GraphParameter {
  enum class Context : std::uint8_t { parameter, initial };
  std::string_view name;
  std::uint32_t owner = 0;  // block or scope
  bool of_scope = false;
  bool is_set = true;          // false: optional and not given
  bool literal = false;        // every element is a tunable leaf of its own
  bool reads_signals = false;  // an `initial` that reads signals: it has no value before the run starts
  bool bad = false;            // a finding has been reported
  bool is_default = false;     // the declaration's default holds
  // What a changed value asks for: 0 nothing, 1 a new compilation when an element becomes or leaves zero, 2 a new
  // compilation.
  std::uint8_t structural = 0;
  BoundExpression expression;
  Shape shape = Shape::unknown();
  Array value;  // at compile time; when not `reads_signals`
  std::string_view unit;
  double min = -unbounded, max = unbounded, above = -unbounded;
  bool ascending = false;
  Mark mark;                     // where it was set, or the block's name for a default
  std::uint32_t text = nowhere;  // of a parameter declared {text: ...}: into Graph::texts
};

struct GraphRate {
  enum class Kind : std::uint8_t { constant, discrete, continuous };  // in rising order
  Kind kind = Kind::constant;
  std::uint16_t index = 0;  // of discrete rates: into Graph::rates
  friend bool operator==(const GraphRate&, const GraphRate&) = default;
};
struct ClockRate {
  Rational period, offset;    // s
  Mark mark;                  // where it was first stated
  std::uint32_t trigger = 0;  // it has hits when this activation is triggered, and no period; 0: a clock
};

struct GraphChild {
  enum class Kind : std::uint8_t { bad, block, scope, repeat, bus };
  Kind kind = Kind::bad;
  std::uint32_t index = 0;
};

// A block or subsystem with `enable:` or `trigger:`, and all that is inside.
struct GraphActivation {
  std::string path;
  const BlockDecl* declaration = nullptr;
  std::uint32_t parent = 0;  // the one around it; 0: none
  std::uint32_t scope = 0;   // where its conditions stand
  GraphChild owner;
  BoundExpression enable_when, trigger_when;
  std::vector<BoundExpression> initials;  // by output: what it shows before the first activation
  std::uint16_t rate = 0;                 // of a trigger: into Graph::rates
  bool resets_outputs() const { return declaration->enable && declaration->enable->resets_outputs; }
  bool resets_states() const { return declaration->enable && declaration->enable->resets_states; }
};

struct GraphNet {
  // `copies` is the vector of main outputs of a repeated block, `member` one signal of a bus.
  enum class Kind : std::uint8_t { output, block_input, scope_input, scope_output, expression, copies, member };
  Kind kind = Kind::output;
  bool bad = false;
  bool by_parameter = false;    // an unwired input with a default, or one set like a parameter
  bool is_connected = true;     // false: an unwired input with its declared default
  std::uint32_t owner = 0;      // block, scope, repeat or bus
  std::uint32_t port = 0;       // which of its inputs or outputs
  std::uint32_t parameter = 0;  // when by_parameter
  std::uint32_t bus = nowhere;  // stands for a whole bus: only its members are signals
  BoundExpression driver;       // when not an output of a block
  Shape shape = Shape::unknown();
  GraphRate rate;
  Mark mark;
  std::string_view unit;
};

struct GraphBlock {
  std::string path;
  const BlockDecl* declaration = nullptr;
  const BlockType* type = nullptr;  // null: an expression block
  std::uint32_t scope = 0;
  std::uint32_t activation = 0;   // that it runs under: its own, or that of the scope; 0: always
  std::uint32_t first_input = 0;  // nets; `inputs` of them, for a list port one per entry
  std::uint32_t inputs = 0;
  std::uint32_t first_output = 0;  // nets
  std::uint32_t outputs = 0;
  std::uint32_t first_parameter = 0;  // numbers, then tables, then counts, in order of declaration
  std::uint32_t first_text = 0;       // choices, then texts
  std::uint32_t first_shape = 0;      // of states, then discretes: into Graph::state_shapes
  bool reduces = false;               // the list port was given one entry that is no sequence
  bool bad = false;
  GraphRate rate;
  std::string_view
      rate_reason;  // for explain: "stated", "of the subsystem", "from its inputs", "from its readers", ...
  Shape common = Shape::unknown();  // of what is declared elementwise
  BoundExpression reset_when, reset_to;
};

// A block with `repeat: n`: its copies stand next to each other among the children.
struct GraphRepeat {
  std::string path;
  const BlockDecl* declaration = nullptr;
  std::uint32_t scope = 0;
  std::uint32_t first_copy = 0;  // into Graph::copies
  std::uint32_t count = 0;
  std::uint32_t net = nowhere;  // the vector of main outputs; nowhere: it has none
};

// `{type: bus, in: {ax: ..., ay: ...}}`: names for signals.
struct GraphBus {
  std::string path;
  const BlockDecl* declaration = nullptr;
  std::uint32_t scope = 0;
  std::uint32_t first_member = 0;  // nets, as declaration->in
};

struct GraphScope {
  std::string path;  // "" for the diagram
  const TypeDecl* type = nullptr;
  const BlockDecl* declaration = nullptr;  // null for the diagram
  std::uint32_t parent = nowhere;
  std::uint32_t depth = 0;
  std::uint32_t first_parameter = 0;  // as type->parameters
  std::uint32_t first_input = 0;      // nets, as type->inputs
  std::uint32_t first_output = 0;     // nets, as type->outputs
  std::uint32_t first_child = 0;      // as type->blocks
  bool plain = false;                 // zero_crossing: off, here or above
  std::uint16_t rate = 0;             // stated here or above; 0: none. Index into Graph::rates
  std::uint32_t activation = 0;       // what all inside runs under
  BoundExpression reset_when, reset_to;
};

// An expression of `record`, `figures`, `expect`: it may reach inside subsystems.
struct GraphShown {
  const Expression* expression = nullptr;
  BoundExpression bound;
  Shape shape;
  GraphRate rate;
  std::string unit;  // of a plain name
};

struct Graph {
  std::shared_ptr<const Model> model;
  std::vector<std::shared_ptr<const Source>> sources;  // of the overrides
  std::vector<std::shared_ptr<const void>> made;       // declarations that stand for state machines
  CodeCache codes;
  std::vector<GraphScope> scopes;
  std::vector<GraphChild> children;
  std::vector<GraphChild> copies;
  std::vector<GraphRepeat> repeats;
  std::vector<GraphBus> buses;
  std::vector<GraphActivation> activations{1};  // 0 is unused; those around others come first
  std::vector<GraphBlock> blocks;
  std::vector<GraphNet> nets;
  std::vector<GraphParameter> parameters;
  std::vector<Reference> references;
  std::vector<std::string> texts;
  std::vector<Shape> state_shapes;
  std::vector<ClockRate> rates;            // 0 is unused
  std::vector<std::uint32_t> order;        // of blocks
  std::vector<std::uint32_t> scope_order;  // of scopes
  std::vector<GraphShown> shown;
  std::unordered_map<const Expression*, std::uint32_t> shown_at;
  // The numbers of `expect` and `figures`: expressions over parameters only.
  std::vector<std::pair<const Expression*, BoundExpression>> numbers;
  // The columns that `record:` names, or every output of every top-level block: name and index into `shown`, or a net.
  struct Column {
    std::string name;
    std::uint32_t shown = nowhere;
    std::uint32_t net = nowhere;
  };
  std::vector<Column> columns;
  bool columns_cut = false;  // there were more than 200 by default
};

// Resolves the model and reports everything that is wrong with it; null when anything was, here or when it was read.
// Parts that are wrong already are left out, and so is what follows from them.
std::shared_ptr<const Graph> elaborate(std::shared_ptr<const Model> model, const Overrides& overrides, Report& report);

// The full path of a net: "plant.ps", "plant.u", "error"; the first output of a block is its bare path.
std::string path_of(const Graph& graph, const GraphNet& net);
std::string path_of(const Graph& graph, const GraphParameter& parameter);
// The activation that a net's value belongs to, and whether a reader under `inner` is inside of `outer`.
std::uint32_t activation_of(const Graph& graph, const GraphNet& net);
bool is_within(const Graph& graph, std::uint32_t inner, std::uint32_t outer);

// The value of an expression over the diagram's parameters: numbers in `simulation`, `expect`, `figures`. Nothing after
// reporting.
std::optional<Array> evaluate_number(const Graph& graph, const Expression& expression, Report& report);
// The same for one number; `what` names it in findings: "stop".
std::optional<double> evaluate_scalar(const Graph& graph, const Expression& expression, std::string_view what,
                                      Report& report);

// What a path means, for `explain`, Lua and --set: a net, a parameter, a block or a scope.
struct Named {
  enum class Kind : std::uint8_t { nothing, net, parameter, block, scope };
  Kind kind = Kind::nothing;
  std::uint32_t index = 0;
};
Named find_named(const Graph& graph, std::string_view path);

}  // namespace plantloop
