// Conditional subsystems: who runs under which condition, and what is wrong with `enable:` and `trigger:`.

#include "engine/graph/elaboration.h"

namespace plantloop {

std::uint32_t activation_of(const Graph& graph, const GraphNet& net) {
  switch (net.kind) {
    case GraphNet::Kind::output:
    case GraphNet::Kind::expression:
    case GraphNet::Kind::block_input:
      return graph.blocks[net.owner].activation;
    case GraphNet::Kind::scope_input:
    case GraphNet::Kind::scope_output:
      return graph.scopes[net.owner].activation;
    case GraphNet::Kind::copies:
      return graph.scopes[graph.repeats[net.owner].scope].activation;
    case GraphNet::Kind::member:
      return graph.scopes[graph.buses[net.owner].scope].activation;
  }
  return 0;
}

bool is_within(const Graph& graph, std::uint32_t inner, std::uint32_t outer) {
  while (inner != outer && inner != 0) inner = graph.activations[inner].parent;
  return inner == outer;
}

namespace {

class ActivationChecks {
 public:
  explicit ActivationChecks(Elaboration& e) : e_(e), g_(e.g) {}

  void run() {
    for (std::size_t a = 1; a < g_.activations.size(); ++a) {
      const GraphActivation& activation = g_.activations[a];
      if (activation.owner.kind == GraphChild::Kind::scope) {
        check_scope(activation);
      } else {
        check_block(activation, g_.blocks[activation.owner.index]);
      }
      if (activation.resets_states()) check_states(static_cast<std::uint32_t>(a));
    }
    for (const GraphBlock& block : g_.blocks) {
      if (block.type && block.type->name == "merge") check_merge(block);
    }
  }

 private:
  void check_scope(const GraphActivation& activation) {
    const GraphScope& scope = g_.scopes[activation.owner.index];
    const BlockDecl& decl = *activation.declaration;
    for (const ExpressionPtr& initial :
         {decl.enable ? decl.enable->initial : nullptr, decl.trigger ? decl.trigger->initial : nullptr}) {
      if (!initial) continue;
      e_.findings
          .error(initial->mark, "'{}' ({}) is a subsystem: its outputs say what they are before the first activation",
                 scope.path, scope.type->name)
          .hint("write in the type, outputs: {y: {from: y, initial: 0}}")
          .named("activation");
    }
    for (std::uint32_t i = 0; i < scope.type->outputs.size(); ++i) {
      const OutputDecl& output = scope.type->outputs[i];
      const GraphNet& net = g_.nets[scope.first_output + i];
      if (net.bus != nowhere) {
        e_.findings
            .error(output.mark, "the output '{}' of '{}' is a bus: what is enabled or triggered has single outputs",
                   output.name, scope.path)
            .named("activation");
      } else if (!output.initial) {
        e_.findings
            .error(output.mark, "the output '{}' of '{}' has no value before the first activation", output.name,
                   scope.path)
            .also(decl.enable ? decl.enable->mark : decl.trigger->mark,
                  fmt::format("'{}' is not always active", scope.path))
            .hint(fmt::format("write outputs: {{{}: {{from: {}, initial: 0}}}}", output.name,
                              output.from ? to_string(*output.from) : output.name))
            .named("activation");
      } else {
        check_shape(activation, i, net);
      }
    }
  }

  void check_block(const GraphActivation& activation, const GraphBlock& block) {
    const BlockDecl& decl = *activation.declaration;
    const bool has_states = block.type && (!block.type->block->states.empty() || !block.type->block->discretes.empty());
    for (std::uint32_t i = 0; i < block.outputs; ++i) {
      if (activation.initials[i]) {
        check_shape(activation, i, g_.nets[block.first_output + i]);
      } else if (!has_states) {
        e_.findings
            .error(decl.enable ? decl.enable->mark : decl.trigger->mark, "{} has no value before its first activation",
                   title_of(g_, block))
            .hint(decl.enable ? "write enable: {when: ..., initial: 0}" : "write trigger: {when: ..., initial: 0}")
            .named("activation");
        return;
      }
    }
  }

  void check_shape(const GraphActivation& activation, std::uint32_t output, const GraphNet& net) {
    const BoundExpression& initial = activation.initials[output];
    BoundNames names(g_, initial);
    const Shape shape = shape_of(*initial.code, names, nullptr);
    if (!shape.is_known() || !net.shape.is_known() || shape.size() == 1 || shape == net.shape) return;
    e_.findings
        .error(initial.mark, "'{}' is {}, its value before the first activation is {}", path_of(g_, net),
               to_string(net.shape), to_string(shape))
        .named("sizes");
  }

  // What writes one signal together must be conditional.
  void check_merge(const GraphBlock& block) {
    for (std::uint32_t i = 0; i < block.inputs; ++i) {
      const GraphNet& net = g_.nets[block.first_input + i];
      if (net.bad) continue;
      const std::string entry = to_string(*net.driver.code->tree);
      const Reference* writer = net.driver.code->is_name() ? &g_.references[net.driver.first_reference] : nullptr;
      if (!writer || writer->kind != Reference::Kind::net) {
        e_.findings
            .error(net.mark, "{} takes outputs of conditional blocks by their names, not '{}'", title_of(g_, block),
                   entry)
            .hint("write in: [low, high], where low and high are enabled or triggered")
            .named("activation");
      } else if (activation_of(g_, g_.nets[writer->index]) == 0) {
        e_.findings
            .error(net.mark, "'{}' is always active, so {} would never show another entry", entry, title_of(g_, block))
            .hint("give its block an enable: or trigger:")
            .named("activation");
      }
    }
  }

  // Resetting needs values that are known at any time.
  void check_states(std::uint32_t a) {
    for (const GraphBlock& block : g_.blocks) {
      if (!block.type || !is_within(g_, block.activation, a)) continue;
      const Block& kind = *block.type->block;
      if (kind.states.empty() && kind.discretes.empty()) continue;
      for (std::size_t i = 0; i < kind.numbers.size() + kind.tables.size(); ++i) {
        const GraphParameter& p = g_.parameters[block.first_parameter + i];
        if (!p.reads_signals || p.bad) continue;
        e_.findings
            .error(g_.activations[a].declaration->enable->mark,
                   "'{}': '{}' reads signals, so there is no value to reset to", g_.activations[a].path, path_of(g_, p))
            .named("activation");
        return;
      }
    }
  }

  Elaboration& e_;
  Graph& g_;
};

}  // namespace

void check_activations(Elaboration& e) { ActivationChecks(e).run(); }

}  // namespace plantloop
