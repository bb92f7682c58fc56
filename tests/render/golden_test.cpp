// What is stored of every test figure, to be compared to: its reading always, its scene and pixels where the stack is
// the one they were made with.
//
// A reading says what a person sees without saying where: words, colours, dashes, what belongs to what. It hardly
// depends on the fonts' versions. The hashes of the scene and of the pixels do: they are stored with the fonts' own
// hashes and the rasteriser's name, and compared only where these are the same. To renew all after a change that is
// meant, run PLANTLOOP_RENEW=1 render_test --gtest_filter='Golden.*' in the root of the tree, and read the difference.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <sstream>

#include "render/image.h"
#include "render/layout.h"
#include "render/scene/dump.h"
#include "tests/render/figures.h"

namespace plantloop {
namespace {

const std::string folder = "tests/render/goldens/";

bool renewing() { return std::getenv("PLANTLOOP_RENEW") != nullptr; }

std::string stored(const std::string& name) {
  std::ifstream file(folder + name);
  return {std::istreambuf_iterator<char>(file), {}};
}

void store(const std::string& name, const std::string& text) { std::ofstream(folder + name) << text; }

// The same primitives in succession are said once, with their number.
class Reading {
 public:
  std::string of(const Scene& scene) {
    out_ = fmt::format("{} {}x{} on {}\n", scene.title, scene.width, scene.height, to_hex(scene.background));
    group(scene.root, 0);
    return out_;
  }

 private:
  std::string out_, last_;
  int times_ = 0;

  void say(const std::string& line) {
    if (line == last_) {
      ++times_;
      return;
    }
    flush();
    last_ = line;
    times_ = 1;
  }

  void flush() {
    if (times_ > 0) out_ += last_ + (times_ > 1 ? " (several)" : "") + "\n";
    times_ = 0;
    last_.clear();
  }

  void group(const Group& g, int depth) {
    const std::string indent(static_cast<std::size_t>(depth), ' ');
    flush();
    out_ += fmt::format("{}{}{}\n", indent, g.role, g.name.empty() ? "" : " '" + g.name + "'");
    for (const SceneNode& node : g.children) {
      if (const auto* inner = std::get_if<Group>(&node.item))
        group(*inner, depth + 1);
      else if (const auto* text = std::get_if<TextRun>(&node.item))
        say(fmt::format("{} \"{}\" {}", indent, text->source, to_hex(text->color)));
      else if (const auto* fill = std::get_if<Fill>(&node.item))
        say(fmt::format("{} area {}", indent, to_hex(fill->color)));
      else if (const auto* stroke = std::get_if<Stroke>(&node.item))
        say(fmt::format("{} line {} {:.2f} px{}", indent, to_hex(stroke->color), stroke->width / 256.0,
                        stroke->dashes.empty() ? "" : fmt::format(", {} dashes", stroke->dashes.size())));
    }
    flush();
  }
};

std::string fonts() {
  std::string text;
  for (const SceneFont& font : layout(Figure{}).fonts) text += fmt::format("font {} {}\n", font.name, font.sha256);
  return text;
}

std::vector<std::string> sorted_lines(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  std::sort(lines.begin(), lines.end());
  return lines;
}

// With letters of another width a number more or less fits an axis, and a legend may find another place: one line in
// fifty then.
TEST(Golden, ReadingOfEveryFigureIsAsStored) {
  const bool same_fonts = renewing() || stored("hashes.txt").starts_with(fonts());
  std::size_t lines = 0, other = 0;
  for (const auto& [name, figure] : test_figures()) {
    const std::string reading = Reading().of(layout(figure));
    if (renewing()) store(name + ".txt", reading);
    if (same_fonts) {
      EXPECT_EQ(reading, stored(name + ".txt")) << name;
    }
    const std::vector<std::string> now = sorted_lines(reading), before = sorted_lines(stored(name + ".txt"));
    std::vector<std::string> differing;
    std::set_symmetric_difference(now.begin(), now.end(), before.begin(), before.end(), std::back_inserter(differing));
    lines += now.size();
    other += differing.size();
  }
  EXPECT_LE(other, lines / 50);
}

// Words change the reading, and so do colours and dashes.
TEST(Golden, ReadingSeesAWrongNumberAndAWrongColour) {
  Figure figure;
  figure.add_panel().line({0, 1}, {0, 1}, {.label = "a"});
  const std::string before = Reading().of(layout(figure));
  Figure other = figure;
  other.panels[0].series[0].look.color = rgb(0x123456);
  EXPECT_NE(Reading().of(layout(other)), before);
  other = figure;
  other.panels[0].series[0].look.style = LineStyle::dashed;
  EXPECT_NE(Reading().of(layout(other)), before);
  other = figure;
  other.panels[0].series[0].y[1] = 2.2;
  EXPECT_NE(Reading().of(layout(other)), before);
}

std::string stack() { return fonts() + "rasteriser " + rasteriser_name() + "\n"; }

TEST(Golden, SceneAndPixelsAreAsStoredWhereFontsAndRasteriserAre) {
  std::string now = stack();
  const std::string before = stored("hashes.txt");
  if (!renewing() && !before.starts_with(now))
    GTEST_SKIP() << "stored with other fonts or another rasteriser; here are\n" << now;
  for (const auto& [name, figure] : test_figures()) {
    const Scene scene = layout(figure);
    const Image image = rasterise(scene);
    now += fmt::format("{} {:016x} {:016x}\n", name, hash(scene), fnv1a(image.rgb.data(), image.rgb.size()));
  }
  if (renewing()) store("hashes.txt", now);
  std::istringstream here(now), there(renewing() ? now : before);
  for (std::string a, b; std::getline(here, a);) {
    std::getline(there, b);
    EXPECT_EQ(a, b);
  }
}

}  // namespace
}  // namespace plantloop
