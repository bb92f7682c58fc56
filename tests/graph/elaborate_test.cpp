// Model -> Graph: names, parameters, sizes and rates; references are worked out by hand.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "engine/graph/describe.h"
#include "tests/graph/helpers.h"

namespace plantloop {
namespace {

const GraphParameter& parameter(const Graph& graph, const std::string& path) {
  const Named named = find_named(graph, path);
  EXPECT_EQ(named.kind, Named::Kind::parameter) << path;
  return graph.parameters[named.index];
}
const GraphNet& net(const Graph& graph, const std::string& path) {
  const Named named = find_named(graph, path);
  if (named.kind == Named::Kind::block) return graph.nets[graph.blocks[named.index].first_output];
  EXPECT_EQ(named.kind, Named::Kind::net) << path;
  return graph.nets[named.index];
}

TEST(Parameters, FollowEachOtherInAnyOrder) {
  const auto graph = graph_of(R"(
plantloop: 1
parameters: {c: a + b, a: 2*b, b: 3, phi: [0, 36*pi/180], ps: sqrt(phi + 4), v: "[b, 2, c]"}
blocks: {x: {type: constant, value: c}}
)");
  EXPECT_EQ(parameter(*graph, "c").value[0].number(), 9);
  EXPECT_EQ(parameter(*graph, "ps").value.shape(), Shape::vector(2));
  EXPECT_EQ(parameter(*graph, "ps").value[0].number(), 2);
  EXPECT_EQ(parameter(*graph, "v").value[2].number(), 9);
}

TEST(Parameters, OfInstancesAreReadInParametersAndInitialValues) {
  const auto graph = graph_of(R"(
plantloop: 1
blocks:
  plant: {type: plant, start: 4}
  x: {type: integrator, in: plant, initial: plant.half + 1}
types:
  plant:
    parameters: {start: 1, half: start/2}
    blocks: {y: {type: integrator, in: -y, initial: start}}
    outputs: [y]
)");
  EXPECT_EQ(parameter(*graph, "x.initial").value[0].number(), 3);
}

TEST(Overrides, ReplaceTheTextSoThatDependentNumbersFollowAndLinksAreCut) {
  const std::string text = R"(
plantloop: 1
parameters: {Q: 2, b: Q + 1, K: [1, 2, 3]}
blocks:
  loop: {type: loop, k: b}
  x: {type: integrator, in: K.2*loop - x}
types:
  loop:
    parameters: {k: 1}
    blocks: {g: {type: inner, k: 2*k}}
    outputs: {y: g}
  inner:
    parameters: {k: 1}
    blocks: {y: {type: constant, value: k}}
    outputs: [y]
)";
  EXPECT_EQ(parameter(*graph_of(text), "loop.g.k").value[0].number(), 6);
  EXPECT_EQ(parameter(*graph_of(text, {{"Q", "4"}}), "loop.g.k").value[0].number(), 10);
  EXPECT_EQ(parameter(*graph_of(text, {{"b", "Q*Q"}}), "loop.g.k").value[0].number(), 8);
  EXPECT_EQ(parameter(*graph_of(text, {{"loop.g.k", "k + 1"}}), "loop.g.k").value[0].number(), 4);
  EXPECT_EQ(parameter(*graph_of(text, {{"x.initial", "Q"}}), "x.initial").value[0].number(), 2);
  EXPECT_EQ(parameter(*graph_of(text, {{"K.2", "7"}}), "K").value[1].number(), 7);
}

TEST(Overrides, WithWrongPathsAreToldTheNearestName) {
  const std::string text = R"(
plantloop: 1
parameters: {gain: 2}
blocks:
  loop: {type: loop}
  x: {type: integrator, in: gain*loop - x}
  y: 2*x
types:
  loop:
    parameters: {ki: 1}
    blocks: {y: {type: constant, value: ki}}
    outputs: [y]
)";
  EXPECT_EQ(errors_of(text, {{"gian", "1"}}),
            "there is no parameter 'gian' | did you mean 'gain'?  it has: gain, loop, x, y");
  EXPECT_EQ(errors_of(text, {{"loop.kj", "1"}}),
            "'loop' (loop) has no parameter 'kj' | did you mean 'ki'?  it has: ki, y");
  EXPECT_EQ(errors_of(text, {{"x.init", "1"}}),
            "'x' (integrator) has no parameter 'init' | did you mean 'initial'?  it has: initial, lower, upper");
  EXPECT_EQ(errors_of(text, {{"x", "1"}}),
            "'x' is a block, not a parameter | its parameters can be set, e.g. x.initial");
  EXPECT_EQ(errors_of(text, {{"y.k", "1"}}), "'y' is an expression: it has no parameters");
  EXPECT_EQ(errors_of(text, {{"loop.y.value.x", "1"}}),
            "'value' of 'y' (constant) has no part named like that: 'loop.y.value.x'");
  EXPECT_EQ(errors_of(text, {{"gain", "1 +"}}), "the expression ends after '+'");
}

TEST(S3Sizes, FlowForwardThroughBlocksAndExpressions) {
  const auto graph = graph_of(R"(
plantloop: 1
parameters: {n: 4}
blocks:
  left: {type: step}
  shift: [left, T.1:3]
  T: {type: integrator, in: shift - T, initial: zeros(n)}
  mean: sum(T)/n
  K: "[[1, 2, 3, 4]]"
  u: mul(K, T)
  g: {type: gain, in: T, k: 2}
  s: {type: sum, in: T}
)");
  EXPECT_EQ(net(*graph, "T").shape, Shape::vector(4));
  EXPECT_EQ(net(*graph, "shift").shape, Shape::vector(4));
  EXPECT_EQ(net(*graph, "g").shape, Shape::vector(4));
  EXPECT_EQ(net(*graph, "mean").shape, Shape::scalar());
  EXPECT_EQ(net(*graph, "s").shape, Shape::scalar());
  EXPECT_EQ(net(*graph, "u").shape, Shape::scalar());  // one row times one column
  EXPECT_EQ(parameter(*graph, "n").structural, 2);
}

TEST(S3Sizes, OfLoopsThatNoVectorEntersAreScalars) {
  const auto graph = graph_of(R"(
plantloop: 1
blocks:
  v: {type: integrator, in: -x - d}
  x: {type: integrator, in: v}
  d: {type: gain, in: v, k: 0.1}
  z: {type: integrator, in: "[x, v] - z"}
  w: {type: integrator, in: z - w}
)");
  EXPECT_EQ(net(*graph, "x").shape, Shape::scalar());
  EXPECT_EQ(net(*graph, "z").shape, Shape::vector(2));
  EXPECT_EQ(net(*graph, "w").shape, Shape::vector(2));
}

TEST(S6Rates, AreInheritedFromInputsAndReaders) {
  const auto graph = graph_of(R"(
plantloop: 1
parameters: {Ts: 1/10}
blocks:
  c: {type: constant, value: 2}
  w: {type: step}
  both: {type: step}
  k: {type: gain, in: w}
  x: {type: integrator, in: both - d}
  d: {type: unit_delay, in: k + both, rate: Ts}
  e: 2*d + c
  slow: {type: unit_delay, in: d, rate: 3*Ts}
  f: e + slow
  g: e + x
  h: 2*c
)");
  const auto rate = [&](const std::string& name) { return net(*graph, name).rate; };
  EXPECT_EQ(rate("c").kind, GraphRate::Kind::constant);
  EXPECT_EQ(rate("h").kind, GraphRate::Kind::constant);
  EXPECT_EQ(rate("w").kind, GraphRate::Kind::discrete);  // read by the delay only, through k
  EXPECT_EQ(rate("k").kind, GraphRate::Kind::discrete);
  EXPECT_EQ(rate("both").kind, GraphRate::Kind::continuous);
  EXPECT_EQ(rate("e"), rate("d"));
  EXPECT_EQ(rate("f"), rate("d"));  // the fastest of rates that are multiples
  EXPECT_EQ(rate("g").kind, GraphRate::Kind::continuous);
  EXPECT_EQ(graph->rates[rate("d").index].period.to_string(), "1/10");
  EXPECT_EQ(graph->rates[rate("slow").index].period.to_string(), "3/10");
}

TEST(S6Rates, OfASubsystemHoldForEverythingInside) {
  const auto graph = graph_of(R"(
plantloop: 1
blocks:
  x: {type: integrator, in: plc - x}
  plc: {type: plc, in: 1 - x, rate: {period: 0.5, offset: 0.1}}
types:
  plc:
    inputs: [e]
    blocks:
      I: {type: unit_delay, in: I + e}
      u: 2*e + I
    outputs: [u]
)");
  EXPECT_EQ(net(*graph, "plc.u").rate.kind, GraphRate::Kind::discrete);
  EXPECT_EQ(net(*graph, "plc.I").rate, net(*graph, "plc.u").rate);
  EXPECT_EQ(graph->rates[net(*graph, "plc.e").rate.index].offset.to_string(), "1/10");
}

TEST(Numbers, OfOtherSectionsAreEvaluatedOverParameters) {
  const auto graph = graph_of(R"(
plantloop: 1
parameters: {g: 9.81, h0: 1, t1: sqrt(2*h0/g), v: [1, 2]}
blocks: {x: {type: integrator, in: g}}
)");
  Report report;
  const auto number = [&](const std::string& text) {
    return evaluate_scalar(*graph, *parse_expression(text, {}, report), "stop", report);
  };
  EXPECT_DOUBLE_EQ(*number("2*t1"), 2 * std::sqrt(2 / 9.81));
  EXPECT_EQ(*number("v.2 + pi - pi"), 2);
  EXPECT_FALSE(report.has_errors()) << to_text(report);
  EXPECT_FALSE(number("v"));
  EXPECT_FALSE(number("x + 1"));
  EXPECT_FALSE(number("v.3"));
  EXPECT_EQ(report.error_count(), 3U);
}

TEST(Describe, TellsEverythingThatIsDeclared) {
  const std::string text = block_text(*find_block("first_order"));
  for (const char* part : {"signal to follow", "time constant", ">= 1e-09", "lagged value", "x' = (k u - x) / tau"}) {
    EXPECT_NE(text.find(part), std::string::npos) << part << " in\n" << text;
  }
  for (const BlockType& type : catalogue()) {
    EXPECT_NE(catalogue_text().find(std::string(type.name)), std::string::npos);
    EXPECT_NE(diagram_schema().find("block_" + std::string(type.name)), std::string::npos);
    EXPECT_FALSE(block_markdown(type).empty());
  }
}

TEST(Describe, GivesExamplesThatAreRight) {
  for (const BlockType& type : catalogue()) {
    if (std::any_of(type.block->texts.begin(), type.block->texts.end(), [](const Text* t) { return t->spec.file; }))
      continue;
    const std::string page = block_text(type);
    const std::string example = page.substr(page.find("name: ") + 6);
    Report report;
    std::string text = "plantloop: 1\nblocks:\n  name: " + example;
    for (const Input* input : type.block->inputs) text += fmt::format("  {}: {{type: step}}\n", input->name);
    if (!type.block->lists.empty()) text += "  a: {type: step}\n  b: {type: step}\n";
    const std::string wrong = errors_of(text);
    EXPECT_EQ(wrong.find("no parameter"), std::string::npos) << text << wrong;
    EXPECT_EQ(wrong.find("not connected"), std::string::npos) << text << wrong;
    EXPECT_EQ(wrong.find("needs a"), std::string::npos) << text << wrong;
  }
}

}  // namespace
}  // namespace plantloop
