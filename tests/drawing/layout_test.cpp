// What holds for every arrangement, shown on random sheets, and what a control engineer expects of simple loops.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <string>
#include <string_view>

#include "render/diagram/draw.h"
#include "render/scene/dump.h"
#include "render/scene/lint.h"
#include "tests/drawing/random_sheets.h"

namespace plantloop {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using Shape = SheetBlock::Shape;

SheetBlock box(const std::string& path, std::vector<std::string> inputs, bool has_state = false) {
  SheetBlock b;
  b.path = b.caption = path;
  b.formula = "G";
  b.inputs = std::move(inputs);
  b.outputs = {""};
  b.has_state = has_state;
  return b;
}

SheetBlock circle(const std::string& path, std::vector<std::string> signs) {
  SheetBlock b = box(path, std::move(signs));
  b.shape = Shape::circle;
  b.caption.clear();
  return b;
}

SheetWire wire(int from, std::vector<SheetPort> to, bool is_shown = false) {
  SheetWire w;
  w.from = {from, 0};
  w.to = std::move(to);
  w.is_shown = is_shown;
  return w;
}

// r -> e -> controller -> plant, back through a sensor.
Sheet loop() {
  Sheet sheet;
  sheet.blocks = {box("r", {}), circle("e", {"+", "−"}), box("controller", {""}, true), box("plant", {""}, true),
                  box("sensor", {""})};
  sheet.wires = {wire(0, {{1, 0}}), wire(1, {{2, 0}}), wire(2, {{3, 0}}), wire(3, {{4, 0}}, true), wire(4, {{1, 1}})};
  return sheet;
}

std::vector<std::string> path_names(const Sheet& sheet, const Arrangement& a) {
  std::vector<std::string> names;
  for (const int i : a.main_path) {
    const int b = a.blocks[static_cast<std::size_t>(i)].block;
    if (b >= 0) names.push_back(sheet.blocks[static_cast<std::size_t>(b)].path);
  }
  return names;
}

const PlacedBlock& placed(const Sheet& sheet, const Arrangement& a, std::string_view path) {
  return *std::find_if(a.blocks.begin(), a.blocks.end(), [&](const PlacedBlock& b) {
    return b.block >= 0 && sheet.blocks[static_cast<std::size_t>(b.block)].path == path;
  });
}
double middle(const PlacedBlock& b) { return (b.box.top + b.box.bottom) / 2; }

TEST(Layout, PutsTheForwardPathOnOneLineAndTheSensorBelowPointingBack) {
  const Sheet sheet = loop();
  const Arrangement a = arrange(sheet);
  EXPECT_THAT(faults(sheet, a), IsEmpty());
  EXPECT_THAT(path_names(sheet, a), ElementsAre("r", "e", "controller", "plant"));
  for (const char* name : {"e", "controller", "plant"})
    EXPECT_NEAR(middle(placed(sheet, a, name)), middle(placed(sheet, a, "r")), 1e-9) << name;
  const PlacedBlock& sensor = placed(sheet, a, "sensor");
  EXPECT_TRUE(sensor.is_flipped);
  EXPECT_GT(sensor.box.top, placed(sheet, a, "plant").box.bottom);
  // The comparison is fed from the left and, with a minus, from below.
  const PlacedBlock& e = placed(sheet, a, "e");
  ASSERT_EQ(e.inputs.size(), 2u);
  EXPECT_EQ(e.inputs[0].side, Side::left);
  EXPECT_EQ(e.inputs[1].side, Side::bottom);
  EXPECT_EQ(e.inputs[1].text, "−");
}

TEST(Layout, PutsADisturbanceStraightAboveItsSum) {
  Sheet sheet = loop();
  sheet.blocks.push_back(box("d", {}));
  sheet.blocks.push_back(circle("sum", {"+", "+"}));
  sheet.wires[2].to = {{6, 0}};
  sheet.wires.push_back(wire(5, {{6, 1}}));
  sheet.wires.push_back(wire(6, {{3, 0}}));
  const Arrangement a = arrange(sheet);
  EXPECT_THAT(faults(sheet, a), IsEmpty());
  const PlacedBlock &d = placed(sheet, a, "d"), &sum = placed(sheet, a, "sum");
  EXPECT_NEAR((d.box.left + d.box.right) / 2, (sum.box.left + sum.box.right) / 2, 1e-9);
  EXPECT_LT(d.box.bottom, sum.box.top);
  EXPECT_THAT(path_names(sheet, a), ElementsAre("r", "e", "controller", "sum", "plant"));
}

TEST(Layout, NestsTheInnerLoopOfACascadeAboveTheOuterOne) {
  Sheet sheet;
  sheet.blocks = {box("r", {}),
                  circle("e1", {"+", "−"}),
                  box("outer", {""}, true),
                  circle("e2", {"+", "−"}),
                  box("inner", {""}, true),
                  box("motor", {""}, true),
                  box("load", {""}, true),
                  box("s1", {""}),
                  box("s2", {""})};
  sheet.wires = {wire(0, {{1, 0}}),       wire(1, {{2, 0}}), wire(2, {{3, 0}}),
                 wire(3, {{4, 0}}),       wire(4, {{5, 0}}), wire(5, {{6, 0}, {8, 0}}),
                 wire(6, {{7, 0}}, true), wire(7, {{1, 1}}), wire(8, {{3, 1}})};
  const Arrangement a = arrange(sheet);
  EXPECT_THAT(faults(sheet, a), IsEmpty());
  EXPECT_THAT(path_names(sheet, a), ElementsAre("r", "e1", "outer", "e2", "inner", "motor", "load"));
  EXPECT_LT(placed(sheet, a, "s2").box.bottom, placed(sheet, a, "s1").box.top + 1);
}

TEST(Layout, SplitsASumThatClosesTwoLoopsTheOuterOneFirst) {
  // x'' = u - a x' - b x
  Sheet sheet;
  sheet.blocks = {box("u", {}),         circle("sum", {"+", "−", "−"}),
                  box("v", {""}, true), box("x", {""}, true),
                  box("a", {""}),       box("b", {""})};
  sheet.wires = {wire(0, {{1, 0}}),       wire(1, {{2, 0}}), wire(2, {{3, 0}, {4, 0}}),
                 wire(3, {{5, 0}}, true), wire(4, {{1, 1}}), wire(5, {{1, 2}})};
  const Arrangement arranged = arrange(sheet);
  EXPECT_THAT(faults(sheet, arranged), IsEmpty());
  std::vector<const PlacedBlock*> circles;
  for (const PlacedBlock& b : arranged.blocks)
    if (b.shape == Shape::circle) circles.push_back(&b);
  ASSERT_EQ(circles.size(), 2u);
  EXPECT_LT(placed(sheet, arranged, "a").box.bottom, placed(sheet, arranged, "b").box.top);
}

TEST(Layout, DrawsRandomSheetsWithoutFaults) {
  for (std::uint32_t seed = 0; seed < 150; ++seed) {
    const Sheet sheet = random_sheet(seed, 3 + static_cast<int>(seed % 20));
    // Nobody counts the bends of such a tangle.
    std::vector<std::string> found = faults(sheet, arrange(sheet));
    std::erase_if(found, [](const std::string& text) { return text.find(" bends on its way ") != std::string::npos; });
    EXPECT_THAT(found, IsEmpty()) << "seed " << seed;
  }
}

TEST(Layout, DoesNotDependOnTheOrderOfBlocksAndWires) {
  for (std::uint32_t seed = 0; seed < 20; ++seed) {
    const Sheet sheet = random_sheet(seed, 12);
    std::vector<int> order(sheet.blocks.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<int>(i);
    std::minstd_rand random(seed);
    std::shuffle(order.begin(), order.end(), random);
    std::vector<int> place(order.size());
    Sheet shuffled;
    shuffled.title = sheet.title;
    for (std::size_t i = 0; i < order.size(); ++i) {
      place[static_cast<std::size_t>(order[i])] = static_cast<int>(i);
      shuffled.blocks.push_back(sheet.blocks[static_cast<std::size_t>(order[i])]);
    }
    for (SheetWire w : sheet.wires) {
      w.from.block = place[static_cast<std::size_t>(w.from.block)];
      for (SheetPort& to : w.to) to.block = place[static_cast<std::size_t>(to.block)];
      std::reverse(w.to.begin(), w.to.end());
      shuffled.wires.insert(shuffled.wires.begin(), std::move(w));
    }
    EXPECT_EQ(hash(draw(sheet, arrange(sheet))), hash(draw(shuffled, arrange(shuffled)))) << "seed " << seed;
  }
}

}  // namespace
}  // namespace plantloop
