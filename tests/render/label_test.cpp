// Facts about set labels.

#include "render/text/label.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "render/text/font.h"
#include "render/text/utf8.h"

namespace plantloop {
namespace {

const LabelStyle style{100, false, false};

std::string said(std::string_view text) { return set_label(text, style).source; }

TEST(Label, ReadsSubAndSuperscripts) {
  EXPECT_EQ(said("x_1"), "x₁");
  EXPECT_EQ(said("x_{max}"), "xₘₐₓ");
  EXPECT_EQ(said("s^{-1}"), "s⁻¹");
  EXPECT_EQ(said("m s^-2"), "m s⁻²");
  EXPECT_EQ(said("m/s²"), "m/s²");
  EXPECT_EQ(said("ω_c"), "ω_c");  // there is no small c below the line in Unicode: said with the mark
}

TEST(Label, KnowsGreekAndSymbols) {
  EXPECT_EQ(said("\\theta_1 [rad]"), "θ₁ [rad]");
  EXPECT_EQ(said("\\Delta x \\le 5\\cdot10^{-3}"), "Δ x ≤ 5·10⁻³");
  EXPECT_EQ(said("\\unknown{x}"), "\\unknown{x}");
  EXPECT_EQ(said("C:\\"), "C:\\");
}

TEST(Label, HasFractionsRootsAndAccents) {
  EXPECT_EQ(said("\\frac{a}{b}"), "a/b");
  EXPECT_EQ(said("\\frac{x_1 + 1}{2}"), "(x₁ + 1)/2");
  EXPECT_EQ(said("\\sqrt{2}"), "√2");
  EXPECT_EQ(said("\\hat{y}(k)"), "y\u0302(k)");
  EXPECT_EQ(said("\\dot\\theta"), "θ\u0307");
  EXPECT_EQ(said("\\frac{\\partial \\hat{y}}{\\partial w}"), "(∂ y\u0302)/(∂ w)");
  EXPECT_EQ(said("\\frac"), "/");
  EXPECT_EQ(said("\\hat{x}_1"), "x\u0302₁");
}

TEST(Label, OfAFractionIsHigherThanItsParts) {
  const Label a = set_label("a", style), fraction = set_label("\\frac{a}{b}", style);
  EXPECT_LT(fraction.top, a.top - 10);
  EXPECT_GT(fraction.bottom, a.bottom + 10);
  EXPECT_GT(fraction.width, 0.8 * a.width);
  const Label root = set_label("\\sqrt{a}", style);
  EXPECT_LT(root.top, a.top - 5);
  EXPECT_GT(root.width, a.width + 20);
}

// The middle of an accent stands over the middle of the letter, whatever its width.
TEST(Label, PutsAccentsOverTheMiddleOfTheLetter) {
  for (const char* letter : {"i", "x", "w", "Y", "θ"}) {
    const Label plain = set_label(letter, style);
    for (const char* accent : {"hat", "bar", "dot", "ddot", "tilde"}) {
      const Label with = set_label(std::string("\\") + accent + "{" + letter + "}", style);
      EXPECT_LT(with.top, plain.top - 5) << accent << ' ' << letter;
      EXPECT_GT(with.top, plain.top - 40) << accent << ' ' << letter;
      EXPECT_EQ(with.width, plain.width) << accent << ' ' << letter;
      const bool wider = with.right - with.left > plain.right - plain.left + 1;
      const double shift = (with.left + with.right) / 2 - (plain.left + plain.right) / 2;
      EXPECT_NEAR(wider ? shift : 0, 0, 1.5) << accent << ' ' << letter;
    }
  }
}

TEST(Label, LeavesUnderscoresOfLongNamesAlone) {
  EXPECT_EQ(said("tire_force"), "tire_force");
  EXPECT_EQ(set_label("tire_force", style).runs.size(), 1u);
  EXPECT_EQ(set_label("v_ref", style).runs.size(), 2u);
  EXPECT_EQ(said("a\\_b"), "a_b");
  EXPECT_EQ(set_label("a\\_b", style).runs.size(), 1u);
}

TEST(Label, TurnsAHyphenThatIsAMinusIntoOne) {
  EXPECT_EQ(said("(-2, -x)"), "(−2, −x)");
  EXPECT_EQ(said("r - y"), "r − y");
  EXPECT_EQ(said("y(k-1), u[k-d]"), "y(k−1), u[k−d]");
  EXPECT_EQ(said("x = -\\frac{x}{\\tau}"), "x = −x/τ");
  for (const char* left : {"closed-loop", "10-20 %", "PT-1", "(mass-spring)", "-shaped", "- "})
    EXPECT_EQ(said(left), left);
  EXPECT_EQ(said("anti-windup 3-4"), "anti-windup 3-4");
}

TEST(Label, HasSubscriptsBelowAndSuperscriptsAboveTheLine) {
  const Label low = set_label("x_1", style), high = set_label("x^1", style), plain = set_label("x", style);
  EXPECT_GT(low.bottom, plain.bottom + 5);
  EXPECT_LT(high.top, plain.top - 10);
}

TEST(Label, MeasuresWhatTheFontSays) {
  // Inter's capital H: 0.727 em high, on the base line.
  const Label h = set_label("H", style);
  EXPECT_NEAR(-h.top, 72.7, 0.5);
  EXPECT_NEAR(h.bottom, 0, 0.5);
  EXPECT_GT(h.width, 60);
  EXPECT_LT(h.width, 85);
}

TEST(Label, IsAsWideAsItsParts) {
  // No kerning across a space.
  const double whole = set_label("speed and time", style).width;
  const double parts =
      set_label("speed ", style).width + set_label("and ", style).width + set_label("time", style).width;
  EXPECT_NEAR(whole, parts, 0.5);
}

TEST(Label, HasDigitsOfOneWidthWhenTabular) {
  const LabelStyle tabular{100, false, true};
  EXPECT_DOUBLE_EQ(set_label("1111", tabular).width, set_label("8888", tabular).width);
  EXPECT_LT(set_label("1111", style).width, set_label("8888", style).width);
}

TEST(Label, FallsBackForSymbolsTheTextFontLacks) {
  const Label label = set_label("∇f", style);
  ASSERT_EQ(label.runs.size(), 2u);
  EXPECT_EQ(label.runs[0].font, font_fallback);
  EXPECT_NE(label.runs[0].glyphs[0].id, 0u);
}

TEST(Label, HasAllGreekLettersAndTheUsualSymbols) {
  for (const char32_t c : std::u32string_view(U"αβγδεζηθικλμνξοπρστυφχψωΓΔΘΛΞΠΣΦΨΩ°±×·√∞∫∑∂≈≤≥−→Δ"))
    EXPECT_TRUE(has_glyph(font_text, c) || has_glyph(font_fallback, c)) << to_utf8(std::u32string(1, c));
}

TEST(Label, IsCutWithAnEllipsis) {
  const Label cut = set_label_within("a label that is much too long", style, 600);
  EXPECT_LE(cut.width, 600);
  EXPECT_TRUE(cut.source.ends_with("…")) << cut.source;
  EXPECT_EQ(set_label_within("short", style, 600).source, "short");
}

TEST(Label, BreaksAtSpaces) {
  const auto lines = set_lines("one two three four", style, 450, 3);
  ASSERT_GE(lines.size(), 2u);
  for (const Label& line : lines) EXPECT_LE(line.width, 450);
}

TEST(Label, SurvivesAnyBytes) {
  for (const char* text :
       {"", "_", "^", "x_", "x^", "x_{", "x^{{}", "\xff\xfe", "a\xc3", "}{", "__", "^^", "\\", "x_{}"})
    EXPECT_GE(set_label(text, style).width, 0) << text;
  EXPECT_EQ(said("a\xff"
                 "b"),
            "a\uFFFD"
            "b");
}

TEST(Utf8, ComesBackAsItWas) {
  const std::string text = "aé∂𝛼";
  EXPECT_EQ(to_utf8(from_utf8(text)), text);
  EXPECT_EQ(from_utf8(text).size(), 4u);
}

TEST(Utf8, RefusesOverlongFormsAndSurrogates) {
  EXPECT_EQ(from_utf8("\xE0\x80\x80"), U"\uFFFD");
  EXPECT_EQ(from_utf8("\xED\xA0\x80"), U"\uFFFD");
}

TEST(Label, KeepsItsUnitWhenItIsCut) {
  const Label cut = set_label_within("temperature of the second tank [°C]", style, 900);
  EXPECT_TRUE(cut.source.starts_with("temp")) << cut.source;
  EXPECT_TRUE(cut.source.ends_with("… [°C]")) << cut.source;
  EXPECT_LE(cut.width, 900);
  EXPECT_EQ(set_label_within("temperature [°C]", style, 10).source, "[°C]");
}

TEST(Label, IsShortenedInTheMiddle) {
  const Label cut = set_label_shortened("a model with a long name, fit 98.2 %", style, 900);
  EXPECT_TRUE(cut.source.starts_with("a model")) << cut.source;
  EXPECT_TRUE(cut.source.ends_with("98.2 %")) << cut.source;
  EXPECT_LE(cut.width, 900);
  EXPECT_EQ(set_label_shortened("short", style, 600).source, "short");
}

TEST(Label, SaysWhatTellsItFromTheOthers) {
  using testing::ElementsAre;
  EXPECT_THAT(distinct_parts({"series number 1 with words", "series number 12 with words"}),
              ElementsAre("…1…", "…12…"));
  EXPECT_THAT(distinct_parts({"run 7", "run 12"}), ElementsAre("…7", "…12"));
  EXPECT_THAT(distinct_parts({"first", "second"}), ElementsAre("first", "second"));
  EXPECT_THAT(distinct_parts({"alone"}), ElementsAre("alone"));
  EXPECT_THAT(distinct_parts({"same", "same"}), ElementsAre("same", "same"));
}

}  // namespace
}  // namespace plantloop
