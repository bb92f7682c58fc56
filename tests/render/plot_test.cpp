// What holds for every plot type, whatever it is given.

#include "render/plots/plot.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <functional>
#include <limits>

#include "render/error.h"
#include "render/layout.h"
#include "render/scene/dump.h"
#include "render/scene/lint.h"

namespace plantloop {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using Kind = PlotInput::Kind;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double inf = std::numeric_limits<double>::infinity();

struct Hostile {
  std::string name;
  std::vector<double> values;
};

std::vector<Hostile> hostile() {
  std::vector<Hostile> all{
      {"empty", {}},
      {"single", {2}},
      {"constant", {3, 3, 3, 3, 3}},
      {"zero", {0, 0, 0}},
      {"nan", {nan, nan, nan}},
      {"gaps", {1, nan, 2, inf, 3, -inf, 4}},
      {"huge", {-1.7e308, 1e300, 1.7e308, -1e300}},
      {"tiny", {1e-308, 3e-308, 5e-324, 2e-308}},
      {"negative", {-5, -4, -3, -2}},
      {"falling", {9, 7, 4, 2, 1, 0.5}},
      {"large mean", {1e9, 1e9 + 1e-3, 1e9 + 2e-3}},
  };
  Hostile long_one{"long", {}};
  for (int i = 0; i < 80; ++i) long_one.values.push_back(std::sin(0.7 * i) * (1 + 0.01 * i));
  all.push_back(long_one);
  return all;
}

// Every required input, and with `all` every other column, too, made of the values.
Given given_all(const Plot& plot, const std::vector<double>& values, bool all) {
  Given given(plot);
  for (const PlotInput& input : plot.inputs()) {
    if (input.need == Need::optional && !all) continue;
    if (input.kind == Kind::column) given.set(input.name, values);
    if (input.kind == Kind::grid) {
      GridValues grid{values.size(), values.size(), {}};
      for (const double a : values)
        for (const double b : values) grid.values.push_back(0.5 * a + 0.3 * b);
      given.set(input.name, grid);
    }
  }
  given.look.label = "data";
  return given;
}

// Draws, or says what is wrong in words.
void expect_picture_or_words(const Plot& plot, Figure figure, const Given& given, const std::string& what) {
  try {
    Canvas canvas(figure, 0);
    canvas.panel();
    plot.draw(canvas, given);
  } catch (const RenderError& e) {
    EXPECT_GT(std::string(e.what()).size(), 15u) << what;
    return;
  }
  const Scene scene = layout(figure);
  EXPECT_THAT(lint(scene), IsEmpty()) << what;
  EXPECT_EQ(hash(scene), hash(layout(figure))) << what;
}

TEST(Plots, AreManyAndSortedByName) {
  ASSERT_GT(plots().size(), 25u);
  for (std::size_t i = 0; i + 1 < plots().size(); ++i) EXPECT_LT(plots()[i]->name(), plots()[i + 1]->name());
  EXPECT_EQ(find_plot("stem")->name(), "stem");
  EXPECT_EQ(find_plot("pie"), nullptr);
}

TEST(Plots, StandInTheGuide) {
  std::ifstream file("docs/guide.md");
  const std::string guide{std::istreambuf_iterator<char>(file), {}};
  for (const Plot* plot : plots()) EXPECT_THAT(guide, HasSubstr(fmt::format("`{}(", plot->name())));
}

TEST(Plots, SayWhatTheyShowAndWhatTheyAreGiven) {
  for (const Plot* plot : plots()) {
    EXPECT_GT(plot->summary().size(), 5u) << plot->name();
    EXPECT_FALSE(plot->inputs().empty()) << plot->name();
    for (const PlotInput& input : plot->inputs()) {
      EXPECT_GT(input.doc.size(), 3u) << plot->name() << '.' << input.name;
      for (const char* taken : {"label", "style", "marker", "color", "width", "opacity", "size", "right"})
        EXPECT_NE(input.name, taken) << plot->name();
    }
  }
}

TEST(Plots, DrawAnyNumbersOrSayWhatIsWrong) {
  for (const Plot* plot : plots())
    for (const auto& [name, values] : hostile())
      for (const bool all : {false, true})
        expect_picture_or_words(*plot, Figure{.title = name}, given_all(*plot, values, all),
                                fmt::format("{}, {}{}", plot->name(), name, all ? ", all inputs" : ""));
}

TEST(Plots, DrawAnyNumbersOnLogarithmicAxes) {
  for (const Plot* plot : plots())
    for (const auto& [name, values] : hostile())
      for (const Scale scale : {Scale::log, Scale::symlog}) {
        Figure figure{.title = name};
        figure.add_panel({.x = Axis{.scale = scale}, .y = {.scale = scale}});
        expect_picture_or_words(*plot, figure, given_all(*plot, values, false),
                                fmt::format("{}, {}, {}", plot->name(), name, scale == Scale::log ? "log" : "symlog"));
      }
}

// Labels that nobody means: endless, broken as TeX and as UTF-8, with control characters, of other scripts.
TEST(Plots, TakeAbsurdLabels) {
  std::vector<std::string> absurd{" ",
                                  "\\frac{",
                                  "\\sqrt{\\frac{a}{",
                                  "x_",
                                  "^^^___{{{}}}",
                                  "a_{b_{c_{d_{e_{f}}}}}",
                                  "\xff\xfe\x80",
                                  "a\nb\tc\x01",
                                  "مرحبا 世界 🚀",
                                  "[[[]",
                                  "\\hat{\\bar{\\dot{x}}}"};
  absurd.push_back(std::string(3000, 'W'));
  std::string words;
  for (int i = 0; i < 300; ++i) words += "word ";
  absurd.push_back(words);
  for (const Plot* plot : plots())
    for (const std::string& label : absurd) {
      Figure figure{.title = label};
      figure.x.label = label;
      figure.add_panel({.title = label, .y = {.label = label}});
      figure.panels[0].lines.push_back({.at = 1, .label = label});
      figure.panels[0].callouts.push_back({.x = 1, .y = 2, .label = label});
      Given given = given_all(*plot, {1, 2, 4, 3}, false);
      given.look.label = label;
      expect_picture_or_words(*plot, figure, given, fmt::format("{}, '{}'", plot->name(), label.substr(0, 20)));
    }
}

TEST(Plots, AreDrawnThreeHundredTimesInOnePanel) {
  for (const Plot* plot : plots()) {
    Figure figure;
    try {
      for (int i = 0; i < 300; ++i) {
        Given given = given_all(*plot, {1.0 + i, 2, 4.0 + 0.1 * i, 3}, false);
        given.look.label = fmt::format("series {}", i);
        Canvas canvas(figure, 0);
        canvas.panel();
        plot->draw(canvas, given);
      }
    } catch (const RenderError& e) {
      EXPECT_GT(std::string(e.what()).size(), 15u) << plot->name();
      continue;
    }
    EXPECT_THAT(lint(layout(figure)), IsEmpty()) << plot->name();
  }
}

TEST(Plots, GoOnTheRightAxis) {
  for (const Plot* plot : plots()) {
    Figure figure;
    figure.add_panel().line({0, 1}, {0, 5}, {.label = "left"});
    Given given = given_all(*plot, {1, 2, 4, 3}, false);
    given.right = true;
    expect_picture_or_words(*plot, figure, given, std::string(plot->name()));
  }
}

TEST(Plots, DifferInColoursOnlyBetweenThemes) {
  const auto shape = [](Scene scene) {
    std::function<void(Group&)> strip = [&](Group& g) {
      for (SceneNode& node : g.children) {
        if (auto* inner = std::get_if<Group>(&node.item)) strip(*inner);
        if (auto* fill = std::get_if<Fill>(&node.item)) fill->color = {};
        if (auto* stroke = std::get_if<Stroke>(&node.item)) stroke->color = {}, stroke->width = 1, stroke->dashes = {};
        if (auto* text = std::get_if<TextRun>(&node.item)) text->color = text->background = {};
      }
    };
    strip(scene.root);
    scene.background = {};
    return hash(scene);
  };
  for (const char* name : {"stem", "nichols", "contour", "step_response", "network"}) {
    Figure figure = find_plot(name)->example();
    const std::uint64_t light = shape(layout(figure));
    figure.theme = "dark";
    EXPECT_EQ(light, shape(layout(figure))) << name;
  }
}

TEST(Plots, SayWhichColumnsDiffer) {
  Figure figure;
  const auto complaint = [&](std::string_view type,
                             std::initializer_list<std::pair<std::string_view, PlotValue>> values) {
    try {
      find_plot(type)->use(figure, 0, values);
    } catch (const RenderError& e) {
      return std::string(e.what());
    }
    return std::string("no error");
  };
  const std::vector<double> two{1, 2}, three{1, 2, 3};
  EXPECT_EQ(complaint("stem", {{"x", two}, {"y", three}}), "x has 2 numbers and y has 3");
  EXPECT_EQ(complaint("stem", {{"x", two}}), "'y' is missing: how far they reach");
  EXPECT_EQ(complaint("stem", {{"z", two}}), "stem has no 'z'");
  EXPECT_EQ(complaint("bode", {}), "this needs 'num' and 'den', or 'w', 're' and 'im'");
  EXPECT_EQ(complaint("bode", {{"num", two}, {"den", std::vector<double>{0, 0}}}),
            "'num' and 'den' must have a coefficient that is not zero");
  EXPECT_EQ(complaint("bode", {{"num", two}, {"den", two}, {"delay", -1.0}}), "'delay' must be 0 or greater");
  EXPECT_EQ(complaint("error_bars", {{"x", two}, {"y", two}}), "error_bars needs 'error', or 'lower' and 'upper'");
  EXPECT_EQ(complaint("heat_map", {{"z", GridValues{1, 2, {1, 2}}}, {"map", std::string("rainbow")}}),
            "'map' must be viridis, diverging, gray or tint, it is 'rainbow'");
  EXPECT_EQ(complaint("heat_map", {{"z", GridValues{1, 2, {1, 2}}}, {"x", three}}),
            "x has 3 numbers and z has 2 columns");
  EXPECT_EQ(complaint("bar", {{"y", two}, {"names", std::vector<std::string>{"a"}}}),
            "y has 2 numbers and names has 1");
  EXPECT_EQ(complaint("spectrum", {{"y", two}, {"period", 0.0}}), "'period' must be greater than 0");
  EXPECT_EQ(complaint("network", {{"layers", two}, {"weights", three}}),
            "these layers have 2 connections and weights has 3");
  EXPECT_EQ(complaint("network", {{"layers", std::vector<double>{1.5}}}),
            "'layers' must be whole numbers from 1 to 500");
}

std::size_t nodes(const Group& group) {
  std::size_t count = 0;
  for (const SceneNode& node : group.children) {
    const auto* inner = std::get_if<Group>(&node.item);
    count += inner ? nodes(*inner) : 1;
    if (const auto* fill = std::get_if<Fill>(&node.item)) count += fill->rings.size();
    if (const auto* stroke = std::get_if<Stroke>(&node.item))
      for (const Polyline& line : stroke->lines) count += line.size();
  }
  return count;
}

// A million samples leave a scene that is as small as the picture.
TEST(Plots, OfAMillionPointsAreNotLargerThanThePicture) {
  std::vector<double> x, y, z;
  std::uint32_t state = 5;
  for (int i = 0; i < 1000000; ++i) {
    state = state * 1664525u + 1013904223u;
    x.push_back(i);
    y.push_back(std::sin(0.001 * i) + static_cast<double>(state >> 8) / 16777216.0);
    z.push_back(std::cos(0.0137 * i));
  }
  Figure lines, points, space;
  lines.add_panel().line(x, y);
  find_plot("scatter")->use(points, 0, {{"x", z}, {"y", y}});
  find_plot("trajectory")->use(space, 0, {{"x", z}, {"y", y}, {"z", x}});
  EXPECT_LT(nodes(layout(lines).root), 6000u);
  EXPECT_LT(nodes(layout(points).root), 90000u);
  EXPECT_LT(nodes(layout(space).root), 110000u);
}

// The callouts of a step response are those of the closed form: overshoot exp(-pi zeta / sqrt(1 - zeta^2)) at
// pi / (wn sqrt(1 - zeta^2)).
TEST(Plots, CallOutTheMeasuresOfASecondOrderLag) {
  std::vector<double> t, y;
  const double zeta = 0.5, wn = 2, wd = wn * std::sqrt(1 - zeta * zeta);
  for (int i = 0; i <= 100000; ++i) {
    const double s = 1e-4 * i;
    t.push_back(s);
    y.push_back(1 - std::exp(-zeta * wn * s) * (std::cos(wd * s) + zeta * wn / wd * std::sin(wd * s)));
  }
  Figure figure;
  find_plot("step_response")->use(figure, 0, {{"t", t}, {"y", y}, {"to_value", 1.0}});
  const std::vector<Callout>& callouts = figure.panels[0].callouts;
  ASSERT_EQ(callouts.size(), 3u);
  EXPECT_EQ(callouts[0].label, "overshoot 16.3 % at 1.81 s");
  EXPECT_NEAR(callouts[0].x, 3.14159265358979 / wd, 1e-3);
  EXPECT_NEAR(callouts[0].y, 1 + std::exp(-3.14159265358979 * zeta / std::sqrt(1 - zeta * zeta)), 1e-7);
  EXPECT_EQ(callouts[1].label, "rise time 0.819 s");  // 1.64 / wn for this damping, Ogata
  EXPECT_EQ(callouts[2].label, "settled after 4.04 s");
}

TEST(Plots, CompareWithAFitOfAHundredForTheTruthAndZeroForItsMean) {
  Figure figure;
  find_plot("comparison")
      ->use(figure, 0,
            {{"x", std::vector<double>{0, 1, 2}},
             {"measured", std::vector<double>{1, 2, 3}},
             {"models", GridValues{3, 2, {1, 2, 2, 2, 3, 2}}},
             {"names", std::vector<std::string>{"truth", "mean"}}});
  EXPECT_EQ(figure.panels[0].series[1].look.label, "truth, fit 100.0 %");
  EXPECT_EQ(figure.panels[0].series[2].look.label, "mean, fit 0.0 %");
}

}  // namespace
}  // namespace plantloop
