// A diagram as its author wrote it: names, texts and places, nothing resolved. What the YAML means is checked as far as
// it does not depend on the block types; `graph/` does the rest.

#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/report.h"
#include "engine/diagram/document.h"
#include "engine/diagram/expression.h"
#include "engine/diagram/figure_words.h"

namespace plantloop {

// `Q: 29.46`, `b: {value: 1.21, unit: m, doc: input gain}` or `net: {text: models/a.yaml}`.
struct ParameterDecl {
  std::string name;
  Mark mark;            // of the name
  ExpressionPtr value;  // null for a text, and in a type where each block of the type must give one
  std::optional<std::string> text;
  std::string unit, doc;
  bool bad = false;  // a finding has been reported
};

// A named wire, `u: plant.y`, inside a mapping `in:`.
struct WireDecl {
  std::string port;  // "" when `in:` is a text or a sequence: the block's only port without default
  Mark mark;
  std::vector<ExpressionPtr> items;  // one, or the entries of a sequence
  bool is_sequence = false;
};

// `name: value` of an instance that is none of the reserved keys: a parameter or an input with a default.
struct FieldDecl {
  std::string name;
  Mark mark;
  Node value;
};

// `reset: {when: cond, edge: rising, to: value}`
struct ResetDecl {
  Mark mark;
  ExpressionPtr when;
  std::string edge = "rising";  // rising, falling or either
  ExpressionPtr to;             // null: the initial value
};

// `enable: {when: cond, states: held, outputs: held, initial: 0}`, or only the condition.
struct EnableDecl {
  Mark mark;
  ExpressionPtr when;  // active while greater than 0
  bool resets_states = false, resets_outputs = false;
  ExpressionPtr initial;  // what a block shows before its first activation; null when not given
};

// `trigger: {when: expr, edge: rising, initial: 0}`
struct TriggerDecl {
  Mark mark;
  ExpressionPtr when;
  std::string edge = "rising";  // rising, falling or either
  ExpressionPtr initial;        // as in EnableDecl
};

// `first: {from: left}`: the wires of the first or last copy of a repeated block that stand in place of those of `in:`.
struct EndDecl {
  Mark mark;
  std::vector<WireDecl> wires;
};

// One entry of `blocks:`. A text or a sequence is an expression block: type "expression", one wire.
struct BlockDecl {
  std::string name;
  Mark mark;  // of the name
  std::string type;
  Mark type_mark;
  ExpressionPtr expression;  // of an expression block, else null
  std::vector<WireDecl> in;
  std::vector<FieldDecl> fields;
  ExpressionPtr period, offset;  // of `rate:`, null where not given
  Mark rate_mark;
  std::optional<ResetDecl> reset;
  std::optional<EnableDecl> enable;
  std::optional<TriggerDecl> trigger;
  ExpressionPtr repeat;  // how many copies; null: one that is not numbered
  Mark repeat_mark;
  std::optional<EndDecl> first, last;
  std::string doc, unit, label;
  bool zero_crossing = true;
  int priority = 0;
  bool bad = false;  // a finding has been reported
};

struct InputDecl {
  std::string name;
  Mark mark;
  ExpressionPtr fallback;  // `default:`, null when the input must be wired
  std::optional<int> size;
  std::string unit, doc;
};

struct OutputDecl {
  std::string name;
  Mark mark;
  ExpressionPtr from;     // a name or an expression
  ExpressionPtr initial;  // before the first activation; null when not given
};

struct FileScope;

// What the instance of a state machine says; its type is made from this.
struct StateMachineDecl {
  struct State {
    std::string name;
    Mark mark;
    std::vector<std::pair<std::string, ExpressionPtr>> set;  // outputs and their values while in this state
  };
  struct Transition {
    Mark mark;
    std::size_t from = 0, to = 0;  // into `states`
    ExpressionPtr when;
  };
  std::vector<State> states;  // in the order of the file: the first one has the number 1
  std::vector<Transition> transitions;
  std::size_t initial = 0;  // into `states`
};

// A type, or the diagram itself (which has no inputs and outputs).
struct TypeDecl {
  std::string name;
  Mark mark;
  std::string doc;
  std::vector<ParameterDecl> parameters;
  std::vector<InputDecl> inputs;
  std::vector<OutputDecl> outputs;
  std::vector<BlockDecl> blocks;
  const FileScope* file = nullptr;  // which types its blocks may name
  bool bad = false;                 // a finding has been reported that is not about one of its parameters or blocks
  std::shared_ptr<const StateMachineDecl> machine;  // of a type that stands for a state machine
};

// The types that a file's blocks may name: its own and those of the files that it imports (directly, not through
// others). Keys are as written at the place of use: "pi_loop", "std.pi_loop".
struct FileScope {
  std::string path;
  std::map<std::string, std::shared_ptr<const TypeDecl>> types;
  bool incomplete = false;  // something could not be imported: a type may be missing for that reason
};

struct SimulationDecl {
  Mark mark;
  ExpressionPtr start, stop, step, rtol, atol, max_step, output_interval, event_tol, max_steps, max_rows, seed;
  std::string solver = "dopri5";
  Mark solver_mark;
  std::string zeno = "error";   // error, hold or ignore
  std::string loops = "solve";  // solve or error
  bool strict = false;
};

// A column of the result: `column` is its name, `signal` what it shows.
struct RecordDecl {
  std::string column;
  Mark mark;
  ExpressionPtr signal;
};

struct FigureEntry;

// What is said of a figure or of a part of it, after the tables of engine/diagram/figure_words.h.
struct FigureBlock {
  const FigureWords* words = nullptr;
  Mark mark;
  std::vector<FigureEntry> entries;

  const FigureEntry* find(std::string_view name) const;
  // Of an entry that is not there: empty, false, none.
  std::string text(std::string_view name) const;
  bool flag(std::string_view name) const;
  ExpressionPtr number(std::string_view name) const;
  const std::vector<FigureBlock>& parts(std::string_view name) const;
};

struct FigureEntry {
  const FigureWord* word = nullptr;
  Mark mark;
  std::string text;                    // of a text, a choice, a colour; the label of an axis
  std::vector<std::string> texts;      // of texts
  bool flag = false;                   // of a flag
  std::vector<ExpressionPtr> numbers;  // of numbers, limits, columns, grids (row by row); null: left open
  std::size_t columns = 0;             // of a grid
  ExpressionPtr signal;                // of a signal; of a column or grid that is no list
  std::vector<FigureBlock> parts;      // of signals, axes, lists, plots
};

struct FigureDecl {
  std::string name;
  Mark mark;
  FigureBlock says;

  // Every expression over signals, and every one over parameters, wherever it stands.
  std::vector<ExpressionPtr> signals() const;
  std::vector<ExpressionPtr> numbers() const;
};

// One entry of `expect:`, as FORMAT.md defines it.
struct ExpectDecl {
  Mark mark;
  std::string text;      // the entry again, for the verdict's line
  ExpressionPtr signal;  // null for an event
  std::string event;     // "h.reset"
  std::string measure;   // "at" or max, min, max_abs, rms, final, overshoot, settling_time, rise_time, count, baseline
  ExpressionPtr at, value, lower, upper;             // `between`; `below` is upper, `above` is lower
  ExpressionPtr abs, rel, shift, from, until, band;  // shift: of time in s, for baselines
  ExpressionPtr step_at, step_until, step_from, step_to;
  std::string side = "right";
  std::string baseline;
};

struct Model {
  std::string path;     // of the file
  std::string project;  // the folder inside which files may be read
  std::string title;
  std::shared_ptr<const TypeDecl> top;  // parameters and blocks of the diagram itself
  std::vector<std::shared_ptr<const FileScope>> files;
  SimulationDecl simulation;
  bool has_simulation = false;
  bool is_library = false;  // only types: no blocks, no simulation
  std::vector<RecordDecl> record;
  bool has_record = false;
  std::vector<FigureDecl> figures;
  std::vector<ExpectDecl> expect;
  std::map<std::string, std::string> checks;  // id -> note, warning, error or off
  bool has_errors = false;  // something was reported; elaborate() then looks for more and gives no graph
  bool is_broken = false;   // what was reported leaves nothing sound to look at
  std::vector<std::shared_ptr<const Source>> sources;  // keeps the marks' texts alive
};

// Reads a diagram and what it imports; reports everything that is wrong. Null when the file cannot be read as a diagram
// at all. `plots`: the plot types that figures may use.
std::shared_ptr<const Model> read_model(const std::string& path, Report& report, const PlotWords& plots = no_plots());
// The same for a text in memory; `path` names it in findings and anchors its relative paths.
std::shared_ptr<const Model> read_model_text(const std::string& text, const std::string& path, Report& report,
                                             const PlotWords& plots = no_plots());

}  // namespace plantloop
