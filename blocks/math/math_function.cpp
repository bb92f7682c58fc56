// A mathematical function of one or two signals.

#include <string>
#include <string_view>
#include <utility>

#include "engine/block.h"

namespace plantloop {
namespace {

struct MathFunction final : Block {
  static constexpr auto summary = "Apply a mathematical function.";
  static constexpr auto details =
      "y = function(u), element by element; pow, hypot, atan2, mod and rem are functions of u and v, as in v: 2 or in: "
      "{u: ..., v: ...}.  log is natural; exp10 is 10^u; square is u^2; reciprocal is 1/u; round goes away from zero "
      "at halves; mod has the sign of v, rem that of u.";
  static constexpr auto example = R"(
blocks: {y: {type: math_function, in: time, function: square}}
simulation: {stop: 2}
expect: [{signal: y, at: 1.5, value: 2.25}]
)";

  Input u{this, "u", {.doc = "argument"}};
  Input v{this, "v", {.doc = "second argument of pow (the exponent), hypot, atan2, mod and rem", .init = 1}};
  Choice function{
      this,
      "function",
      {.of = {"exp",   "log",  "log2",  "log10", "exp10", "square", "sqrt", "cbrt",  "reciprocal", "abs",  "sign",
              "floor", "ceil", "round", "trunc", "sin",   "cos",    "tan",  "asin",  "acos",       "atan", "sinh",
              "cosh",  "tanh", "asinh", "acosh", "atanh", "erf",    "pow",  "hypot", "atan2",      "mod",  "rem"},
       .doc = "which function"}};
  Output y{this, "y", {.doc = "its value"}};

  void sizes(Sizing& sizing) const override {
    const std::string_view name = function.value();
    const bool two = name == "pow" || name == "hypot" || name == "atan2" || name == "mod" || name == "rem";
    if (two == Now().connected(v)) return;
    if (two)
      return sizing.problem(function, std::string(name) + " needs a second argument: v: 2, or in: {u: ..., v: ...}");
    sizing.problem(v, std::string(name) + " has one argument, u");
  }

  void outputs(Now now, Out out) const override { out[y] = value(function.value(), now[u], now[v]); }

 private:
  static Array value(std::string_view name, const Array& a, const Array& b) {
    if (name == "exp10") return pow(Array(10.0), a);
    if (name == "square") return a * a;
    if (name == "reciprocal") return 1.0 / a;
    if (name == "rem") return a - b * trunc(a / b);
    if (name == "pow") return pow(a, b);
    if (name == "hypot") return hypot(a, b);
    if (name == "atan2") return atan2(a, b);
    if (name == "mod") return mod(a, b);
    using Function = Array (*)(const Array&);
    static const std::pair<std::string_view, Function> functions[] = {
        {"exp", exp},     {"log", log},     {"log2", log2},   {"log10", log10}, {"sqrt", sqrt},
        {"cbrt", cbrt},   {"abs", abs},     {"sign", sign},   {"floor", floor}, {"ceil", ceil},
        {"round", round}, {"trunc", trunc}, {"sin", sin},     {"cos", cos},     {"tan", tan},
        {"asin", asin},   {"acos", acos},   {"atan", atan},   {"sinh", sinh},   {"cosh", cosh},
        {"tanh", tanh},   {"asinh", asinh}, {"acosh", acosh}, {"atanh", atanh}, {"erf", erf}};
    for (const auto& [known, of] : functions) {
      if (known == name) return of(a);
    }
    return a;
  }
};

}  // namespace

PLANTLOOP_BLOCK(math_function, MathFunction)

}  // namespace plantloop
