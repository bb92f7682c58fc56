// Facts about scenes that layout makes.

#include "render/scene/scene.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <stdexcept>

#include "render/error.h"
#include "render/geometry/curve.h"
#include "render/layout.h"
#include "render/scene/dump.h"
#include "render/scene/lint.h"
#include "tests/render/figures.h"

namespace plantloop {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

const Group* find(const Group& group, const std::string& role) {
  if (group.role == role) return &group;
  for (const SceneNode& node : group.children)
    if (const auto* inner = std::get_if<Group>(&node.item))
      if (const Group* found = find(*inner, role)) return found;
  return nullptr;
}

std::vector<std::string> texts(const Group& group) {
  std::vector<std::string> result;
  for (const SceneNode& node : group.children) {
    if (const auto* text = std::get_if<TextRun>(&node.item)) result.push_back(text->source);
    if (const auto* inner = std::get_if<Group>(&node.item))
      for (const std::string& t : texts(*inner)) result.push_back(t);
  }
  return result;
}

std::vector<std::string> texts_of(const Scene& scene, const std::string& role) {
  const Group* group = find(scene.root, role);
  return group ? texts(*group) : std::vector<std::string>{};
}

const Stroke& stroke_of(const Scene& scene, const std::string& role) {
  for (const SceneNode& node : find(scene.root, role)->children)
    if (const auto* stroke = std::get_if<Stroke>(&node.item)) return *stroke;
  throw std::logic_error("no stroke in " + role);
}

TEST(Scene, OfEveryTestFigureIsWithoutFault) {
  for (const auto& [name, figure] : test_figures())
    for (const std::string theme : {"light", "dark", "print"}) {
      Figure themed = figure;
      themed.theme = theme;
      EXPECT_THAT(lint(layout(themed)), IsEmpty()) << name << ", " << theme;
    }
}

TEST(Scene, IsWithoutFaultInManySizes) {
  for (const auto& [name, figure] : test_figures())
    for (const double width : {86.0, 120.0, 178.0, 300.0}) {
      Figure sized = figure;
      sized.width = width;
      sized.height = 0;
      EXPECT_THAT(lint(layout(sized)), IsEmpty()) << name << ", " << width << " mm";
    }
}

TEST(Scene, OfRandomFiguresIsWithoutFault) {
  for (std::uint32_t seed = 0; seed < 400; ++seed) EXPECT_THAT(lint(layout(random_figure(seed))), IsEmpty()) << seed;
}

TEST(Scene, IsTheSameForTheSameFigure) {
  for (const auto& [name, figure] : test_figures()) EXPECT_EQ(hash(layout(figure)), hash(layout(figure))) << name;
}

TEST(Scene, DiffersInColoursOnlyBetweenThemes) {
  Figure figure = noisy_steps();
  std::string light = to_json(layout(figure), 100);
  figure.theme = "dark";
  std::string dark = to_json(layout(figure), 100);
  const auto without_colours = [](std::string text) {
    for (std::size_t at = 0; (at = text.find('#', at)) != std::string::npos;) text.erase(at, 7);
    return text;
  };
  // The fourth and fifth colour are thicker on white, where they are pale: compare up to the data.
  light = without_colours(light).substr(0, 3000);
  dark = without_colours(dark).substr(0, 3000);
  EXPECT_EQ(light, dark);
}

TEST(Scene, NamesTheFontsAndTheirHashes) {
  const Scene scene = layout(Figure{});
  ASSERT_EQ(scene.fonts.size(), 3u);
  EXPECT_EQ(scene.fonts[0].name, "Inter");
  EXPECT_EQ(scene.fonts[0].sha256.size(), 64u);
}

TEST(Scene, HasTheSizeInMillimetresTimesTheResolution) {
  const Scene scene = layout(Figure{.width = 86, .height = 60, .dpi = 300});
  EXPECT_EQ(scene.width, 1016);
  EXPECT_EQ(scene.height, 709);
}

TEST(Scene, ShowsTimeOnlyBelowTheLowestOfThePanelsThatShareIt) {
  Figure figure;
  figure.x.label = "time [s]";
  for (int i = 0; i < 3; ++i) figure.add_panel().line({0, 1}, {0, 1});
  figure.add_panel({.x = Axis{.label = "x"}}).line({0, 5}, {0, 1});
  const Scene scene = layout(figure);
  EXPECT_EQ(find(scene.root, "panel/0/x/ticks"), nullptr);
  EXPECT_EQ(find(scene.root, "panel/1/x/ticks"), nullptr);
  EXPECT_NE(find(scene.root, "panel/2/x/ticks"), nullptr);
  EXPECT_THAT(texts_of(scene, "panel/2/x/label"), ElementsAre("time [s]"));
  EXPECT_THAT(texts_of(scene, "panel/3/x/label"), ElementsAre("x"));
}

TEST(Scene, AlignsTheTimeAxesOfItsPanels) {
  Figure figure;
  figure.add_panel({.y = {.label = "a"}}).line({0, 4}, {0, 123456});
  figure.add_panel().line({1, 2}, {0, 1});
  const Scene scene = layout(figure);
  const Polyline a = stroke_of(scene, "panel/0/axes").lines[0], b = stroke_of(scene, "panel/1/axes").lines[0];
  EXPECT_EQ(a[1].x, b[1].x);
  EXPECT_EQ(a[2].x, b[2].x);
  // x = 1 to 2 of a shared axis from 0 to 4.
  const Polyline line = stroke_of(scene, "panel/1/series/0").lines[0];
  EXPECT_NEAR(line.front().x, b[1].x + (b[2].x - b[1].x) / 4.0, 2);
  EXPECT_NEAR(line.back().x, b[1].x + (b[2].x - b[1].x) / 2.0, 2);
}

TEST(Scene, DrawsAJumpVertically) {
  Figure figure;
  figure.add_panel().line({0, 1, 1, 2}, {0, 0, 1, 1});
  const Polyline line = stroke_of(layout(figure), "panel/0/series/0").lines[0];
  ASSERT_EQ(line.size(), 4u);
  EXPECT_EQ(line[1].x, line[2].x);
}

TEST(Scene, HoldsADiscreteSignalUntilTheEnd) {
  Figure figure;
  Panel& panel = figure.add_panel();
  panel.stairs({0, 1, 2}, {0, 2, 1});
  panel.line({0, 4}, {0, 0});
  const Scene scene = layout(figure);
  const Polyline line = stroke_of(scene, "panel/0/series/0").lines[0];
  ASSERT_EQ(line.size(), 6u);
  for (std::size_t i = 0; i + 1 < line.size(); ++i)
    EXPECT_TRUE(line[i].x == line[i + 1].x || line[i].y == line[i + 1].y);
  EXPECT_EQ(line.back().x, stroke_of(scene, "panel/0/series/1").lines[0].back().x);
}

TEST(Scene, BreaksALineAtWhatIsNotFinite) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  Figure figure;
  figure.add_panel().line({0, 1, 2, 3, 4, 5, 6, 7}, {0, 1, nan, 1, 2, inf, 0, 1});
  EXPECT_EQ(stroke_of(layout(figure), "panel/0/series/0").lines.size(), 3u);
}

TEST(Scene, PutsLabelsAtTheEndsWhenTheyFitAndElseALegend) {
  Figure figure;
  Panel& panel = figure.add_panel();
  panel.line({0, 1}, {0, 1}, {.label = "up"});
  panel.line({0, 1}, {1, 0}, {.label = "down"});
  EXPECT_THAT(texts_of(layout(figure), "panel/0/ends"), ElementsAre("up", "down"));
  for (int i = 0; i < 4; ++i) figure.panels[0].line({0, 1}, {0.5, 1}, {.label = "more"});
  const Scene crowded = layout(figure);
  EXPECT_EQ(find(crowded.root, "panel/0/ends"), nullptr);
  EXPECT_EQ(texts_of(crowded, "panel/0/legend").size(), 6u);
}

TEST(Scene, SaysWhichSeriesBelongToTheRightAxis) {
  Figure figure;
  Panel& panel = figure.add_panel();
  panel.line({0, 1}, {0, 1}, {.label = "a"});
  panel.line({0, 1}, {0, 2}, {.label = "b"});
  panel.right_series.push_back(line_series({0, 1}, {5, 6}, {.label = "c"}));
  EXPECT_THAT(texts_of(layout(figure), "panel/0/legend"), ElementsAre("a", "b", "c (right)"));
}

TEST(Scene, KeepsEveryExtremeOfALongNoisySignal) {
  std::vector<double> x, y;
  for (int i = 0; i < 200000; ++i) {
    x.push_back(i);
    y.push_back(i == 123456 ? 5 : i == 77777 ? -3 : std::sin(0.1 * i));
  }
  Figure figure;
  figure.add_panel({.y = {.limits = {-4, 6}}}).line(x, y);
  const Scene scene = layout(figure);
  const Polyline axes = stroke_of(scene, "panel/0/axes").lines[0];
  const Polyline line = stroke_of(scene, "panel/0/series/0").lines[0];
  EXPECT_LT(line.size(), 5000u);
  Fixed top = line[0].y, bottom = line[0].y;
  for (const Point p : line) top = std::min(top, p.y), bottom = std::max(bottom, p.y);
  const double unit = (axes[1].y - axes[0].y) / 10.0;
  EXPECT_NEAR(top, axes[0].y + unit * 1, 2);
  EXPECT_NEAR(bottom, axes[0].y + unit * 9, 2);
}

TEST(Scene, HasEqualUnitsWhenToldSo) {
  Figure figure;
  Panel& panel = figure.add_panel({.x = Axis{}, .equal = true});
  panel.line({0, 1, 1, 0, 0}, {0, 0, 1, 1, 0});
  const Polyline square = stroke_of(layout(figure), "panel/0/series/0").lines[0];
  Rect box{square[0].x, square[0].y, square[0].x, square[0].y};
  for (const Point p : square)
    box = {std::min(box.left, p.x), std::min(box.top, p.y), std::max(box.right, p.x), std::max(box.bottom, p.y)};
  EXPECT_NEAR(box.right - box.left, box.bottom - box.top, 2);
}

TEST(Scene, MovesWithDataAndLimits) {
  const auto made = [](double shift) {
    Figure figure;
    Panel& p = figure.add_panel({.y = {.limits = {shift + 0, shift + 8}}});
    p.line({0, 1, 2, 3}, {shift + 1, shift + 5, shift + 3, shift + 7});
    return stroke_of(layout(figure), "panel/0/series/0").lines;
  };
  EXPECT_EQ(made(0), made(0));
  const auto a = made(16), b = made(32);  // labels of equal width: the panel keeps its place
  EXPECT_EQ(a, b);
}

TEST(Scene, RefusesAnUnknownThemeAndAbsurdSizes) {
  try {
    layout(Figure{.theme = "pink"});
    FAIL();
  } catch (const RenderError& e) {
    EXPECT_STREQ(e.what(), "there is no theme 'pink'; there are: light, dark, print");
  }
  EXPECT_THROW(layout(Figure{.width = 5}), RenderError);
  EXPECT_THROW(layout(Figure{.dpi = 1e6}), RenderError);
  EXPECT_THROW(layout(Figure{.dpi = std::numeric_limits<double>::quiet_NaN()}), RenderError);
}

TEST(Scene, GivesABandTheColourOfItsLine) {
  Figure figure;
  Panel& panel = figure.add_panel();
  panel.band({0, 1}, {0, 0}, {2, 2}, {.color_of = 1});
  panel.line({0, 1}, {1, 1});
  const Scene scene = layout(figure);
  const Fill& area = std::get<Fill>(find(scene.root, "panel/0/series/0")->children[0].item);
  EXPECT_EQ(with_alpha(area.color, 255), stroke_of(scene, "panel/0/series/1").color);
  EXPECT_EQ(stroke_of(scene, "panel/0/series/1").color, rgb(0x0072B2));
}

TEST(Panel, RefusesColumnsOfDifferentLength) {
  EXPECT_THROW(Panel().line({0, 1}, {0}), std::invalid_argument);
  EXPECT_THROW(Panel().band({0, 1}, {0}, {0, 1}), std::invalid_argument);
}

TEST(Lint, FindsAWrongNumberAtAnAxis) {
  Scene scene = layout(noisy_steps());
  std::function<void(Group&)> spoil = [&](Group& g) {
    for (SceneNode& node : g.children) {
      if (auto* inner = std::get_if<Group>(&node.item)) spoil(*inner);
      if (auto* text = std::get_if<TextRun>(&node.item); text && g.role == "panel/0/y/ticks" && text->source == "1.6")
        text->source = "1.7";
    }
  };
  spoil(scene.root);
  EXPECT_THAT(lint(scene), ElementsAre(HasSubstr("not evenly spaced")));
}

TEST(Lint, FindsOverlapsAndWhatIsCutOff) {
  Scene scene = layout(Figure{.title = "Title"});
  TextRun title = std::get<TextRun>(find(scene.root, "title")->children[0].item);
  scene.root.add({title});
  title.box.left = -1;
  scene.root.add({title});
  EXPECT_GE(lint(scene).size(), 2u);
}

TEST(Curve, IsClippedWhereItLeavesTheBox) {
  const auto parts = clip_line({{-10, 5}, {20, 5}, {20, 50}, {5, 50}, {5, 5}}, {0, 0, 10, 10});
  ASSERT_EQ(parts.size(), 2u);
  EXPECT_EQ(parts[0].front().x, 0);
  EXPECT_EQ(parts[0].back().x, 10);
  EXPECT_EQ(parts[1].front().y, 10);
}

TEST(Curve, ThatRepeatsItselfIsDrawnOnce) {
  Curve circles;
  for (int i = 0; i < 100000; ++i) circles.push_back({100 + 90 * std::cos(0.02 * i), 100 + 90 * std::sin(0.02 * i)});
  std::size_t kept = 0;
  for (const Curve& part : without_repeats(decimate_distance(circles, 1.5), {0, 0, 200, 200})) kept += part.size();
  EXPECT_LT(kept, 3000u);
  EXPECT_GT(kept, 300u);  // 565 pixels around
}

Curve noise(std::size_t samples) {
  Curve curve;
  std::uint32_t state = 11;
  for (std::size_t i = 0; i < samples; ++i) {
    state = state * 1664525u + 1013904223u;
    const double x = 4 + 392 * static_cast<double>(i) / static_cast<double>(samples);
    curve.push_back({x, 100 + 60 * std::sin(0.02 * x) + 20 * static_cast<double>(state >> 8) / 16777216.0});
  }
  return curve;
}

TEST(Curve, ThatIsDecimatedKeepsEveryExtreme) {
  const Curve curve = noise(30000), kept = decimate_columns(curve, 0.6);
  EXPECT_LT(kept.size(), 2u * 656);  // two to the column
  const auto extremes = [](const Curve& c) {
    std::map<int, std::pair<double, double>> columns;
    for (const Spot s : c) {
      auto& [low, high] = columns.try_emplace(static_cast<int>(s.x / 0.6), s.y, s.y).first->second;
      low = std::min(low, s.y);
      high = std::max(high, s.y);
    }
    return columns;
  };
  EXPECT_EQ(extremes(kept), extremes(curve));
}

TEST(Curve, ThatIsDecimatedKeepsItsWayAcrossAGap) {
  const Curve curve{{0, 0}, {10.1, 0}, {10.2, 5}, {10.3, 3}, {100, 3}}, kept = decimate_columns(curve, 1);
  ASSERT_EQ(kept.size(), 5u);
  EXPECT_EQ(kept[3].x, 10.3);  // neither the lowest nor the highest, but where the line leaves
  EXPECT_EQ(kept[3].y, 3);
}

TEST(Json, ShortensLongLists) {
  const Scene scene = layout(noisy_steps());
  EXPECT_LT(to_json(scene, 100).size(), to_json(scene).size() / 3);
  EXPECT_THAT(to_json(scene, 100), HasSubstr("\"count\":"));
}

}  // namespace
}  // namespace plantloop
