// Whatever stands in a file, reading it ends, with a model or with findings; run under sanitizers it finds more.

#include <gtest/gtest.h>

#include <random>

#include "engine/base/text.h"
#include "engine/diagram/model.h"
#include "engine/diagram/plain_yaml.h"
#include "engine/diagram/tree.h"

namespace plantloop {
namespace {

constexpr const char* good = R"yaml(# A servo.
plantloop: 1
title: "Servo θ"
parameters:
  k: {value: 2.5, unit: N m/rad, doc: stiffness}
  q: [1, 2, [3, 4]]
blocks:
  r: {type: step, time: 0.5, after: 1}
  y: {type: integrator, in: v, initial: k*2, reset: {when: y > 3, edge: rising, to: -y}}
  v:
    type: sub
    in: {u: r - y, w: "dot([1, 2], x)"}
    rate: {period: 0.1, offset: 0.02}
  u: k^2*(r - y) - 2*T.2:4
  z: [u, y.1, 2]
types:
  sub:
    inputs: {u: {size: 1}, w: {default: 0, size: 2}}
    outputs: {y: {from: s, initial: 0}}
    blocks: {s: u + sum(w)}
simulation: {stop: 6, solver: dopri5}
record: {r: r, y: y}
figures:
  one: {x: {label: t, limits: [0, 1]}, panels: [{y: [r, {signal: y, style: dashed}], bands: [{lower: 1, upper: 2}]}]}
expect:
  - {signal: y, at: 3, value: 1, abs: 1e-3}
  - {event: y.reset, count: 4}
checks: {units: note}
)yaml";

void read_and_print(const std::string& text) {
  Report report;
  const auto model = read_model_text(text, "tests/fuzz.yaml", report);
  EXPECT_TRUE(model != nullptr || report.has_errors());
  to_text(report);
  to_json(report);
  to_sarif(report);
}

std::string mutated(std::string text, std::mt19937& random) {
  constexpr std::string_view spice = "{}[]():,-#&*!|>'\"%@` \t\n\r\\.^01ax\xC3\xA9\xFF";
  const int n = 1 + static_cast<int>(random() % 4);
  for (int i = 0; i < n; ++i) {
    const std::size_t at = random() % (text.size() + 1);
    switch (random() % 4) {
      case 0:
        text.insert(at, 1, spice[random() % spice.size()]);
        break;
      case 1:
        text.erase(at, 1 + random() % 12);
        break;
      case 2:
        text.insert(at, text.substr(random() % text.size(), random() % 40));
        break;
      default:
        if (at < text.size()) text[at] = spice[random() % spice.size()];
    }
    if (text.empty()) text = "a";
  }
  return text;
}

TEST(Fuzz, TheGoodTextIsGood) {
  Report report;
  read_model_text(good, "tests/fuzz.yaml", report);
  EXPECT_EQ(to_text(report), "");
}

TEST(Fuzz, MutatedDiagramsAreReadOrReported) {
  std::mt19937 random(1);
  for (int i = 0; i < 3000; ++i) read_and_print(mutated(good, random));
}

TEST(Fuzz, RandomBytesAreReadOrReported) {
  std::mt19937 random(2);
  for (int i = 0; i < 2000; ++i) {
    std::string text(random() % 80, ' ');
    for (char& c : text) c = static_cast<char>(random() % (i % 2 == 0 ? 256 : 128));
    read_and_print(text);
    Report report;
    parse_expression(text, TextPlace{}, report);
  }
}

std::string outline(const Node& node) {
  std::string out = fmt::format("{}:{}:{}:{}'{}'", static_cast<int>(node.kind), node.offset, node.mark.column,
                                node.mark.length, node.text);
  for (std::size_t i = 0; i < node.items.size(); ++i) {
    out += "(" + (node.is_mapping() ? node.keys[i] : std::string()) + outline(node.items[i]) + ")";
  }
  return out;
}

TEST(Fuzz, WhatThePlainReaderTakesTheGeneralOneReadsEqually) {
  std::mt19937 random(3);
  int taken = 0;
  for (int i = 0; i < 4000; ++i) {
    const auto source = std::make_shared<const Source>(
        Source{"x", mutated(i % 2 == 0 ? good : "a: {b: 1}\nc:\n- d\n- e: 1\n", random)});
    const std::optional<Node> plain = read_plain(*source);
    if (!plain || find_invalid_utf8(source->text)) continue;
    ++taken;
    Report all;
    const Node checked = read_document(source, all);
    Report report;
    const Node general = read_general(source, report);
    EXPECT_EQ(all.error_count(), report.error_count()) << source->text;
    EXPECT_EQ(outline(*plain), outline(general)) << source->text << to_text(report);
  }
  EXPECT_GT(taken, 100);  // else the mutations are too wild to compare anything
}

}  // namespace
}  // namespace plantloop
