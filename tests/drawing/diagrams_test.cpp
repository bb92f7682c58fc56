// All diagrams of the project as drawings, closed, open and from inside.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>

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

const SheetBlock& block(const Sheet& sheet, const std::string& path) {
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

TEST(Drawing, ShowsTransferFunctionsWithTheirNumbersAndNames) {
  const auto graph = graph_of_text(
      "parameters: {k: 5}\nblocks:\n  u: {type: step, time: 1}\n"
      "  plant: {type: transfer_function, in: u, num: [k], den: [1, 0.4, 0]}\n"
      "  lag: {type: first_order, in: plant, tau: 0.1}\n");
  const Sheet sheet = sheet_of(*graph, 0, {});
  EXPECT_EQ(spoken(block(sheet, "plant").formula), "(k)/(s^{2} + 0.4 s)");
  EXPECT_EQ(spoken(block(sheet, "lag").formula), "(1)/(0.1 s + 1)");
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
