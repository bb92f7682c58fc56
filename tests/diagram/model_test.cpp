// Models: what the sections of a diagram mean.

#include "engine/diagram/model.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "engine/base/files.h"

namespace plantloop {
namespace {

std::shared_ptr<const Model> read(const std::string& text) {
  Report report;
  auto model = read_model_text(text, "tests/diagram/test.yaml", report);
  EXPECT_EQ(to_text(report), "");
  return model;
}

std::string shown(const ExpressionPtr& e) { return e ? to_string(*e) : "null"; }

TEST(Model, BlocksAreInstancesOrExpressions) {
  const auto model = read(R"(
plantloop: 1
title: Two blocks
blocks:
  y: {type: integrator, in: u - y, initial: 2, rate: 0.1, unit: m/s, doc: speed, priority: 3}
  u: 2*y
  v: [u, y, 1 + 2]
  w: {expr: u, rate: {period: 1/3, offset: 0.1}, unit: N m}
)");
  const auto& blocks = model->top->blocks;
  ASSERT_EQ(blocks.size(), 4U);
  EXPECT_EQ(blocks[0].type, "integrator");
  EXPECT_EQ(shown(blocks[0].in[0].items[0]), "u - y");
  EXPECT_EQ(blocks[0].fields.size(), 1U);
  EXPECT_EQ(blocks[0].fields[0].name, "initial");
  EXPECT_EQ(shown(blocks[0].period), "0.1");
  EXPECT_EQ(blocks[0].priority, 3);
  EXPECT_EQ(blocks[1].type, "expression");
  EXPECT_EQ(shown(blocks[1].expression), "2*y");
  EXPECT_EQ(blocks[1].in.size(), 1U);
  EXPECT_EQ(shown(blocks[2].expression), "[u, y, 1 + 2]");
  EXPECT_TRUE(blocks[2].in[0].is_sequence);
  EXPECT_EQ(shown(blocks[3].offset), "0.1");
  EXPECT_EQ(blocks[3].unit, "N m");
  EXPECT_EQ(model->title, "Two blocks");
  EXPECT_FALSE(model->has_simulation);
  EXPECT_FALSE(model->is_library);
}

TEST(Model, WiresAreNamedOrFeedTheOnlyPort) {
  const auto model = read(
      "plantloop: 1\nblocks:\n  a: {type: add, in: [x, [1, 2], y.1]}\n  b: {type: plant, in: {u1: a, u2: [a, 3]}}\n");
  const auto& a = model->top->blocks[0].in;
  ASSERT_EQ(a.size(), 1U);
  EXPECT_EQ(a[0].port, "");
  EXPECT_EQ(shown(a[0].items[1]), "[1, 2]");
  const auto& b = model->top->blocks[1].in;
  ASSERT_EQ(b.size(), 2U);
  EXPECT_EQ(b[1].port, "u2");
  EXPECT_TRUE(b[1].is_sequence);
  EXPECT_EQ(b[1].items.size(), 2U);
}

TEST(Model, ResetsAndReservedKeysAreKept) {
  const auto model = read(R"(
plantloop: 1
blocks:
  h: {type: integrator, in: v, reset: {when: h <= 0, to: -0.8*h}}
  c: {type: gain, in: 1, enable: {when: a > 0, outputs: reset}, repeat: 3, first: {u: 1}, zero_crossing: false}
)");
  const auto& blocks = model->top->blocks;
  ASSERT_TRUE(blocks[0].reset);
  EXPECT_EQ(blocks[0].reset->edge, "rising");
  EXPECT_EQ(shown(blocks[0].reset->to), "-0.8*h");
  EXPECT_TRUE(blocks[1].enable && blocks[1].repeat && blocks[1].first && !blocks[1].last);
  EXPECT_FALSE(blocks[1].zero_crossing);
}

TEST(Model, ParametersHaveValuesUnitsOrTexts) {
  const auto model = read(
      "plantloop: 1\nparameters:\n  Q: 29.46\n  b: {value: Q/2, unit: m, doc: half}\n  net: {text: models/a.yaml}\n"
      "  A: [[1, 2], [3, Q]]\nblocks: {y: Q}\n");
  const auto& p = model->top->parameters;
  EXPECT_EQ(shown(p[0].value), "29.46");
  EXPECT_EQ(p[1].unit, "m");
  EXPECT_EQ(p[1].doc, "half");
  EXPECT_EQ(p[2].value, nullptr);
  EXPECT_EQ(p[2].text, "models/a.yaml");
  EXPECT_EQ(shown(p[3].value), "[[1, 2], [3, Q]]");
}

TEST(Model, TypesHaveInputsAndOutputs) {
  const auto model = read(R"(
plantloop: 1
types:
  t:
    doc: a lag
    parameters: {k: 1}
    inputs: {u: , d: {default: 0, size: 2, unit: N}}
    blocks: {y: k*u}
    outputs: {y: y, z: {from: 2*y, initial: 0}}
  s: {inputs: [a, b], blocks: {c: a + b}, outputs: [c]}
)");
  EXPECT_TRUE(model->is_library);
  const TypeDecl& t = *model->files[0]->types.at("t");
  EXPECT_EQ(t.inputs[0].fallback, nullptr);
  EXPECT_EQ(shown(t.inputs[1].fallback), "0");
  EXPECT_EQ(t.inputs[1].size, 2);
  EXPECT_EQ(shown(t.outputs[1].initial), "0");
  EXPECT_EQ(t.file, model->files[0].get());
  const TypeDecl& s = *model->files[0]->types.at("s");
  EXPECT_EQ(s.inputs.size(), 2U);
  EXPECT_EQ(shown(s.outputs[0].from), "c");
}

TEST(Model, SimulationRecordAndChecksAreRead) {
  const auto model = read(
      "plantloop: 1\nblocks: {y: 1}\nsimulation: {stop: 2*T, solver: bdf, zeno: hold, loops: error, strict: true}\n"
      "record: {a.1: y, b: 2*y}\nchecks: {units: note}\n");
  EXPECT_EQ(shown(model->simulation.stop), "2*T");
  EXPECT_EQ(model->simulation.start, nullptr);
  EXPECT_EQ(model->simulation.solver, "bdf");
  EXPECT_EQ(model->simulation.zeno, "hold");
  EXPECT_EQ(model->simulation.loops, "error");
  EXPECT_TRUE(model->simulation.strict);
  EXPECT_EQ(model->record[0].column, "a.1");
  EXPECT_EQ(shown(model->record[1].signal), "2*y");
  EXPECT_EQ(model->checks.at("units"), "note");
}

TEST(Model, ExpectationsHaveShortForms) {
  const auto model = read(R"(
plantloop: 1
blocks: {y: 1}
expect:
  - {signal: y, at: t1, side: left, value: 2, abs: 1e-3}
  - {signal: y, at: 3, between: [1, 2]}
  - {signal: y, max: 3}
  - {signal: y, min: 1, from: 2}
  - {signal: y, final: 1, rel: 1e-3}
  - {signal: y, measure: overshoot, step: {at: 0, from: 0, to: 1}, below: 5}
  - {event: y.reset, count: 4}
  - {baseline: y.csv}
)");
  const auto& e = model->expect;
  ASSERT_EQ(e.size(), 8U);
  EXPECT_EQ(e[0].measure, "at");
  EXPECT_EQ(e[0].side, "left");
  EXPECT_EQ(e[0].text, "{signal: y, at: t1, side: left, value: 2, abs: 1e-3}");
  EXPECT_EQ(shown(e[1].upper), "2");
  EXPECT_EQ(e[2].measure, "max");
  EXPECT_EQ(shown(e[2].upper), "3");
  EXPECT_EQ(shown(e[3].lower), "1");
  EXPECT_EQ(shown(e[4].value), "1");
  EXPECT_EQ(shown(e[4].rel), "1e-3");
  EXPECT_EQ(shown(e[5].step_to), "1");
  EXPECT_EQ(e[6].event, "y.reset");
  EXPECT_EQ(shown(e[6].value), "4");
  EXPECT_EQ(e[7].baseline, "y.csv");
}

TEST(Model, FiguresHavePanelsWithEverything) {
  const auto model = read(R"(
plantloop: 1
blocks: {y: 1}
figures:
  f:
    title: T
    x: {label: "time [s]", limits: [0, 6]}
    panels:
      - {y: [y, {signal: 2*y, label: two, style: dashed}], label: "y [m]", limits: [0, 1], lines: [{x: 0.5}], equal: true}
      - {y: [y, y], labels: [one, other], right: y, right_label: r, bands: [{lower: 0, upper: 1, until: 2}]}
)");
  const FigureDecl& figure = model->figures[0];
  const FigureBlock& x = figure.says.parts("x")[0];
  EXPECT_EQ(x.text("label"), "time [s]");
  EXPECT_EQ(shown(x.find("limits")->numbers[1]), "6");
  const std::vector<FigureBlock>& panels = figure.says.parts("panels");
  EXPECT_EQ(panels[0].parts("y")[1].text("style"), "dashed");
  EXPECT_EQ(shown(panels[0].find("limits")->numbers[1]), "1");
  EXPECT_TRUE(panels[0].flag("equal"));
  EXPECT_EQ(shown(panels[0].parts("lines")[0].number("x")), "0.5");
  EXPECT_EQ(panels[1].find("labels")->texts[1], "other");
  EXPECT_EQ(panels[1].parts("right").size(), 1U);
  EXPECT_EQ(shown(panels[1].parts("bands")[0].number("until")), "2");
  EXPECT_EQ(figure.signals().size(), 5U);
  EXPECT_EQ(figure.numbers().size(), 8U);
}

TEST(Model, FiguresHaveThePlotTypesThatTheReaderIsGiven) {
  const FigureWords stem{"stem",
                         {{.name = "x", .kind = FigureWord::Kind::column, .doc = "where", .needed = true},
                          {.name = "z", .kind = FigureWord::Kind::grid, .doc = "what"}}};
  const PlotWords plots{{.name = "stem", .kind = FigureWord::Kind::plot, .doc = "stems", .parts = &stem}};
  const std::string text =
      "plantloop: 1\nblocks: {y: 1}\nfigures: {f: {panels: [{stem: [{x: y, z: [[1, 2], [3, 4]]}, {x: [1, 2*3]}]}]}}\n";
  Report report;
  const auto model = read_model_text(text, "test.yaml", report, plots);
  EXPECT_EQ(to_text(report), "");
  const std::vector<FigureBlock>& uses = model->figures[0].says.parts("panels")[0].parts("stem");
  ASSERT_EQ(uses.size(), 2U);
  EXPECT_EQ(shown(uses[0].find("x")->signal), "y");
  EXPECT_EQ(uses[0].find("z")->columns, 2U);
  EXPECT_EQ(shown(uses[1].find("x")->numbers[1]), "2*3");
  Report without;
  read_model_text(text, "test.yaml", without);
  EXPECT_NE(to_text(without).find("a panel has no key 'stem'"), std::string::npos);
}

// A folder of its own below the system's temporary one, gone afterwards.
class Imports : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (std::filesystem::temp_directory_path() / "plantloop-XXXXXX").string();
    folder_ = ::mkdtemp(name.data());
    std::filesystem::create_directory(folder_ / "parts");
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::string write(const std::string& name, const std::string& text) {
    EXPECT_EQ(write_file((folder_ / name).string(), text), "");
    return (folder_ / name).string();
  }
  std::filesystem::path folder_;
};

constexpr const char* library = "plantloop: 1\ntypes:\n  lag: {inputs: [u], blocks: {y: u}, outputs: [y]}\n";

TEST_F(Imports, BringTheTypesWrittenInAFileButNotWhatItImports) {
  write("parts/deep.yaml", "plantloop: 1\ntypes:\n  deep: {blocks: {y: 1}, outputs: [y]}\n");
  write("parts/lag.yaml", std::string(library) + "import: [deep.yaml]\n");
  const std::string path =
      write("a.yaml",
            "plantloop: 1\nimport: {std: parts/lag.yaml, d: parts/deep.yaml}\nblocks: {y: {type: std.lag, in: 1}}\n");
  Report report;
  const auto model = read_model(path, report);
  EXPECT_EQ(to_text(report), "");
  const auto& types = model->top->file->types;
  EXPECT_EQ(types.size(), 2U);
  EXPECT_TRUE(types.contains("std.lag"));
  EXPECT_TRUE(types.at("std.lag")->file->types.contains("deep"));
  EXPECT_EQ(types.at("d.deep"), types.at("std.lag")->file->types.at("deep"));
  EXPECT_EQ(model->files.size(), 3U);
}

TEST_F(Imports, StayInsideTheProjectAlsoThroughLinks) {
  const std::string outside = write("lag.yaml", library);
  std::filesystem::create_directory(folder_ / "project");
  std::filesystem::create_symlink(outside, folder_ / "project" / "link.yaml");
  const std::string path = write("project/a.yaml", "plantloop: 1\nimport: [link.yaml]\nblocks: {y: 1}\n");
  Report report;
  read_model(path, report);
  EXPECT_NE(to_text(report).find("it lies outside of the project"), std::string::npos);
  write("plantloop.yaml", "");
  Report wider;
  const auto model = read_model(path, wider);
  EXPECT_EQ(to_text(wider), "");
  EXPECT_EQ(model->project, std::filesystem::canonical(folder_).string());
}

TEST_F(Imports, OfWrongFilesShowTheirFindings) {
  write("parts/lag.yaml", "plantloop: 1\ntypes:\n  lag: {blocks: {y: 2x}, outputs: [y]}\n");
  const std::string path = write("a.yaml", "plantloop: 1\nimport: [parts/lag.yaml]\nblocks: {y: 1}\n");
  Report report;
  read_model(path, report);
  EXPECT_NE(to_text(report).find("parts/lag.yaml:3:21: error: '2x'"), std::string::npos) << to_text(report);
}

TEST(Model, AFileThatIsNotThereIsAFinding) {
  Report report;
  EXPECT_EQ(read_model("tests/none.yaml", report), nullptr);
  EXPECT_EQ(to_text(report), "error: cannot read 'tests/none.yaml': there is no such file\n");
}

}  // namespace
}  // namespace plantloop
