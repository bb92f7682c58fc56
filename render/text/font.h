// The three fonts of a figure: their measures, how they shape words, and their outlines.
//
// Outlines are the designer's curves, unhinted, in units of the em square; so text looks the same at every size and on
// every machine. FreeType and HarfBuzz are known only here. All functions may be called from several threads.

#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "render/scene/scene.h"

namespace plantloop {

enum FontId : int { font_text = 0, font_strong = 1, font_fallback = 2 };
constexpr int font_count = 3;

struct OutlineStep {
  enum Kind : std::uint8_t { move, line, quadratic, cubic };
  Kind kind = move;
  std::int32_t x = 0, y = 0;                    // where the step ends; y up
  std::int32_t x1 = 0, y1 = 0, x2 = 0, y2 = 0;  // control points
};

struct Outline {
  std::vector<OutlineStep> steps;
  std::int32_t left = 0, bottom = 0, right = 0, top = 0;  // box of the points; all 0 when there is nothing to see
};

int units_per_em(int font);

// Of the ink; empty for a space. The reference stays valid.
const Outline& outline(int font, std::uint32_t glyph);

bool has_glyph(int font, char32_t character);

struct Shaped {
  std::vector<GlyphRun::Glyph> glyphs;
  std::int32_t advance = 0;
};

// Places the glyphs of a text in one font, with kerning; `tabular`: digits of equal width.
Shaped shape(int font, std::u32string_view text, bool tabular);

// Name and hash of each font, in the order of FontId.
std::vector<SceneFont> scene_fonts();

}  // namespace plantloop
