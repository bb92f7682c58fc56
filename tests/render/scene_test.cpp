// Facts about scenes that layout makes.

#include "render/scene/scene.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <stdexcept>

#include "render/error.h"
#include "render/geometry/curve.h"
#include "render/layout.h"
#include "render/plots/plot.h"
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

using Coefficients = std::vector<double>;

void draw_bode(Figure& figure, std::size_t panel) {
  find_plot("bode")->use(figure, panel, {{"num", Coefficients{4}}, {"den", Coefficients{1, 2, 4}}});
}

// Left and right end of the lowest line of a panel's axes, in pixels.
std::pair<double, double> across(const Scene& scene, const std::string& panel) {
  double left = 1e9, right = -1e9;
  for (const Polyline& line : stroke_of(scene, panel + "/axes").lines)
    for (const Point p : line) left = std::min(left, p.x / 256.0), right = std::max(right, p.x / 256.0);
  return {left, right};
}

double lowest(const Scene& scene, const std::string& role) {
  double bottom = -1e9;
  for (const Polyline& line : stroke_of(scene, role).lines)
    for (const Point p : line) bottom = std::max(bottom, p.y / 256.0);
  return bottom;
}

TEST(SharedAxis, IsNeitherTakenNorGivenByPlotsWithAnXOfTheirOwn) {
  Figure figure{.columns = 2};
  figure.x.label = "time [s]";
  for (int i = 0; i < 4; ++i) figure.add_panel();
  draw_bode(figure, 0);
  find_plot("nyquist")->use(figure, 1, {{"num", Coefficients{10}}, {"den", Coefficients{1, 3, 3, 1}}});
  find_plot("root_locus")->use(figure, 2, {{"num", Coefficients{1}}, {"den", Coefficients{1, 3, 2, 0}}});
  figure.panels[3].line({0, 100}, {0, 1});
  const Scene scene = layout(figure);
  EXPECT_THAT(lint(scene), IsEmpty());
  EXPECT_EQ(figure.x.scale, Scale::linear);
  EXPECT_THAT(texts_of(scene, "panel/0/x/label"), IsEmpty());
  EXPECT_THAT(texts_of(scene, "panel/1/x/label"), ElementsAre("frequency ω [rad s⁻¹]"));
  EXPECT_THAT(texts_of(scene, "panel/2/x/label"), ElementsAre("Re L(jω)"));
  EXPECT_THAT(texts_of(scene, "panel/3/x/label"), ElementsAre("Re s [s⁻¹]"));
  EXPECT_THAT(texts_of(scene, "panel/4/x/label"), ElementsAre("time [s]"));
  // The curve is the first series that is no guide.
  for (const char* panel : {"panel/0", "panel/2", "panel/3", "panel/4"}) {
    const Group* curve = nullptr;
    for (int i = 0; i < 40 && !curve; ++i) curve = find(scene.root, fmt::format("{}/series/{}", panel, i));
    ASSERT_NE(curve, nullptr) << panel;
    EXPECT_FALSE(curve->children.empty()) << panel;
  }
}

// Gain and phase stand one above the other, whatever the columns are, and end where the panel beside them does.
TEST(SharedAxis, OfABodeDiagramIsThatOfItsTwoPanels) {
  for (const int columns : {1, 2, 3}) {
    Figure figure{.columns = columns};
    figure.add_panel();
    figure.add_panel({.y = {.label = "y"}}).line({0, 100}, {0, 1});
    draw_bode(figure, 0);
    const Scene scene = layout(figure);
    EXPECT_THAT(lint(scene), IsEmpty());
    EXPECT_EQ(across(scene, "panel/0"), across(scene, "panel/1")) << columns;
    EXPECT_LT(lowest(scene, "panel/0/axes"), lowest(scene, "panel/1/axes")) << columns;
    if (columns > 1) {
      EXPECT_NEAR(lowest(scene, "panel/1/axes"), lowest(scene, "panel/2/axes"), 2);
    }
    EXPECT_THAT(texts_of(scene, "panel/1/y/label"), ElementsAre("phase [°]"));
    EXPECT_THAT(texts_of(scene, "panel/2/y/label"), ElementsAre("y"));
  }
}

TEST(SharedAxis, OfTheOnlyPanelIsWhatTheUserSaysOfTheFigures) {
  Figure figure;
  figure.x = {.label = "gain K", .limits = {0, 5}};
  find_plot("scatter")->use(figure, 0, {{"x", Coefficients{1, 2}}, {"y", Coefficients{1, 2}}});
  const Scene scene = layout(figure);
  EXPECT_THAT(texts_of(scene, "panel/0/x/label"), ElementsAre("gain K"));
  EXPECT_EQ(texts_of(scene, "panel/0/x/ticks").back(), "5");
}

// Without a name for the axis only panels share it whose data overlap and are not tiny; with a name all do.
TEST(SharedAxis, WithoutANameIsNotSharedByPanelsOfAnotherRange) {
  Figure figure;
  for (const auto& [from, to] : {std::pair{0.0, 10.0}, {1.0, 3.0}, {100.0, 200.0}, {2.0, 2.5}})
    figure.add_panel().line({from, to}, {0, 1});
  const auto last = [](const Scene& scene, const std::string& panel) {
    const std::vector<std::string> all = texts_of(scene, panel + "/x/ticks");
    return all.empty() ? std::string() : all.back();
  };
  const Scene apart = layout(figure);
  EXPECT_THAT(lint(apart), IsEmpty());
  EXPECT_EQ(last(apart, "panel/0"), "");
  EXPECT_EQ(last(apart, "panel/1"), "10");
  EXPECT_EQ(last(apart, "panel/2"), "200");
  EXPECT_EQ(last(apart, "panel/3"), "2.5");
  figure.x.label = "time [s]";
  const Scene shared = layout(figure);
  EXPECT_EQ(last(shared, "panel/0"), "");
  EXPECT_EQ(last(shared, "panel/2"), "");
  EXPECT_EQ(last(shared, "panel/3"), "200");
}

TEST(Key, KeepsNamesApartHoweverNarrowTheFigureIs) {
  Figure figure{.width = 86};
  Panel& panel = figure.add_panel();
  for (int i = 1; i <= 14; ++i)
    panel.line({0, 1, 2}, {0.0 + i, 1.0 - i, 0.5 * i}, {.label = "series number " + std::to_string(i) + " with words"});
  const Scene scene = layout(figure);
  EXPECT_THAT(lint(scene), IsEmpty());
  std::vector<std::string> names = texts_of(scene, "panel/0/legend");
  ASSERT_GE(names.size(), 8u);
  std::sort(names.begin(), names.end());
  EXPECT_EQ(std::unique(names.begin(), names.end()), names.end());
}

TEST(Bars, KeepAllTheirNames) {
  for (const std::size_t count : {3, 12, 25}) {
    Figure figure{.width = 86};
    std::vector<std::string> names;
    for (std::size_t i = 0; i < count; ++i) names.push_back("controller variant " + std::to_string(i + 1));
    find_plot("bar")->use(figure, 0, {{"y", std::vector<double>(count, 1.0)}, {"names", names}});
    const Scene scene = layout(figure);
    EXPECT_THAT(lint(scene), IsEmpty()) << count;
    EXPECT_EQ(texts_of(scene, "panel/0/x/ticks").size(), count);
  }
}

// The exponent of the x axis' last number does not reach under the right axis' lowest one.
TEST(TwinAxis, KeepsItsLowestNumberApartFromAnExponent) {
  Figure figure;
  figure.x = {.label = "frequency [Hz]", .limits = {1, 1000}, .scale = Scale::log};
  Panel& panel = figure.add_panel();
  panel.line({1, 1000}, {0, 1});
  panel.right_series.push_back(line_series({1, 1000}, {0, -1000}));
  const Scene scene = layout(figure);
  const auto box_of = [&](const char* role, bool last) {
    const std::vector<SceneNode>& all = find(scene.root, role)->children;
    return std::get<TextRun>((last ? all.back() : all.front()).item).box;
  };
  EXPECT_LT(box_of("panel/0/x/ticks", true).right + 4 * 256, box_of("panel/0/right/ticks", false).left);
}

TEST(Insets, LeaveTheLabelsOfLinesReadable) {
  Figure figure;
  Panel& panel = figure.add_panel();
  std::vector<double> x, y;
  for (int i = 0; i <= 200; ++i) x.push_back(0.05 * i), y.push_back(1 - std::exp(-0.05 * i) * std::cos(0.2 * i));
  panel.line(x, y);
  panel.lines.push_back({.at = 1.31, .label = "the limit of the actuator"});
  panel.lines.push_back({.axis = ReferenceLine::x, .at = 8, .label = "end of the test"});
  panel.insets.push_back({.x = Axis{.limits = {1, 2}}});
  panel.insets[0].line(x, y);
  const Scene scene = layout(figure);
  EXPECT_THAT(lint(scene), IsEmpty());
  EXPECT_EQ(texts_of(scene, "panel/0/labels").size(), 2u);
  const Group* own = find(scene.root, "panel/0/inset/0");
  const auto& paper = std::get<Fill>(own->children.front().item).rings[0];
  for (const SceneNode& node : find(scene.root, "panel/0/labels")->children) {
    const Rect box = std::get<TextRun>(node.item).box;
    const bool apart =
        box.right < paper[0].x || box.left > paper[2].x || box.bottom < paper[0].y || box.top > paper[2].y;
    EXPECT_TRUE(apart);
  }
  // The curve ends at the inset's edge.
  const Group* curve = find(scene.root, "panel/0/inset/0/series/0");
  const Polyline& edge = stroke_of(scene, "panel/0/inset/0/axes").lines[0];
  EXPECT_NEAR(curve->clip->right, edge.back().x, 256);
  EXPECT_NEAR(curve->clip->left, edge.front().x, 256);
}

TEST(Trajectory, FillsItsRoom) {
  std::vector<double> t, x, y;
  for (int i = 0; i <= 400; ++i) {
    t.push_back(0.025 * i);
    x.push_back(std::cos(t.back()));
    y.push_back(std::sin(t.back()));
  }
  Figure figure;
  find_plot("trajectory")->use(figure, 0, {{"x", x}, {"y", y}, {"z", t}});
  const Scene scene = layout(figure);
  EXPECT_THAT(lint(scene), IsEmpty());
  // Ends at 1 and 10, where the data end; a number at the corner where two axes meet is left out.
  for (const char* role : {"panel/0/x/numbers", "panel/0/y/numbers"})
    EXPECT_THAT(texts_of(scene, role), testing::AllOf(testing::Contains("0"), testing::Not(testing::Contains("2"))));
  EXPECT_EQ(texts_of(scene, "panel/0/z/numbers").back(), "10");
}

}  // namespace
}  // namespace plantloop
