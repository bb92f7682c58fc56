// Facts about pictures: the same bits always, and the same sight in every format.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <thread>

#include "render/error.h"
#include "render/geometry/curve.h"
#include "render/gl/context.h"
#include "render/image.h"
#include "render/layout.h"
#include "render/scene/dump.h"
#include "tests/render/figures.h"

namespace plantloop {
namespace {

using testing::HasSubstr;

std::string output_of(const std::string& command) {
  std::string result;
  FILE* pipe = popen(command.c_str(), "r");
  std::array<char, 4096> buffer;
  while (const std::size_t n = fread(buffer.data(), 1, buffer.size(), pipe)) result.append(buffer.data(), n);
  return pclose(pipe) == 0 ? result : "";
}

std::vector<std::uint8_t> read(const std::string& name) {
  std::ifstream file(name, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::string scratch(const std::string& name) {
  return testing::TempDir() + "plantloop_" + std::to_string(getpid()) + "_" + name;
}

TEST(Png, HoldsExactlyThePixelsDrawn) {
  const Scene scene = layout(noisy_steps());
  const Image drawn = rasterise(scene), read_back = decode_png(to_png(scene));
  EXPECT_EQ(read_back.width, scene.width);
  EXPECT_EQ(read_back.height, scene.height);
  EXPECT_EQ(drawn.rgb, read_back.rgb);
}

TEST(Png, ThatIsNoneIsRefused) {
  EXPECT_THROW(decode_png(std::vector<std::uint8_t>{1, 2, 3}), RenderError);
  std::vector<std::uint8_t> bytes = to_png(layout(Figure{}));
  bytes.resize(bytes.size() / 2);
  EXPECT_THROW(decode_png(bytes), RenderError);
}

TEST(Png, IsTheSameEveryTime) {
  const Scene scene = layout(noisy_steps());
  EXPECT_EQ(to_png(scene), to_png(scene));
}

TEST(Pixels, AreTheSameForEveryNumberOfThreads) {
  const auto with = [](const std::string& threads) {
    return output_of("LP_NUM_THREADS=" + threads + " " RENDER_GALLERY " . hash servo uncertainty noisy_steps sampled");
  };
  const std::string one = with("1");
  EXPECT_THAT(one, HasSubstr("noisy_steps "));
  EXPECT_EQ(one, with("0"));
  EXPECT_EQ(one, with("8"));
}

TEST(Pixels, AreTheSameFromSeveralThreadsAtOnce) {
  const Scene scene = layout(test_figures()[0].figure);
  const std::vector<std::uint8_t> expected = rasterise(scene).rgb;
  std::array<std::vector<std::uint8_t>, 3> results;
  std::vector<std::thread> threads;
  for (auto& result : results) threads.emplace_back([&] { result = rasterise(scene).rgb; });
  for (std::thread& thread : threads) thread.join();
  for (const auto& result : results) EXPECT_EQ(result, expected);
}

// Shapes of whole pixels have no grey edges, wherever they lie; so strips of the picture do not show.
TEST(Pixels, OfAWholeNumberedBoxAreExact) {
  Scene scene;
  scene.width = 50;
  scene.height = 200;
  scene.dpi = 152.4;
  const auto box = [](int x0, int y0, int x1, int y1, Color color) {
    const Fixed l = x0 * 256, t = y0 * 256, r = x1 * 256, b = y1 * 256;
    return Fill{{{{l, t}, {r, t}, {r, b}, {l, b}}}, color};
  };
  scene.root.add({box(10, 5, 40, 195, rgb(0x0072B2))});
  scene.root.add({box(20, 60, 30, 70, Color{0, 0, 0, 128})});
  const Image image = rasterise(scene);
  for (int y = 0; y < 200; ++y)
    for (int x = 0; x < 50; ++x) {
      const bool inside = x >= 10 && x < 40 && y >= 5 && y < 195, shade = x >= 20 && x < 30 && y >= 60 && y < 70;
      const std::uint8_t* p = &image.rgb[static_cast<std::size_t>(3 * (50 * y + x))];
      const Color expected = !inside ? rgb(0xFFFFFF) : shade ? over({0, 0, 0, 128}, rgb(0x0072B2)) : rgb(0x0072B2);
      // Blending may round either way.
      ASSERT_NEAR(p[0], expected.r, shade ? 1 : 0) << x << ' ' << y;
      ASSERT_NEAR(p[1], expected.g, shade ? 1 : 0) << x << ' ' << y;
      ASSERT_NEAR(p[2], expected.b, shade ? 1 : 0) << x << ' ' << y;
    }
}

TEST(Pixels, OfAHalfCoveredColumnAreHalfGrey) {
  Scene scene;
  scene.width = scene.height = 8;
  scene.dpi = 152.4;
  scene.root.add({Stroke{{{{4 * 256, 0}, {4 * 256, 8 * 256}}}, 256, {}, Stroke::Cap::butt, rgb(0)}});
  const Image image = rasterise(scene);
  // A line of one pixel in width, centred between columns 3 and 4: 8 of 16 samples in each.
  EXPECT_EQ(image.rgb[3 * (8 * 4 + 3)], 128);
  EXPECT_EQ(image.rgb[3 * (8 * 4 + 4)], 128);
  EXPECT_EQ(image.rgb[3 * (8 * 4 + 2)], 255);
}

TEST(Pixels, OfATranslucentLineDoNotDarkenWhereItCrossesItself) {
  Scene scene;
  scene.width = scene.height = 40;
  scene.dpi = 152.4;
  const auto p = [](int x, int y) { return Point{x * 256, y * 256}; };
  scene.root.add(
      {Stroke{{{p(5, 5), p(35, 35), p(35, 5), p(5, 35)}}, 6 * 256, {}, Stroke::Cap::butt, Color{0, 0, 0, 100}}});
  const Image image = rasterise(scene);
  const std::uint8_t crossing = image.rgb[3 * (40 * 20 + 20)], arm = image.rgb[3 * (40 * 10 + 10)];
  EXPECT_EQ(crossing, arm);
  EXPECT_LT(arm, 255);
}

double difference(const Image& a, const Image& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.rgb.size(); ++i) sum += (a.rgb[i] - b.rgb[i]) * (a.rgb[i] - b.rgb[i]);
  return std::sqrt(sum / static_cast<double>(a.rgb.size()));
}

// 2.5 of 255 is what another rasteriser makes of the same scene.
TEST(Pixels, OfADecimatedCurveAreThoseOfAllItsSamples) {
  Curve all;
  std::uint32_t state = 11;
  for (int i = 0; i < 10000; ++i) {
    state = state * 1664525u + 1013904223u;
    const double x = 20 + 0.1 * i;
    all.push_back({x, 400 + 300 * std::sin(0.02 * x) + 12 * static_cast<double>(state >> 8) / 16777216.0});
  }
  const auto drawn = [](const Curve& curve) {
    Scene scene;
    scene.width = 1040;
    scene.height = 800;
    scene.root.add({Stroke{{to_polyline(curve)}, 512, {}, Stroke::Cap::round, Color{0, 114, 178}}});
    return rasterise(scene);
  };
  const Image full = drawn(all);
  EXPECT_LT(difference(full, drawn(decimate_columns(all, 0.6))), 2.5);
  EXPECT_GT(difference(full, drawn(decimate_columns(all, 4))), 2.5);
}

// The goals for the reference figure: five curves of 10 000 noisy samples at 1200 x 800.
TEST(Files, OfTheReferenceFigureAreSmall) {
  const Scene scene = layout(noisy_steps());
  EXPECT_LT(to_png(scene).size(), 75'000u);
  EXPECT_LT(to_svg(scene).size(), 110'000u);
  EXPECT_LT(picture(scene, "pdf").size(), 120'000u);
}

TEST(OsMesa, SaysHowToInstallIt) {
  const std::array names{"libNoSuchThing.so"};
  try {
    open_osmesa(names);
    FAIL();
  } catch (const RenderError& e) {
    EXPECT_STREQ(e.what(), "OSMesa is not installed: apt install libosmesa6");
  }
}

TEST(Egl, DrawsTheSamePixelsAsOsMesa) {
  const auto with = [](const std::string& door) {
    return output_of("PLANTLOOP_GL=" + door + " " RENDER_GALLERY " . hash servo uncertainty sampled 2> /dev/null");
  };
  const std::string egl = with("egl");
  if (egl.empty()) GTEST_SKIP() << "EGL is not installed";
  EXPECT_EQ(egl, with("osmesa"));
}

TEST(Doors, LeadToEglWhereOsMesaIsMissingAndSayWhatToInstallWhereBothAre) {
  const std::array names{"libNoSuchThing.so"};
  try {
    EXPECT_NE(open_gl("", names), nullptr);
  } catch (const RenderError& e) {
    EXPECT_STREQ(e.what(), "neither OSMesa nor EGL is installed: apt install libosmesa6");
  }
  try {
    open_gl("vulkan");
    FAIL();
  } catch (const RenderError& e) {
    EXPECT_STREQ(e.what(), "PLANTLOOP_GL is 'vulkan'; it may be osmesa or egl, or be left out");
  }
}

TEST(Json, IsTheCanonicalTextOfTheScene) {
  const Scene scene = layout(Figure{.title = "a"});
  const std::vector<std::uint8_t> bytes = picture(scene, "json");
  EXPECT_EQ(std::string(bytes.begin(), bytes.end()), to_json(scene));
}

TEST(Picture, RefusesAnUnknownFormat) {
  try {
    picture(layout(Figure{}), "gif");
    FAIL();
  } catch (const RenderError& e) {
    EXPECT_THAT(e.what(), HasSubstr("there is no picture format 'gif'; there are: json, pdf, png, svg"));
  }
}

TEST(Svg, SpeaksItsWords) {
  const std::string svg = to_svg(layout(test_figures()[0].figure));
  EXPECT_THAT(svg, HasSubstr("aria-label=\"position [m]\""));
  EXPECT_THAT(svg, HasSubstr("aria-label=\"drive [m/s²]\""));
  EXPECT_THAT(svg, HasSubstr("<title>Step response of a servo</title>"));
  EXPECT_THAT(svg, HasSubstr("id=\"panel/0/series/1\" aria-label=\"position\""));
}

TEST(Svg, EscapesWhatXmlReserves) {
  const std::string svg = to_svg(layout(Figure{.title = "a < b & \"c\""}));
  EXPECT_THAT(svg, HasSubstr("<title>a &lt; b &amp; &quot;c&quot;</title>"));
}

// The tolerances are those of measurements with other rasterisers: antialiasing differs, shapes do not. A title 2.5 %
// too wide already gives a root mean square of 9.
TEST(Svg, LooksLikeThePng) {
  if (std::system("rsvg-convert --version > /dev/null 2>&1") != 0) GTEST_SKIP() << "rsvg-convert is not installed";
  for (const auto& [name, figure] : test_figures()) {
    if (name == "many_300" || name == "many_40") continue;  // all edges, no areas
    const Scene scene = layout(figure);
    const std::string svg = scratch(name + ".svg"), png = scratch(name + ".png");
    std::ofstream(svg) << to_svg(scene);
    ASSERT_EQ(std::system(("rsvg-convert '" + svg + "' -o '" + png + "'").c_str()), 0) << name;
    const Image ours = rasterise(scene), theirs = decode_png(read(png));
    std::remove(svg.c_str());
    std::remove(png.c_str());
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
    EXPECT_LT(static_cast<double>(off) / count, 0.006) << name;
  }
}

}  // namespace
}  // namespace plantloop
