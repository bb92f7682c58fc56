// figures: what the section of a diagram may say, as a user meets it.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <initializer_list>
#include <string>

#include "tests/app/program.h"

namespace plantloop::testing_program {
namespace {

constexpr const char* servo = R"(plantloop: 1
parameters: {wn: 4, zeta: 0.35, num: [16], den: [1, 2.8, 16]}
blocks:
  r: {type: step, time: 0.5, after: 1}
  y: {type: integrator, in: v, unit: m}
  v: {type: integrator, in: wn^2*(r - y) - 2*zeta*wn*v, unit: m/s}
  held: {type: zero_order_hold, in: y, rate: 0.1}
simulation: {stop: 6}
record: [y]
figures:
)";

class Figures : public ::testing::Test {
 protected:
  // The figure `f` as text (a scene), or what the program said.
  std::string drawn(const std::string& figure, const std::string& format = "json") {
    place_.write("servo.yaml", servo + figure);
    const Outcome o = place_.run("run servo.yaml --figures out --format " + format);
    return o.status == 0 ? place_.read("out/f." + format) : o.err;
  }
  // Which of the texts the scene does not have: failures stay readable.
  static std::string lacking(const std::string& scene, std::initializer_list<const char*> texts) {
    std::string none;
    for (const char* text : texts)
      if (scene.find(text) == std::string::npos) none += std::string(none.empty() ? "" : ", ") + text;
    return none;
  }
  static bool has(const std::string& scene, const char* text) { return scene.find(text) != std::string::npos; }
  Workplace place_;
};

TEST_F(Figures, SayAllThatScriptsCan) {
  const std::string scene = drawn(R"(  f:
    title: Servo
    theme: dark
    size: two_columns
    panels:
      - y:
          - {signal: r, label: set point, style: dashed, color: grey}
          - {signal: y, width: 2, marker: ring, opacity: 0.8}
        label: "position [m]"
        limits: [0, auto]
        legend: bottom_right
        right: v
        right_label: "speed [m/s]"
        right_limits: [-4, 4]
        remarks: [{x: 1.3, y: 1.31, label: peak}]
        lines: [{y: 1, label: final, style: dotted}]
        bands: [{from: 0, until: 0.5, label: rest}]
        insets: [{y: y, x_limits: [0.9, 1.7], place: [0.5, 0.1, 0.3, 0.3]}]
)");
  EXPECT_EQ(lacking(scene, {"\"Servo\"", "\"set point\"", "\"peak\"", "\"final\"", "\"rest\"", "\"speed [m/s]\"",
                            "panel/0/inset/0", "\"#0d1117\"", "\"width\":1068"}),
            "");
}

TEST_F(Figures, HavePlotTypesAsKeysOfPanels) {
  const std::string scene = drawn(R"(  f:
    panels:
      - {bode: {num: num, den: [1, 2*zeta*wn, wn^2]}}
)");
  EXPECT_EQ(lacking(scene, {"\"gain [dB]\"", "\"phase [°]\"", "phase margin"}), "");
  EXPECT_FALSE(has(scene, "time"));
  const std::string points = drawn("  f: {panels: [{scatter: {x: y, y: v}}]}\n");
  EXPECT_EQ(lacking(points, {"\"y [m]\"", "\"v [m/s]\""}), "");
  EXPECT_FALSE(has(points, "time"));
  EXPECT_EQ(lacking(drawn("  f: {panels: [{step_response: {t: time, y: y, to_value: 1, at: 0.5}}]}\n"),
                    {"overshoot 30.9 %", "\"time [s]\""}),
            "");
  EXPECT_EQ(lacking(drawn("  f: {panels: [{stem: {x: time, y: held}}, {histogram: [{values: y}, {values: v}]}]}\n"),
                    {"\"held\"", "\"time [s]\"", "\"count\""}),
            "");
}

// The held signal has 61 hits from 0 to 6 s, and as many stems.
TEST_F(Figures, GivePlotsASampledSignalAtItsHits) {
  const std::string scene = drawn("  f: {panels: [{stem: {x: time, y: held}}]}\n");
  const std::size_t series = scene.find("panel/0/series/0"), lines = scene.find("\"lines\":[", series);
  const std::string stems = scene.substr(lines, scene.find("]]", lines) - lines);
  EXPECT_EQ(std::count(stems.begin(), stems.end(), '[') - 1, 55);  // six of height zero are only dots
}

TEST_F(Figures, WriteTimeInTheUnitThatSuits) {
  EXPECT_EQ(lacking(drawn("  f: {panels: [{y: y}]}\n"), {"\"time [s]\""}), "");
  EXPECT_EQ(lacking(drawn("  f: {x: {unit: ms}, panels: [{y: y}]}\n"), {"\"time [ms]\"", "\"6000\""}), "");
  place_.write("servo.yaml", std::string(servo) + "  f: {panels: [{y: y}]}\n");
  const Outcome o = place_.run("run servo.yaml --stop 10000 --solver bdf --figures out --format json");
  EXPECT_EQ(o.status, 0) << o.err;
  EXPECT_EQ(lacking(place_.read("out/f.json"), {"\"time [min]\""}), "");
}

TEST_F(Figures, SayWhereAPlotCannotBeDrawn) {
  EXPECT_EQ(
      drawn("  f: {panels: [{step_response: {t: time, y: y}, bode: {num: [0], den: [1]}}]}\n"),
      "plantloop: cannot draw figure 'f': servo.yaml:11:55: bode: 'num' and 'den' must have a coefficient that is "
      "not zero\n");
}

// What cannot work is told before the run.
TEST_F(Figures, AreCheckedBeforeTheRun) {
  const auto checked = [&](const std::string& panel) {
    place_.write("servo.yaml", std::string(servo) + "  f: {panels: [" + panel + "]}\n");
    const Outcome o = place_.run("check servo.yaml");
    const std::size_t error = o.err.find(": error: ");
    const std::size_t line = error == std::string::npos ? error : o.err.rfind('\n', error);
    const std::string first = error == std::string::npos ? "" : o.err.substr(line == std::string::npos ? 0 : line + 1);
    return first.substr(0, first.find('\n')) + fmt::format(" ({})", o.status);
  };
  EXPECT_EQ(checked("{bode: {num: [1]}}"), "servo.yaml:11:23: error: bode needs 'den' (2)");
  EXPECT_EQ(checked("{nyquist: {den: [1]}}"), "servo.yaml:11:26: error: nyquist needs 'num' (2)");
  EXPECT_EQ(checked("{error_bars: {x: time, y: y}}"), "servo.yaml:11:29: error: error_bars needs 'error' (2)");
  EXPECT_EQ(checked("{bode: {w: [1, 2], re: [1, 1], im: [0, 0]}}"), " (0)");
  EXPECT_EQ(checked("{y: y, limits: [1, 0]}"),
            "servo.yaml:11:31: error: 'limits' are [lower, upper] in rising order; here is [1, 0] (2)");
  EXPECT_EQ(checked("{y: y, scale: log, limits: [0, 1]}"),
            "servo.yaml:11:43: error: a logarithmic axis has only values greater than 0, and 'limits' has 0 (2)");
  EXPECT_EQ(checked("{y: y, scale: log, limits: [auto, 1]}"), " (0)");
  EXPECT_EQ(checked("{y: y, scale: symlog, limits: [0, 1]}"), " (0)");
}

TEST_F(Figures, SayWhichKeyWasMeant) {
  const std::string said = drawn(R"(  f:
    size: poster
    panels:
      - {bodee: {num: num}}
      - {bode: {nom: num}}
      - {stem: {x: time}}
)");
  EXPECT_EQ(said, R"(servo.yaml:12:11: error: 'size' is one of one_column, two_columns, slide, web; here is 'poster'
   12 |     size: poster
      |           ^~~~~~
servo.yaml:14:10: error: a panel has no key 'bodee'
   14 |       - {bodee: {num: num}}
      |          ^~~~~
  did you mean 'bode'?  it has: y, x, labels, right, label, limits, scale, threshold, right_label, right_limits, right_scale, x_label, x_limits, x_scale, title, lines, bands, remarks, legend, equal, bare, height, insets, bar, ... (49 in all)
servo.yaml:15:17: error: bode has no key 'nom'
   15 |       - {bode: {nom: num}}
      |                 ^~~
  did you mean 'num'?  it has: num, den, delay, w, re, im, from, to, margins, label, style, marker, color, width, opacity, size, right
servo.yaml:16:16: error: stem needs 'y'
   16 |       - {stem: {x: time}}
      |                ^
  for example y: ... (how far they reach)
)");
}

TEST_F(Figures, HaveTextThatCanBeSelected) {
  EXPECT_FALSE(has(drawn("  f: {title: A servo, panels: [{y: y}]}\n", "svg"), "<text"));
  EXPECT_TRUE(has(drawn("  f: {title: A servo, selectable_text: true, panels: [{y: y}]}\n", "svg"), ">A servo</text>"));
}

}  // namespace
}  // namespace plantloop::testing_program
