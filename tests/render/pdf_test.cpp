// PDF files: sound without a reader, and the same sight, words and fonts in poppler, where it is installed.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>

#include "render/image.h"
#include "render/layout.h"
#include "tests/render/figures.h"

namespace plantloop {
namespace {

using testing::HasSubstr;
using testing::Not;

std::string pdf_of(const Figure& figure) {
  const Scene scene = layout(figure);
  return to_pdf({&scene, 1});
}

// A file that goes with the test.
struct Scratch {
  explicit Scratch(const std::string& ending)
      : path(testing::TempDir() + "plantloop_" + std::to_string(getpid()) + "_" + ending) {}
  ~Scratch() { std::remove(path.c_str()); }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  std::string path;
};

std::string output_of(const std::string& command) {
  std::string result;
  FILE* pipe = popen(command.c_str(), "r");
  std::array<char, 4096> buffer;
  while (const std::size_t n = fread(buffer.data(), 1, buffer.size(), pipe)) result.append(buffer.data(), n);
  pclose(pipe);
  return result;
}

bool has_poppler() { return std::system("pdftotext -v > /dev/null 2>&1") == 0; }

TEST(Pdf, ItsTableSaysWhereEachObjectStands) {
  const std::string pdf = pdf_of(test_figures()[0].figure);
  ASSERT_EQ(pdf.substr(0, 5), "%PDF-");
  const std::size_t mark = pdf.rfind("startxref\n");
  ASSERT_NE(mark, std::string::npos);
  const std::size_t table = std::stoul(pdf.substr(mark + 10));
  ASSERT_EQ(pdf.substr(table, 7), "xref\n0 ");
  const std::size_t count = std::stoul(pdf.substr(table + 7)), first = pdf.find('\n', table + 7) + 1;
  for (std::size_t i = 1; i < count; ++i) {
    const std::size_t place = std::stoul(pdf.substr(first + 20 * i, 10));
    const std::string head = std::to_string(i) + " 0 obj\n";
    EXPECT_EQ(pdf.substr(place, head.size()), head);
  }
}

TEST(Pdf, IsTheSameEveryTimeAndKnowsNoClock) {
  const std::string pdf = pdf_of(noisy_steps());
  EXPECT_EQ(pdf, pdf_of(noisy_steps()));
  EXPECT_THAT(pdf, Not(HasSubstr("Date")));
  EXPECT_LT(pdf.size(), 120000u);
}

TEST(Pdf, EmbedsFontsButNeverAsType3) {
  const std::string pdf = pdf_of(test_figures()[0].figure);
  EXPECT_THAT(pdf, HasSubstr("/Subtype/Type0"));
  EXPECT_THAT(pdf, HasSubstr("/FontFile"));
  EXPECT_THAT(pdf, Not(HasSubstr("Type3")));
}

TEST(Pdf, HasOnePageForEachScene) {
  const std::array scenes{layout(Figure{.title = "one"}), layout(Figure{.title = "two", .width = 86})};
  const std::string pdf = to_pdf(scenes);
  EXPECT_THAT(pdf, HasSubstr("/Count 2"));
  // 200 mm and 86 mm in points.
  EXPECT_THAT(pdf, HasSubstr("/MediaBox[0 0 566.9"));
  EXPECT_THAT(pdf, HasSubstr("/MediaBox[0 0 243.7"));
}

TEST(Pdf, SpeaksItsWords) {
  if (!has_poppler()) GTEST_SKIP() << "poppler-utils is not installed";
  const Scratch file("words.pdf");
  std::ofstream(file.path, std::ios::binary) << pdf_of(test_figures()[0].figure);
  const std::string text = output_of("pdftotext -layout '" + file.path + "' -");
  EXPECT_THAT(text, HasSubstr("Step response of a servo"));
  EXPECT_THAT(text, HasSubstr("set point"));
  EXPECT_THAT(text, HasSubstr("time [s]"));
  const std::string fonts = output_of("pdffonts '" + file.path + "'");
  EXPECT_THAT(fonts, HasSubstr("+Inter"));
  EXPECT_THAT(fonts, HasSubstr("yes yes yes"));
  EXPECT_THAT(fonts, Not(HasSubstr(" no ")));
  EXPECT_THAT(fonts, Not(HasSubstr("Type 3")));
}

// The mean of each `times` x `times` pixels.
Image reduced(const Image& large, int times) {
  Image image{large.width / times, large.height / times, {}};
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < 3 * image.width; ++x) {
      int sum = 0;
      for (int dy = 0; dy < times; ++dy)
        for (int dx = 0; dx < times; ++dx)
          sum += large.rgb[static_cast<std::size_t>(3 * large.width * (times * y + dy) + 3 * (times * (x / 3) + dx) +
                                                    x % 3)];
      image.rgb.push_back(static_cast<std::uint8_t>(sum / (times * times)));
    }
  return image;
}

// The tolerances are those of the SVG's test. Drawn by cairo, since poppler's own rasteriser moves thin lines to whole
// pixels, and three times as large, since both move the edges of letters.
TEST(Pdf, LooksLikeThePng) {
  if (!has_poppler()) GTEST_SKIP() << "poppler-utils is not installed";
  int compared = 0;
  for (const auto& [name, figure] : test_figures()) {
    if (name == "many_300" || name == "many_40") continue;  // all edges, no areas
    if (++compared > 6) break;
    const Scene scene = layout(figure);
    const Scratch file(name + ".pdf"), picture(name);
    const Scratch png(name + ".png");
    std::ofstream(file.path, std::ios::binary) << to_pdf({&scene, 1});
    const std::string command = "pdftocairo -png -singlefile -scale-to-x " + std::to_string(3 * scene.width) +
                                " -scale-to-y " + std::to_string(3 * scene.height) + " '" + file.path + "' '" +
                                picture.path + "'";
    ASSERT_EQ(std::system(command.c_str()), 0) << name;
    std::ifstream drawn(png.path, std::ios::binary);
    const std::vector<std::uint8_t> bytes{std::istreambuf_iterator<char>(drawn), {}};
    const Image ours = rasterise(scene), theirs = reduced(decode_png(bytes), 3);
    ASSERT_EQ(ours.rgb.size(), theirs.rgb.size()) << name;
    double sum = 0;
    std::size_t off = 0;
    for (std::size_t i = 0; i < ours.rgb.size(); ++i) {
      const int d = std::abs(ours.rgb[i] - theirs.rgb[i]);
      sum += d * d;
      off += d > 32;
    }
    const auto count = static_cast<double>(ours.rgb.size());
    EXPECT_LT(std::sqrt(sum / count), 4.0) << name;
    EXPECT_LT(static_cast<double>(off) / count, 0.01) << name;
  }
}

}  // namespace
}  // namespace plantloop
