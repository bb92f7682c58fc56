// Figures from scripts, as SVG, which can be read.

#include "tests/scripts/workshop.h"

namespace plantloop {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

class Figures : public Workshop {
 protected:
  Figures() { write_lag(); }
};

TEST_F(Figures, HaveCurvesLinesAndBands) {
  EXPECT_EQ(
      printed("local f = pl.figure{title = 'A title', x = 'time [s]', y = 'speed', limits = {0, 2}, lines = {{y = 1.5, "
              "label = 'top'}}}\n"
              "local t = pl.linspace(0, 1, 5)\n"
              "f:line(t, t, {label = 'rise', style = 'dashed'}):stairs(t, 1 - t, {label = 'fall', color = 'green'})\n"
              "f:markers({0, 1}, {1, 1}, {marker = 'ring'}):band(t, t - 0.1, t + 0.1)\n"
              "f:reference{x = 0.5, label = 'half'}:shade{lower = 0.9, upper = 1.1, label = 'goal'}\n"
              "print(f:save 'out/deep/er/figure.svg')"),
      "out/deep/er/figure.svg");
  const std::string svg = read("out/deep/er/figure.svg");
  for (const char* text : {"<svg", "A title", "speed", "rise", "fall", "top", "half", "goal"})
    EXPECT_THAT(svg, HasSubstr(text));
}

TEST_F(Figures, HavePanelsAndTwinAxes) {
  EXPECT_EQ(printed("local f = pl.figure{x = {label = 'time [s]', limits = {0, 5}}}\n"
                    "local run = pl.load('lag.yaml'):run()\n"
                    "f:panel{title = 'first', y = 'out'}:line(run.time, run.y, {label = 'y'})\n"
                    "local p = f:panel{y = {label = 'low', scale = 'log'}, right = 'high', height = 0.5}\n"
                    "p:line(run.time, run.y + 1):line(run.time, run.u, {right = true, label = 'drive'})\n"
                    "f:panel{x = 'u'}:signal(run, 'y')\n"
                    "f:save 'a.svg'; f:save 'a.png'"),
            "");
  const std::string svg = read("a.svg");
  for (const char* text : {"first", "out", "low", "high", "drive", "y [m]"}) EXPECT_THAT(svg, HasSubstr(text));
  EXPECT_THAT(read("a.png"), StartsWith("\x89PNG"));
}

TEST_F(Figures, OfTheDiagramAreDrawn) {
  EXPECT_EQ(printed("local run = pl.load('lag.yaml'):run(); print(run:figures('out', 'svg')[1])"), "out/response.svg");
  EXPECT_THAT(read("out/response.svg"), HasSubstr("time [s]"));
  EXPECT_EQ(printed("local f = pl.load('lag.yaml'):run():figure 'response'; f:line({0, 5}, {0, 1}, {label = 'mine'}); "
                    "f:save 'b.svg'"),
            "");
  EXPECT_THAT(read("b.svg"), HasSubstr("mine"));
}

TEST_F(Figures, HaveAMethodForEveryPlotType) {
  EXPECT_EQ(printed("local f = pl.figure{columns = 2, share_y = true}\n"
                    "f:panel{title = 'a'}:stem({0, 1, 2}, {3, 1, 2}, {base = 1, label = 'stems'})\n"
                    "f:panel{title = 'b'}:bar({1, 2}, {names = {'left', 'right'}})\n"
                    "f:save 'plots.svg'\n"
                    "local b = pl.figure{title = 'loop'}; b:bode({4}, {0.1, 1.1, 1, 0}); b:save 'bode.svg'\n"
                    "pl.figure{}:heat_map({{1, 2, 3}, {4, 5, 6}}, {scale = 'heat'}):save 'heat.svg'"),
            "");
  const std::string svg = read("plots.svg");
  for (const char* text : {"stems", "left", "right"}) EXPECT_THAT(svg, HasSubstr(text));
  EXPECT_THAT(read("bode.svg"), HasSubstr("phase margin 17.7°"));
  EXPECT_THAT(read("heat.svg"), HasSubstr("heat"));
}

// What a plot makes below its panel belongs to that panel, whatever panels there are already.
TEST_F(Figures, KeepGainAndPhaseTogetherWhenThereAreOtherPanels) {
  EXPECT_EQ(
      printed("local f = pl.figure{columns = 2, x = 'time [s]'}\n"
              "local loop, curve, run = f:panel{title = 'open loop'}, f:panel{title = 'curve'}, f:panel{y = 'w'}\n"
              "loop:bode({4}, {1, 2, 4}); curve:nyquist({10}, {1, 3, 3, 1}); run:line({0, 1}, {0, 1})\n"
              "f:save 'three.svg'"),
      "");
  const std::string svg = read("three.svg");
  for (const char* text : {"phase [°]", "Re L(jω)", "time [s]", "frequency ω"}) EXPECT_THAT(svg, HasSubstr(text));
}

TEST_F(Figures, HaveRemarksAndInsets) {
  EXPECT_EQ(printed("local f = pl.figure{x = 'time [s]', y = {label = 'y', scale = 'symlog', threshold = 0.1}}\n"
                    "local t = pl.linspace(0, 10, 200)\n"
                    "f:line(t, pl.sin(t), {style = 'dashdot', opacity = 0.9})\n"
                    "f:annotate{x = 1.57, y = 1, label = 'peak'}\n"
                    "f:inset{x = {limits = {4, 5}}, place = {0.6, 0.1, 0.3, 0.3}}:line(t, pl.sin(t))\n"
                    "f:save 'inset.svg'"),
            "");
  const std::string svg = read("inset.svg");
  for (const char* text : {"peak", "panel/0/inset/0/frame"}) EXPECT_THAT(svg, HasSubstr(text));
}

TEST_F(Figures, SayWhatIsWrong) {
  EXPECT_EQ(complaint("pl.figure():line({1, 2}, {1, 2, 3})"), "experiment.lua:1: line: x has 2 numbers and y has 3");
  EXPECT_THAT(complaint("pl.figure{tilte = 'x'}"), HasSubstr("there is no 'tilte'; did you mean 'title'?"));
  EXPECT_THAT(complaint("pl.figure():line({1}, {1}, {color = 'ugly'})"), HasSubstr("there is no colour 'ugly'"));
  EXPECT_THAT(complaint("pl.figure():line({1}, {1}, {style = 'wavy'})"), HasSubstr("'style' must be solid, dashed"));
  EXPECT_THAT(complaint("pl.figure():save 'a.gif'"), HasSubstr("the name must end in .json or .pdf or .png or .svg"));
  EXPECT_THAT(complaint("pl.figure():lines({1}, {1})"), HasSubstr("a figure has no 'lines'; did you mean 'line'?"));
  EXPECT_EQ(complaint("pl.figure():stem({1}, {1, 2, 3})"), "experiment.lua:1: stem: x has 1 numbers and y has 3");
  EXPECT_EQ(complaint("pl.figure():stem({1})"), "experiment.lua:1: stem: 'y' is missing: how far they reach");
  EXPECT_THAT(complaint("pl.figure():histogram({1}, {bin = 3})"), HasSubstr("there is no 'bin'; did you mean 'bins'?"));
  EXPECT_THAT(complaint("pl.figure():bar({1}, {names = 3})"), HasSubstr("'names' must be a list of texts, it is 3"));
  EXPECT_THAT(complaint("pl.figure{y = {scale = 'cubic'}}"), HasSubstr("'scale' must be linear, log or symlog"));
  EXPECT_THAT(complaint("pl.figure():annotate{label = 'x'}"), HasSubstr("a remark stands at x and y"));
  EXPECT_THAT(complaint("pl.figure():inset():inset()"), HasSubstr("an inset has no insets"));
  EXPECT_THAT(complaint("pl.figure():inset{place = {1}}"), HasSubstr("{left, bottom, width, height}"));
  EXPECT_THAT(complaint("pl.figure{limits = {1, 0}}"),
              HasSubstr("'limits' are {lower, upper} in rising order, here is {1, 0}"));
  EXPECT_THAT(complaint("pl.figure{y = {scale = 'log', limits = {0, 1}}}"),
              HasSubstr("a logarithmic axis has only values greater than 0, and 'limits' has 0"));
  EXPECT_THAT(complaint("pl.figure{columns = 0}"), HasSubstr("'columns' must be a whole number from 1 to 20"));
  EXPECT_THAT(complaint("pl.figure{width = 1}:save 'a.svg'"), Not(HasSubstr("no error")));
}

}  // namespace
}  // namespace plantloop
