// One pass in the order of the operations: operands stand before what reads them.

#include "engine/program/affine.h"

#include <algorithm>

namespace plantloop {

namespace {

enum class Form : std::uint8_t { constant, affine, other };

Form form_of(const Operation& o, Form a, Form b, Form c) {
  const Form worst = std::max({a, b, c});
  if (worst == Form::constant) return Form::constant;
  switch (o.op) {
    case Op::copy:
    case Op::neg:
    case Op::add:
    case Op::sub:
      return worst;
    case Op::mul:
      return a == Form::constant || b == Form::constant ? worst : Form::other;
    case Op::div:
      return b == Form::constant ? worst : Form::other;
    case Op::where:
      return a == Form::constant ? worst : Form::other;
    default:
      return Form::other;
  }
}

}  // namespace

bool are_affine(const OperationGraph& graph, const std::vector<std::uint32_t>& roots,
                const std::function<bool(const Operation&)>& is_variable) {
  std::vector<Form> forms(graph.operations.size(), Form::constant);
  const auto worst_of = [&](const std::vector<std::uint32_t>& ids) {
    Form worst = Form::constant;
    for (const std::uint32_t id : ids) worst = std::max(worst, forms[id]);
    return worst;
  };
  for (std::uint32_t id = 0; id < forms.size(); ++id) {
    const Operation& o = graph.operations[id];
    Form& form = forms[id];
    if (is_leaf(o.op)) {
      form = is_variable(o) ? Form::affine : Form::constant;
    } else if (is_compound(o.op)) {
      form = worst_of(graph.operands_of_compound(id)) == Form::constant ? Form::constant : Form::other;
    } else if (is_result(o.op)) {
      form = forms[o.a];
    } else {
      const int arity = arity_of(o.op);
      form = form_of(o, forms[o.a], arity > 1 ? forms[o.b] : Form::constant, arity > 2 ? forms[o.c] : Form::constant);
    }
  }
  return worst_of(roots) != Form::other;
}

}  // namespace plantloop
