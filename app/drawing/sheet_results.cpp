// What leaves the sheet, and what its wires are called.

#include "app/drawing/sheet_maker.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <utility>

namespace plantloop {

void SheetMaker::mark_results() {
  std::set<std::uint32_t> shown;
  if (scope_ == 0) shown = recorded_nets();
  for (const auto& [net, port] : nets_) {
    const bool recorded = shown.contains(net);
    const auto it = wire_at_.find({port.block, port.port});
    const bool unread = it == wire_at_.end();
    if (unread && (block(port).outputs.size() > 1 ? !recorded : scope_ != 0)) continue;
    if (unread && !recorded && ends_.contains(port.block)) continue;
    SheetWire& wire = wire_from(port);
    if (const auto label = labels_.find(net); label != labels_.end()) wire.label = label->second;
    // What leaves the sheet under the same name needs no second label.
    if (std::any_of(wire.to.begin(), wire.to.end(), [&](const SheetPort& to) {
          return block(to).shape == Shape::output && block(to).formula.text == wire.label;
        }))
      wire.label.clear();
    if (recorded || unread) wire.is_shown = true;
    // At its end a result has its name again, unless the block before says it.
    if (const auto result = results_.find(net); result != results_.end()) {
      wire.result = result->second;
    } else {
      wire.result = wire.label;
    }
    if (options_.sizes && g_.nets[net].shape.is_known() && !g_.nets[net].shape.is_scalar()) {
      const plantloop::Shape s = g_.nets[net].shape;
      wire.note = s.rank == 1 ? fmt::format("({})", s.rows) : fmt::format("({} × {})", s.rows, s.columns);
    }
    if (options_.units && !g_.nets[net].unit.empty())
      wire.note += (wire.note.empty() ? "" : " ") + fmt::format("[{}]", g_.nets[net].unit);
    if (const std::string value = value_of(g_.nets[net]); !value.empty())
      wire.note += (wire.note.empty() ? "" : " ") + value;
  }
}

std::string SheetMaker::value_of(const GraphNet& net) const {
  if (options_.values.empty()) return {};
  const auto find = [&](const std::string& path, std::string_view output) {
    auto found = options_.values.find(fmt::format("{}.{}", path, output));
    if (found == options_.values.end() && net.port == 0) found = options_.values.find(path);
    return found == options_.values.end() ? std::string() : found->second;
  };
  if (net.kind == GraphNet::Kind::scope_output) {
    const GraphScope& scope = g_.scopes[net.owner];
    return find(scope.path, scope.type->outputs[net.port].name);
  }
  if (net.kind != GraphNet::Kind::output && net.kind != GraphNet::Kind::expression) return {};
  const GraphBlock& from = g_.blocks[net.owner];
  return find(from.path, from.type ? from.type->block->outputs_declared[net.port]->name : std::string_view("y"));
}

void SheetMaker::drop_unread_outputs() {
  for (std::size_t i = 0; i < sheet_.blocks.size(); ++i) {
    SheetBlock& b = sheet_.blocks[i];
    if (b.outputs.size() < 2 || b.inside) continue;
    std::vector<std::string> kept;
    std::vector<std::pair<SheetWire*, int>> moves;
    for (std::size_t port = 0; port < b.outputs.size(); ++port) {
      const auto it = wire_at_.find({static_cast<int>(i), static_cast<int>(port)});
      if (it == wire_at_.end()) continue;
      moves.emplace_back(&sheet_.wires[it->second], static_cast<int>(kept.size()));
      kept.push_back(b.outputs[port]);
    }
    if (kept.empty()) kept.emplace_back("");
    for (const auto& [wire, port] : moves) wire->from.port = port;
    b.outputs = std::move(kept);
  }
}

std::set<std::uint32_t> SheetMaker::recorded_nets() const {
  std::set<std::uint32_t> nets;
  const auto take = [&](const Expression* e) {
    const auto at = g_.shown_at.find(e);
    if (at == g_.shown_at.end()) return;
    const BoundExpression& bound = g_.shown[at->second].bound;
    if (!bound.code || !bound.code->is_name()) return;
    const Reference& r = g_.references[bound.first_reference];
    if (r.kind == Reference::Kind::net) nets.insert(r.index);
  };
  for (const RecordDecl& r : g_.model->record) take(r.signal.get());
  if (nets.empty())
    for (const FigureDecl& f : g_.model->figures)
      for (const ExpressionPtr& s : f.signals()) take(s.get());
  return nets;
}

}  // namespace plantloop
