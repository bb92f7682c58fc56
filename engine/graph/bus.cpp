// Buses: names for signals that go together, `meter.ax`. Elaboration only: an expression that reads a member reads what
// feeds it.
//
// A net that hands on a whole bus (an input of a subsystem, an output, a member of another bus) is no signal: it names
// the bus, and its driver becomes a constant that nobody reads.

#include "engine/graph/elaboration.h"

namespace plantloop {
namespace {

class BusFinding {
 public:
  explicit BusFinding(Elaboration& e) : e_(e), g_(e.g), open_(e.g.nets.size(), 0) {}

  void run() {
    if (g_.buses.empty()) return;
    for (std::uint32_t i = 0; i < g_.nets.size(); ++i) {
      if (is_bearer(g_.nets[i])) bus_of_net(i, 0);
    }
    visited_.assign(g_.buses.size(), 0);
    for (std::uint32_t b = 0; b < g_.buses.size(); ++b) visit(b);
    const ExpressionPtr nothing = number_expression(0);
    for (GraphNet& net : g_.nets) {
      if (net.bus == nowhere) continue;
      const Mark mark = net.driver.mark;
      net.driver = e_.bind(nothing, net.driver.scope);
      net.driver.mark = mark;
    }
  }

 private:
  // Groups that contain themselves, reported once.
  void visit(std::uint32_t bus) {
    if (visited_[bus] != 0) return;
    visited_[bus] = 1;
    chain_.push_back(bus);
    for (std::uint32_t i = 0; i < g_.buses[bus].declaration->in.size(); ++i) {
      const std::uint32_t inner = g_.nets[g_.buses[bus].first_member + i].bus;
      if (inner == nowhere) continue;
      if (visited_[inner] == 1) report_chain(inner);
      visit(inner);
    }
    chain_.pop_back();
    visited_[bus] = 2;
  }

  void report_chain(std::uint32_t from) {
    std::string text;
    bool inside = false;
    for (const std::uint32_t bus : chain_) {
      inside = inside || bus == from;
      if (inside) text += g_.buses[bus].path + " -> ";
    }
    const GraphBus& bus = g_.buses[from];
    e_.findings.error(bus.declaration->mark, "the bus '{}' contains itself: {}{}", bus.path, text, bus.path)
        .named("bus");
  }

  static bool is_bearer(const GraphNet& net) {
    const bool can = net.kind == GraphNet::Kind::scope_input || net.kind == GraphNet::Kind::scope_output ||
                     net.kind == GraphNet::Kind::member;
    return can && net.driver && net.driver.code->is_name();
  }

  std::uint32_t bus_of_net(std::uint32_t index, int depth) {
    GraphNet& net = g_.nets[index];
    if (net.bus != nowhere || !is_bearer(net)) return net.bus;
    if (open_[index] || depth > 1000) {
      if (open_[index] == 1) {
        e_.findings.error(net.mark, "the bus '{}' contains itself", path_of(g_, net)).named("bus");
        net.bad = true;
      }
      return nowhere;
    }
    open_[index] = 1;
    const std::uint32_t bus = bus_of_name(net.driver, depth + 1);
    open_[index] = 2;
    return g_.nets[index].bus = bus;
  }

  // What a name means, as far as it is a bus.
  std::uint32_t bus_of_name(const BoundExpression& bound, int depth) {
    const std::vector<std::string>& parts = bound.code->names[0]->parts;
    std::uint32_t bus = nowhere;
    const GraphScope& scope = g_.scopes[bound.scope];
    std::size_t at = 1;
    const TypeTable& table = e_.table_of(*scope.type);
    const auto found = table.names.find(parts[0]);
    if (found == table.names.end()) return nowhere;
    if (found->second.kind == TypeName::Kind::input) {
      bus = bus_of_net(scope.first_input + found->second.index, depth);
    } else if (found->second.kind == TypeName::Kind::block) {
      const GraphChild child = g_.children[scope.first_child + found->second.index];
      if (child.kind == GraphChild::Kind::bus) bus = child.index;
      if (child.kind == GraphChild::Kind::scope && !g_.scopes[child.index].type->outputs.empty()) {
        const GraphScope& inner = g_.scopes[child.index];
        std::uint32_t output = 0;
        if (parts.size() > 1) {
          const auto named = e_.table_of(*inner.type).outputs.find(parts[1]);
          if (named == e_.table_of(*inner.type).outputs.end()) return nowhere;
          output = named->second;
          at = 2;
        }
        bus = bus_of_net(inner.first_output + output, depth);
      }
    }
    for (; bus != nowhere && at < parts.size(); ++at) {
      const std::vector<WireDecl>& members = g_.buses[bus].declaration->in;
      std::uint32_t inner = nowhere;
      for (std::uint32_t i = 0; i < members.size(); ++i) {
        if (members[i].port == parts[at]) inner = bus_of_net(g_.buses[bus].first_member + i, depth);
      }
      bus = inner;
    }
    return bus;
  }

  Elaboration& e_;
  Graph& g_;
  std::vector<std::uint8_t> open_;     // of nets: 1 being looked at, 2 done
  std::vector<std::uint8_t> visited_;  // the same of buses
  std::vector<std::uint32_t> chain_;
};

}  // namespace

void find_buses(Elaboration& e) { BusFinding(e).run(); }

}  // namespace plantloop
