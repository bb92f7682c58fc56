// Blocks and subsystems of the diagram whose outputs are for nobody: not read, recorded, drawn or expected.

#include "engine/graph/unused.h"

#include <vector>

namespace plantloop {

void check_unused(const Graph& g, Report& report) {
  if (g.scopes.empty() || !g.model->has_record) return;
  std::vector<std::uint8_t> used(g.nets.size());
  const auto use = [&](const BoundExpression& bound) {
    for (std::size_t i = 0; bound && i < bound.code->names.size(); ++i) {
      const Reference& r = g.references[bound.first_reference + i];
      if (r.kind == Reference::Kind::net) used[r.index] = 1;
    }
  };
  for (const GraphNet& net : g.nets) use(net.driver);
  for (const GraphParameter& p : g.parameters) use(p.expression);
  for (const GraphShown& shown : g.shown) use(shown.bound);
  for (const GraphBlock& block : g.blocks) use(block.reset_when), use(block.reset_to);
  for (const GraphScope& scope : g.scopes) use(scope.reset_when), use(scope.reset_to);
  for (const GraphActivation& a : g.activations) use(a.enable_when), use(a.trigger_when);

  const auto any_used = [&](std::uint32_t first, std::size_t count) {
    bool any = count == 0;  // what has no output is there for something else
    for (std::size_t i = 0; i < count; ++i) any = any || used[first + i] || g.nets[first + i].bad;
    return any;
  };
  std::vector<const BlockDecl*> idle;
  const GraphScope& top = g.scopes[0];
  for (std::size_t i = 0; i < top.type->blocks.size(); ++i) {
    const GraphChild child = g.children[top.first_child + i];
    if (child.kind == GraphChild::Kind::block) {
      const GraphBlock& block = g.blocks[child.index];
      const bool acts = block.type && block.type->group == "run";  // stop, assertion
      if (!acts && !any_used(block.first_output, block.outputs)) idle.push_back(block.declaration);
    } else if (child.kind == GraphChild::Kind::scope) {
      const GraphScope& scope = g.scopes[child.index];
      if (!any_used(scope.first_output, scope.type->outputs.size())) idle.push_back(scope.declaration);
    }
  }
  if (idle.empty()) return;
  constexpr std::size_t most = 8;
  std::string names;
  for (std::size_t i = 0; i < idle.size() && i < most; ++i)
    names += fmt::format("{}'{}'", i > 0 ? ", " : "", idle[i]->name);
  if (idle.size() > most) names += fmt::format(" and {} more", idle.size() - most);
  report.check("unused-output", idle.front()->mark, "nobody reads, records or draws {}", names);
}

}  // namespace plantloop
