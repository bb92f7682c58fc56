// All diagrams of the project as drawings, closed, open and from inside.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <string_view>

#include "app/drawing/sheets.h"
#include "app/figures.h"
#include "engine/run/diagram.h"
#include "render/diagram/draw.h"
#include "render/image.h"
#include "render/scene/lint.h"

namespace plantloop {
namespace {

using testing::IsEmpty;

std::shared_ptr<const Graph> graph_of(const std::shared_ptr<const Model>& model, const std::string& name) {
  Report report;
  auto graph = model ? elaborate(model, {}, report) : nullptr;
  EXPECT_TRUE(graph) << name << "\n" << to_text(report, false);
  return graph;
}

std::shared_ptr<const Graph> graph_of_file(const std::string& path) {
  Report report;
  const auto model = read_model(path, report, plot_words());
  EXPECT_TRUE(model) << to_text(report, false);
  if (model && model->is_library) return nullptr;
  return graph_of(model, path);
}

std::shared_ptr<const Graph> graph_of_text(const std::string& text) {
  Report report;
  const auto model = read_model_text("plantloop: 1\n" + text, "test.yaml", report);
  EXPECT_TRUE(model) << to_text(report, false);
  return graph_of(model, text);
}

std::vector<std::string> diagram_files() {
  std::vector<std::string> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator("diagrams"))
    if (entry.path().extension() == ".yaml" && entry.path().parent_path().filename() != "models")
      files.push_back(entry.path().string());
  std::sort(files.begin(), files.end());
  return files;
}

const SheetBlock& block(const Sheet& sheet, std::string_view path) {
  const auto it =
      std::find_if(sheet.blocks.begin(), sheet.blocks.end(), [&](const SheetBlock& b) { return b.path == path; });
  EXPECT_NE(it, sheet.blocks.end()) << path;
  return *it;
}

TEST(Drawing, OfEveryDiagramKeepsTheRulesOfTheLayout) {
  int drawn = 0;
  for (const std::string& path : diagram_files()) {
    const auto graph = graph_of_file(path);
    if (!graph) continue;
    for (std::uint32_t scope = 0; scope < graph->scopes.size(); ++scope)
      for (const int depth : {0, 1, 3}) {
        const Sheet sheet = sheet_of(*graph, scope, {.depth = depth, .rates = true, .sizes = true, .units = true});
        const Arrangement a = arrange(sheet);
        EXPECT_THAT(faults(sheet, a), IsEmpty()) << path << " scope " << scope << " depth " << depth;
        EXPECT_THAT(lint(draw(sheet, a)), IsEmpty()) << path << " scope " << scope << " depth " << depth;
        ++drawn;
      }
  }
  EXPECT_GT(drawn, 30);
}

// Block types show what their own examples do.
TEST(Drawing, OfEveryBlockTypesExampleKeepsTheRulesOfTheLayout) {
  for (const BlockType& type : catalogue()) {
    Report report;
    const auto model = read_model_text("plantloop: 1\n" + std::string(type.example), "examples/example.yaml", report);
    auto graph = model ? elaborate(model, {}, report) : nullptr;
    if (!graph) continue;  // it reads a file beside it
    const Sheet sheet = sheet_of(*graph, 0, {.rates = true});
    const Arrangement a = arrange(sheet);
    EXPECT_THAT(faults(sheet, a), IsEmpty()) << type.name;
    EXPECT_THAT(lint(draw(sheet, a)), IsEmpty()) << type.name;
  }
}

// Models known from other tools and books, made again.
TEST(Drawing, TheClassicsAreRightAndTwentyFiveOrMore) {
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator("diagrams/classics")) {
    const std::string path = entry.path().string();
    Report report;
    const auto diagram = Diagram::load(path, report);
    ASSERT_TRUE(diagram) << to_text(report, false);
    const auto run = diagram->run({}, report);
    ASSERT_TRUE(run) << to_text(report, false);
    EXPECT_FALSE(run->verdicts.empty()) << path;
    for (const Verdict& v : run->verdicts) EXPECT_TRUE(v.met) << path << ": " << v.text << ": " << v.measured;
    ++count;
  }
  EXPECT_GE(count, 25);
}

TEST(Drawing, ALinearWireBecomesSumsAndGainsAndANonlinearTermOneBox) {
  const auto graph = graph_of_text(
      "parameters: {k: 2}\nblocks:\n  u: {type: sine}\n  y: 3*u - k*x + sin(x)\n  x: {type: integrator, in: y}\n");
  const Sheet sheet = sheet_of(*graph, 0, {});
  EXPECT_EQ(block(sheet, "y").shape, SheetBlock::Shape::circle);
  EXPECT_EQ(block(sheet, "y").inputs, (std::vector<std::string>{"+", "−", "+"}));
  EXPECT_EQ(spoken(block(sheet, "y+1").formula), "3");
  EXPECT_EQ(spoken(block(sheet, "y+2").formula), "k");
  EXPECT_EQ(block(sheet, "y+3").shape, SheetBlock::Shape::box);
  EXPECT_EQ(spoken(block(sheet, "y+3").formula), "sin(x)");
}

// What leads back goes to the left, inside a frame, too.
TEST(Drawing, TurnsTheInsideOfASubsystemThatLeadsBack) {
  const auto graph = graph_of_text(
      "types:\n  sensor:\n    inputs: [u]\n    blocks:\n      e: u - f\n      v: {type: integrator, in: 20*e}\n"
      "      p: {type: integrator, in: 5*v}\n      f: 0.5*p + v\n      n: {type: first_order, in: p, tau: 0.1}\n"
      "    outputs: [n]\n"
      "blocks:\n  w: {type: step, time: 1}\n  e: w - m\n  u: {type: pi, in: e, kp: 2, ki: 1}\n"
      "  y: {type: first_order, in: u, tau: 1}\n  m: {type: sensor, in: y}\nrecord: [y]\n");
  const Sheet sheet = sheet_of(*graph, 0, {.depth = 1});
  const Arrangement a = arrange(sheet);
  EXPECT_THAT(faults(sheet, a), IsEmpty());
  ASSERT_EQ(a.frames.size(), 1u);
  const Arrangement& inside = a.frames[0].inside;
  const Sheet& sensor = *block(sheet, "m").inside;
  const auto left_of = [&](const std::string& path) {
    for (const PlacedBlock& b : inside.blocks)
      if (b.block >= 0 && sensor.blocks[static_cast<std::size_t>(b.block)].path == path) return b.box.left;
    ADD_FAILURE() << path;
    return 0.0;
  };
  EXPECT_GT(left_of("v"), left_of("p"));
  EXPECT_GT(left_of("p"), left_of("n"));
}

TEST(Drawing, ABusIsABarAndAMemberThatIsReadABoxWithItsName) {
  const auto graph = graph_of_text(
      "types:\n  filter:\n    inputs: [m]\n    blocks: {x: {type: first_order, in: m.ax + m.ay, tau: 0.1}}\n    "
      "outputs: [x]\n"
      "blocks:\n  ax: {type: sine}\n  ay: {type: step, time: 1}\n  meter: {type: bus, in: {ax: ax, ay: 2*ay}}\n"
      "  f: {type: filter, in: {m: meter}}\n  y: f - meter.ay\n  spare: {type: bus, in: {m: meter, y: y}}\nrecord: "
      "[y]\n");
  for (const int depth : {0, 1}) {
    const Sheet sheet = sheet_of(*graph, 0, {.depth = depth});
    EXPECT_THAT(faults(sheet, arrange(sheet)), IsEmpty());
    EXPECT_EQ(block(sheet, "meter").shape, SheetBlock::Shape::bar);
    EXPECT_EQ(spoken(block(sheet, "meter.ay").formula), "ay");
    const auto meter = static_cast<int>(&block(sheet, "meter") - sheet.blocks.data());
    const auto wire =
        std::find_if(sheet.wires.begin(), sheet.wires.end(), [&](const SheetWire& w) { return w.from.block == meter; });
    ASSERT_NE(wire, sheet.wires.end());
    EXPECT_EQ(wire->label, "meter");
    EXPECT_EQ(wire->to.size(), 3u);  // the filter, the member and the other bus
    if (const auto& inside = block(sheet, "f").inside) {
      EXPECT_EQ(spoken(block(*inside, "meter.ax").formula), "ax");
    }
  }
}

TEST(Drawing, ShowsTransferFunctionsWithTheirNumbersAndNames) {
  const auto graph = graph_of_text(
      "parameters: {k: 5}\nblocks:\n  u: {type: step, time: 1}\n"
      "  plant: {type: transfer_function, in: u, num: [k], den: [1, 0.4, 0]}\n"
      "  lag: {type: first_order, in: plant, tau: 0.1}\n");
  const Sheet sheet = sheet_of(*graph, 0, {});
  EXPECT_EQ(spoken(block(sheet, "plant").formula), "(k)/(s^{2} + 0.4 s)");
  EXPECT_EQ(spoken(block(sheet, "lag").formula), "(1)/(0.1 s + 1)");
}

TEST(Drawing, WritesNoBracketsAndNoOnesThatAreNotNeeded) {
  const auto graph = graph_of_text(
      "parameters: {q: 1, V: 2, cooling: 3}\nblocks:\n  u: {type: step, time: 1}\n"
      "  late: {type: transport_delay, in: u, delay: 1}\n  lead: {type: lead_lag, in: u, lead: 0.2, lag: 1}\n"
      "  loss: (q/V + cooling)*u\n  both: V*(q + cooling)*u\n"
      "  pick: where(u > 2, 3*u, where(u > 1, 2*u, where(u > 0, u, 0)))\n");
  const Sheet sheet = sheet_of(*graph, 0, {});
  EXPECT_EQ(spoken(block(sheet, "late").formula), "e^(−s)");
  EXPECT_EQ(spoken(block(sheet, "lead").formula), "(0.2 s + 1)/(s + 1)");
  EXPECT_EQ(spoken(block(sheet, "loss").formula), "(q)/(V) + cooling");
  EXPECT_EQ(spoken(block(sheet, "both").formula), "V (q + cooling)");
  EXPECT_EQ(block(sheet, "pick").formula.kind, Formula::Kind::cases);
  EXPECT_EQ(block(sheet, "pick").formula.parts.size(), 4u);
}

TEST(Drawing, SaysBetweenWhichLimitsAControllerWorks) {
  const auto graph = graph_of_text(
      "blocks:\n  u: {type: step, time: 1}\n  c: {type: pi, in: u, lower: -1, upper: 5}\n"
      "  d: {type: pi, in: u, upper: 5}\n  e: {type: pi, in: u}\n");
  const Sheet sheet = sheet_of(*graph, 0, {});
  EXPECT_EQ(block(sheet, "c").note, "−1 ≤ u ≤ 5");
  EXPECT_EQ(block(sheet, "d").note, "u ≤ 5");
  EXPECT_EQ(block(sheet, "e").note, "");
}

// Play is a closed loop: both ways through the middle, as far from it on either side.
TEST(Drawing, ShowsBothWaysOfPlay) {
  const auto graph = graph_of_text("blocks:\n  u: {type: sine}\n  y: {type: backlash, in: u, width: 1}\n");
  const Sheet sheet = sheet_of(*graph, 0, {});
  ASSERT_EQ(block(sheet, "y").curves.size(), 1u);
  std::vector<double> middles;
  const Curve& curve = block(sheet, "y").curves[0];
  for (std::size_t i = 1; i < curve.size(); ++i)
    if ((curve[i - 1].y - 0.5) * (curve[i].y - 0.5) < 0) middles.push_back(curve[i].x);
  ASSERT_EQ(middles.size(), 2u);
  EXPECT_NEAR(middles[0] + middles[1], 1, 0.06);
  EXPECT_GT(std::abs(middles[0] - middles[1]), 0.15);
}

TEST(Drawing, ShowsWhatASaturationDoesAsACurve) {
  const auto graph = graph_of_text("blocks:\n  u: {type: sine}\n  y: {type: saturation, in: u, lower: -1, upper: 3}\n");
  const Sheet sheet = sheet_of(*graph, 0, {});
  ASSERT_EQ(block(sheet, "y").curves.size(), 1u);
  const Curve& curve = block(sheet, "y").curves[0];
  EXPECT_NEAR(curve.front().y, 0, 1e-9);
  EXPECT_NEAR(curve.back().y, 1, 1e-9);
  // Half of the height is reached at u = 1, the middle of the limits and of what is shown.
  const auto half = std::find_if(curve.begin(), curve.end(), [](Spot s) { return s.y >= 0.5; });
  EXPECT_NEAR(half->x, 0.5, 0.01);
  EXPECT_EQ(block(sheet, "y").axes.size(), 2u);
}

TEST(Drawing, DoesNotChangeWhenTheBlocksOfTheFileAreShuffled) {
  const std::string head = "plantloop: 1\nblocks:\n";
  const std::string r = "  r: {type: step, time: 1}\n", e = "  e: r - y\n", c = "  c: {type: pi, in: e}\n",
                    y = "  y: {type: first_order, in: c}\n";
  const auto svg = [&](const std::string& blocks) {
    Report report;
    const auto graph = graph_of(read_model_text(head + blocks + "record: [y]\n", "test.yaml", report), blocks);
    const Sheet sheet = sheet_of(*graph, 0, {});
    return to_svg(draw(sheet, arrange(sheet)));
  };
  EXPECT_EQ(svg(r + e + c + y), svg(y + c + e + r));
}

const SheetWire* wire_to(const Sheet& sheet, const std::string& path, const std::string& input) {
  for (const SheetWire& wire : sheet.wires)
    for (const SheetPort& to : wire.to) {
      const SheetBlock& b = sheet.blocks[static_cast<std::size_t>(to.block)];
      if (b.path == path && b.inputs[static_cast<std::size_t>(to.port)] == input) return &wire;
    }
  return nullptr;
}

std::string from(const Sheet& sheet, const std::string& path, const std::string& input) {
  const SheetWire* wire = wire_to(sheet, path, input);
  return wire ? sheet.blocks[static_cast<std::size_t>(wire->from.block)].path : "nothing";
}

constexpr const char* chain =
    "types:\n  cell:\n    inputs: [before, after]\n"
    "    blocks: {y: {type: integrator, in: before - 2*y + after}}\n    outputs: [y]\n"
    "blocks:\n  left: {type: step, time: 1}\n"
    "  cell: {type: cell, repeat: 5, in: {before: previous.y, after: next.y}, first: {before: left}, last: {after: "
    "0}}\n";

TEST(Drawing, ShowsARepeatedBlockAsOneStackWithItsEnds) {
  const auto graph = graph_of_text(std::string(chain) + "  seen: 2*cell.3.y\nrecord: [seen]\n");
  const Sheet sheet = sheet_of(*graph, 0, {});
  const SheetBlock& cell = block(sheet, "cell");
  EXPECT_EQ(cell.copies, 5);
  EXPECT_EQ(cell.caption, "cell × 5");
  EXPECT_EQ(from(sheet, "cell", "before"), "cell");
  EXPECT_EQ(from(sheet, "cell", "after"), "cell");
  EXPECT_EQ(from(sheet, "cell", "first: before"), "left");
  EXPECT_EQ(from(sheet, "cell", "last: after"), "cell<last1");
  EXPECT_EQ(from(sheet, "seen", ""), "cell");
  EXPECT_EQ(cell.inputs.size(), 4u);
  const Arrangement a = arrange(sheet);
  EXPECT_THAT(faults(sheet, a), IsEmpty());
  EXPECT_THAT(lint(draw(sheet, a)), IsEmpty());
}

TEST(Drawing, ShowsADiagramOfOneRepeatedBlock) {
  for (const char* text : {"blocks:\n  x: {type: integrator, repeat: 3, in: 1}\n",
                           "blocks:\n  x: {type: first_order, repeat: 4, in: previous, tau: 1, first: {u: 1}}\n"}) {
    const Sheet sheet = sheet_of(*graph_of_text(text), 0, {});
    EXPECT_GT(block(sheet, "x").copies, 2) << text;
    EXPECT_THAT(faults(sheet, arrange(sheet)), IsEmpty()) << text;
  }
}

// What switches a block on is an input at its top; what it is reset to, one at its side.
TEST(Drawing, ShowsTheConditionsOfBlocksExpressionsAndSubsystems) {
  const auto graph = graph_of_text(
      "types:\n  heater:\n    inputs: [u]\n    blocks: {x: {type: first_order, in: u}}\n    outputs: {x: {from: x, "
      "initial: 0}}\n"
      "blocks:\n  u: {type: sine}\n  armed: {type: pulse, period: 2}\n  start: {type: step}\n"
      "  heater: {type: heater, in: {u: u}, enable: {when: armed > 0.5}}\n"
      "  half: {expr: u/2, enable: {when: armed, initial: 0}}\n"
      "  latch: {expr: u + start, trigger: {when: armed, initial: 0}}\n"
      "  x: {type: integrator, in: u, reset: {when: armed, to: start}, enable: {when: start}}\n");
  const Sheet sheet = sheet_of(*graph, 0, {});
  const auto top = [&](const std::string& path) {
    const SheetBlock& b = block(sheet, path);
    return b.top_input < 0 ? "" : b.inputs[static_cast<std::size_t>(b.top_input)];
  };
  EXPECT_EQ(top("heater"), "enable");
  EXPECT_EQ(top("half"), "enable");
  EXPECT_EQ(top("latch"), "trigger ↑");
  EXPECT_EQ(top("x"), "enable");
  EXPECT_EQ(from(sheet, "half", "enable"), "armed");
  EXPECT_EQ(from(sheet, "latch", "trigger ↑"), "armed");
  EXPECT_EQ(from(sheet, "x", "reset"), "armed");
  EXPECT_EQ(from(sheet, "x", "to"), "start");
  const Arrangement a = arrange(sheet);
  EXPECT_THAT(faults(sheet, a), IsEmpty());
  EXPECT_THAT(lint(draw(sheet, a)), IsEmpty());
  // An open subsystem has it at the top of its frame.
  const Sheet open = sheet_of(*graph, 0, {.depth = 1});
  EXPECT_EQ(block(open, "heater").top_input, 1);
  EXPECT_EQ(from(open, "heater", "enable"), "heater<enable");
  EXPECT_THAT(faults(open, arrange(open)), IsEmpty());
  EXPECT_THAT(lint(draw(open, arrange(open))), IsEmpty());
}

TEST(Drawing, HasNoArrowOutOfWhatEndsTheRun) {
  const char* text = "blocks:\n  h: {type: sine}\n  ground: {type: stop, in: h < 0}\n";
  const auto shown = [](const Sheet& sheet, const std::string& path) {
    for (const SheetWire& wire : sheet.wires)
      if (sheet.blocks[static_cast<std::size_t>(wire.from.block)].path == path) return wire.is_shown;
    return false;
  };
  EXPECT_FALSE(shown(sheet_of(*graph_of_text(text), 0, {}), "ground"));
  EXPECT_TRUE(shown(sheet_of(*graph_of_text(std::string(text) + "record: [ground]\n"), 0, {}), "ground"));
}

TEST(Drawing, SaysWhenAThemeIsUnknown) {
  const Sheet sheet = sheet_of(*graph_of_text("blocks:\n  u: {type: sine}\n"), 0, {});
  try {
    draw(sheet, arrange(sheet), "pink");
    FAIL();
  } catch (const std::exception& e) {
    EXPECT_STREQ(e.what(), "there is no theme 'pink'; there are: light, dark, print");
  }
}

}  // namespace
}  // namespace plantloop
