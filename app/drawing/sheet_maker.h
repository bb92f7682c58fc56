// The making of a sheet from a graph: the state that its steps share. Each group of steps has a file of its own.

#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "app/drawing/formulas.h"
#include "app/drawing/sheets.h"
#include "engine/graph/graph.h"
#include "render/diagram/sheet.h"

namespace plantloop {

class SheetMaker {
 public:
  SheetMaker(const Graph& graph, std::uint32_t scope, const SheetOptions& options)
      : g_(graph), scope_(scope), options_(options) {}

  Sheet run();

 private:
  using Kind = Expression::Kind;
  using Shape = SheetBlock::Shape;
  struct Pending {
    BoundExpression driver;
    SheetPort to;
    std::string path;
  };

  // --- sheets.cpp: ports of the sheet, and wires

  SheetBlock& block(SheetPort port) { return sheet_.blocks[static_cast<std::size_t>(port.block)]; }
  int add(SheetBlock block);
  // What is connected may need further blocks, with inputs of their own.
  void connect_pending();
  void add_inputs(const GraphScope& scope);
  void add_outputs(const GraphScope& scope);
  SheetWire& wire_from(SheetPort from);
  void connect(const BoundExpression& driver, SheetPort to, const std::string& path);
  // What the names of an expression mean where it stands.
  void bind(const BoundExpression& bound);
  const Reference* meaning(const Expression& name) const;
  bool reads_signals(const BoundExpression& bound);
  bool reads_signals(const Expression& e) const;
  bool reads_nets(const Expression& e) const;
  // The port that gives a net; what an expression block computes is built when it is first asked for.
  SheetPort source_of(std::uint32_t net);
  // For a net that reaches here from elsewhere, and for circles of names.
  SheetPort placeholder(std::uint32_t net);

  // --- sheet_blocks.cpp: blocks, subsystems, buses and copies

  const std::string& path_of(const GraphChild& child) const;
  static std::string shown_name(const BlockDecl& decl);
  void add_child(const GraphChild& child);
  // A bus is a bar that joins the members, and a box with a member's name where one is read.
  void add_bus(std::uint32_t index);
  // What drives a net: an expression, or a whole bus.
  void feed(std::uint32_t net, SheetPort to, const std::string& path);
  // Where a bus comes from in this sheet: its bar, or the port of a subsystem that stands for it.
  std::optional<SheetPort> bus_port(std::uint32_t bus);
  SheetPort member_port(std::uint32_t net);
  // All copies are one block. It is drawn as one in the middle is connected, to others of the copies by a wire that
  // leads back to it; what the two ends get instead has inputs of its own.
  void add_repeated(const GraphRepeat& repeat);
  std::uint32_t first_output(const GraphChild& child) const;
  // The outputs of a copy are those of the one that is shown; its inputs, too, but for those wired in another way.
  void add_ends(const GraphChild& copy, const GraphChild& shown, int index, const std::set<std::uint32_t>& recorded);
  static std::string_view input_name(const GraphBlock& block, std::uint32_t input);
  int add_repeated_expression(const GraphBlock& from, const GraphRepeat& repeat);
  // The condition under which a block or subsystem runs.
  void add_conditions(GraphChild::Kind kind, std::uint32_t child, int index);
  // At the top of the block, where there is one only.
  void add_condition(const BoundExpression& when, const std::string& name, int index);
  int add_block(std::uint32_t block_index);
  // Inputs that no signal feeds are parameters in the picture.
  void drop_unfed_inputs(const GraphBlock& from, SheetBlock& b);
  void add_reset(const BoundExpression& when, const BoundExpression& to, int index, const std::string& path);
  std::string rate_text(GraphRate rate) const;
  // The states in the order of the file, each with where it leads.
  static Formula face_of(const StateMachineDecl& machine);
  int add_subsystem(std::uint32_t s);

  // --- sheet_expressions.cpp: what a wire computes

  SheetPort build(const Expression& e, const std::string& path);
  SheetPort terminal(Formula formula, const std::string& path);
  SheetPort build_name(const Expression& e, const std::string& path);
  SheetPort build_sum(const Expression& e, const std::string& path);
  // Constant factors as a gain, signals as a circle; nothing when a quotient of signals is better read as a formula.
  std::optional<SheetPort> build_product(const Expression& e, const std::string& path);
  SheetPort build_vector(const Expression& e, const std::string& path);
  // The whole expression as a formula over the signals that it reads.
  SheetPort build_box(const Expression& e, const std::string& path, bool later = false);
  std::optional<Formula> element_of(const Expression& name, bool) const;
  void collect(const Expression& e, std::vector<std::uint32_t>& read, std::map<std::uint32_t, std::string>& text) const;

  // --- sheet_results.cpp: what leaves the sheet, and what its wires are called

  void mark_results();
  // By the paths that a recording may have for the signal: plant.y, and plant for its main output.
  std::string value_of(const GraphNet& net) const;
  // Of a block with several outputs only those are drawn that something reads.
  void drop_unread_outputs();
  // Signals that `record:`, or else `figures:`, names.
  std::set<std::uint32_t> recorded_nets() const;

  const Graph& g_;
  const std::uint32_t scope_;
  const SheetOptions options_;
  Sheet sheet_;
  std::vector<Pending> pending_;
  std::vector<std::pair<std::uint32_t, SheetPort>> unwired_;  // nets, and the inputs that wait for them
  std::set<int> ends_;                                        // blocks that act on the run, not on the diagram
  std::vector<std::uint32_t> named_, fed_;
  std::map<std::uint32_t, const BlockDecl*> names_;             // expression blocks by their nets
  std::map<std::uint32_t, SheetPort> sources_;                  // of every net that has been drawn
  std::map<std::uint32_t, SheetPort> buses_;                    // the bars of buses
  std::vector<std::pair<std::uint32_t, SheetPort>> bus_reads_;  // buses, and the inputs that wait for them
  std::map<std::uint32_t, SheetPort> nets_;                     // the net that gives a port its names
  std::map<std::uint32_t, std::string> labels_, results_;
  std::set<std::pair<int, int>> labels_of_port_;
  std::set<std::uint32_t> building_;
  std::map<std::pair<int, int>, std::size_t> wire_at_;
  std::unordered_map<const Expression*, Reference> meaning_;
};

}  // namespace plantloop
