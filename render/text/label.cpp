// The small markup of labels, font fallback, and measuring.

#include "render/text/label.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "render/text/font.h"
#include "render/text/utf8.h"

namespace plantloop {
namespace {

// Characters at one height: 0 on the base line, 1 above, -1 below.
struct Piece {
  int level = 0;
  std::u32string text;
};

struct Script {
  char32_t raised, plain;
};
constexpr Script superscripts[] = {{U'⁰', U'0'}, {U'¹', U'1'}, {U'²', U'2'}, {U'³', U'3'}, {U'⁴', U'4'}, {U'⁵', U'5'},
                                   {U'⁶', U'6'}, {U'⁷', U'7'}, {U'⁸', U'8'}, {U'⁹', U'9'}, {U'⁺', U'+'}, {U'⁻', U'−'},
                                   {U'⁼', U'='}, {U'⁽', U'('}, {U'⁾', U')'}, {U'ⁿ', U'n'}, {U'ⁱ', U'i'}};
constexpr Script subscripts[] = {{U'₀', U'0'}, {U'₁', U'1'}, {U'₂', U'2'}, {U'₃', U'3'}, {U'₄', U'4'}, {U'₅', U'5'},
                                 {U'₆', U'6'}, {U'₇', U'7'}, {U'₈', U'8'}, {U'₉', U'9'}, {U'₊', U'+'}, {U'₋', U'−'},
                                 {U'₌', U'='}, {U'₍', U'('}, {U'₎', U')'}, {U'ₐ', U'a'}, {U'ₑ', U'e'}, {U'ₒ', U'o'},
                                 {U'ₓ', U'x'}, {U'ₕ', U'h'}, {U'ₖ', U'k'}, {U'ₗ', U'l'}, {U'ₘ', U'm'}, {U'ₙ', U'n'},
                                 {U'ₚ', U'p'}, {U'ₛ', U's'}, {U'ₜ', U't'}, {U'ᵢ', U'i'}, {U'ⱼ', U'j'}};

bool is_digit(char32_t c) { return c >= U'0' && c <= U'9'; }

bool is_letter(char32_t c) {
  return (c >= U'a' && c <= U'z') || (c >= U'A' && c <= U'Z') || (c >= 0xC0 && c < 0x2000 && c != 0xD7 && c != 0xF7);
}

bool is_word(char32_t c) { return is_letter(c) || is_digit(c); }

struct Parser {
  std::u32string_view text;
  std::size_t at = 0;
  std::vector<Piece> pieces;

  void put(int level, char32_t c) {
    if (pieces.empty() || pieces.back().level != level) pieces.push_back({level, {}});
    pieces.back().text += c;
  }

  char32_t next(std::size_t ahead = 0) const { return at + ahead < text.size() ? text[at + ahead] : U'\0'; }

  // How many letters and digits stand right before the mark.
  std::size_t name_before(std::size_t mark) const {
    std::size_t count = 0;
    while (count < mark && is_word(text[mark - 1 - count])) ++count;
    return count;
  }

  void braces(int level) {
    int depth = 1;
    for (++at; at < text.size(); ++at) {
      if (text[at] == U'{') ++depth;
      if (text[at] == U'}' && --depth == 0) {
        ++at;
        return;
      }
      if (text[at] != U'{' && text[at] != U'}') put(level, text[at] == U'-' ? U'−' : text[at]);
    }
  }

  void word(int level) {
    while (is_word(next())) put(level, text[at++]);
  }

  void number(int level) {
    if (next() == U'-' || next() == U'−' || next() == U'+') put(level, text[at] == U'-' ? U'−' : text[at]), ++at;
    while (is_digit(next())) put(level, text[at++]);
  }

  bool subscript() {
    const std::size_t name = name_before(at);
    const bool after_bracket = at > 0 && (text[at - 1] == U')' || text[at - 1] == U'}');
    if (next(1) == U'{') {
      ++at;
      braces(-1);
      return true;
    }
    if ((name == 0 && !after_bracket) || name > 2 || !is_word(next(1))) return false;
    ++at;
    word(-1);
    return true;
  }

  bool superscript() {
    if (at == 0) return false;
    if (next(1) == U'{') {
      ++at;
      braces(1);
      return true;
    }
    const bool sign = next(1) == U'-' || next(1) == U'−' || next(1) == U'+';
    if (is_digit(next(1)) || (sign && is_digit(next(2)))) {
      ++at;
      number(1);
      return true;
    }
    if (!is_letter(next(1)) && next(1) != U'*') return false;
    ++at;
    put(1, text[at++]);
    return true;
  }

  bool unicode_script(const Script* begin, const Script* end, int level) {
    const auto* found = std::find_if(begin, end, [&](const Script& s) { return s.raised == text[at]; });
    if (found == end) return false;
    put(level, found->plain);
    ++at;
    return true;
  }

  bool minus() const {
    if (text[at] != U'-' || !(is_digit(next(1)) || next(1) == U'.' || next(1) == U'∞')) return false;
    return at == 0 || text[at - 1] == U' ' || text[at - 1] == U'(' || text[at - 1] == U'=' || text[at - 1] == U'[';
  }

  std::vector<Piece> parse() {
    while (at < text.size()) {
      const char32_t c = text[at];
      if (c == U'\\' && (next(1) == U'_' || next(1) == U'^')) {
        put(0, next(1));
        at += 2;
      } else if ((c == U'_' && subscript()) || (c == U'^' && superscript())) {
        continue;
      } else if (unicode_script(std::begin(superscripts), std::end(superscripts), 1) ||
                 unicode_script(std::begin(subscripts), std::end(subscripts), -1)) {
        continue;
      } else {
        put(0, minus() ? U'−' : (c < 0x20 ? U' ' : c));
        ++at;
      }
    }
    return std::move(pieces);
  }
};

int font_for(char32_t c, int wanted) {
  if (has_glyph(wanted, c) || !has_glyph(font_fallback, c)) return wanted;
  return font_fallback;
}

Fixed fixed(double pixels) { return static_cast<Fixed>(std::lround(pixels * 256)); }

// Adds one piece's runs behind what the label already has.
void append(Label& label, const Piece& piece, const LabelStyle& style, double& pen) {
  const double size = piece.level == 0 ? style.size : 0.73 * style.size;
  const double lift = piece.level > 0 ? 0.36 * style.size : piece.level < 0 ? -0.17 * style.size : 0;
  const int wanted = style.strong ? font_strong : font_text;
  for (std::size_t begin = 0; begin < piece.text.size();) {
    const int font = font_for(piece.text[begin], wanted);
    std::size_t end = begin + 1;
    while (end < piece.text.size() && font_for(piece.text[end], wanted) == font) ++end;
    const Shaped shaped = shape(font, std::u32string_view(piece.text).substr(begin, end - begin), style.tabular);
    GlyphRun run{font, fixed(size), {fixed(pen), fixed(-lift)}, shaped.glyphs};
    const double scale = size / units_per_em(font);
    for (const auto& glyph : run.glyphs) {
      const Outline& ink = outline(font, glyph.id);
      if (ink.steps.empty()) continue;
      label.left = std::min(label.left, pen + (glyph.x + ink.left) * scale);
      label.right = std::max(label.right, pen + (glyph.x + ink.right) * scale);
      label.top = std::min(label.top, -lift - (glyph.y + ink.top) * scale);
      label.bottom = std::max(label.bottom, -lift - (glyph.y + ink.bottom) * scale);
    }
    label.runs.push_back(std::move(run));
    pen += shaped.advance * scale;
    begin = end;
  }
}

std::u32string readable(const std::vector<Piece>& pieces) {
  std::u32string result;
  for (const Piece& piece : pieces) {
    std::u32string marked;
    bool all = true;
    for (const char32_t c : piece.text) {
      const auto find = [&](const Script* begin, const Script* end) {
        const auto* found = std::find_if(begin, end, [&](const Script& s) { return s.plain == c; });
        if (found == end)
          all = false;
        else
          marked += found->raised;
      };
      if (piece.level > 0) find(std::begin(superscripts), std::end(superscripts));
      if (piece.level < 0) find(std::begin(subscripts), std::end(subscripts));
    }
    if (piece.level == 0)
      result += piece.text;
    else if (all)
      result += marked;
    else
      result += (piece.level > 0 ? U"^" : U"_") + piece.text;
  }
  return result;
}

}  // namespace

Label set_label(std::string_view text, const LabelStyle& style) {
  const std::u32string characters = from_utf8(text);
  Label label;
  label.size = style.size;
  const std::vector<Piece> pieces = Parser{characters, 0, {}}.parse();
  label.source = to_utf8(readable(pieces));
  double pen = 0;
  // Sub- and superscript of one letter stand above each other.
  double script_start = 0, script_end = 0;
  int previous = 0;
  for (const Piece& piece : pieces) {
    if (piece.level == 0) pen = std::max(pen, script_end);
    if (piece.level != 0 && previous == 0) script_start = pen;
    if (piece.level != 0 && previous == -piece.level) pen = script_start;
    append(label, piece, style, pen);
    script_end = piece.level == 0 ? 0 : std::max(script_end, pen);
    previous = piece.level;
  }
  label.width = std::max(pen, script_end);
  return label;
}

Label set_label_within(std::string_view text, const LabelStyle& style, double width) {
  Label whole = set_label(text, style);
  if (whole.width <= width) return whole;
  const std::u32string characters = from_utf8(text);
  std::size_t fits = 0, fails = characters.size();
  while (fails - fits > 1) {
    const std::size_t middle = (fits + fails) / 2;
    const Label part = set_label(to_utf8(characters.substr(0, middle)) + "…", style);
    (part.width <= width ? fits : fails) = middle;
  }
  std::u32string kept = characters.substr(0, fits);
  while (!kept.empty() && kept.back() == U' ') kept.pop_back();
  return set_label(to_utf8(kept) + "…", style);
}

std::vector<Label> set_lines(std::string_view text, const LabelStyle& style, double width, int lines) {
  std::vector<Label> result;
  while (!text.empty() && result.size() + 1 < static_cast<std::size_t>(lines)) {
    if (set_label(text, style).width <= width) break;
    std::size_t cut = std::string_view::npos;
    for (std::size_t space = text.find(' '); space != std::string_view::npos; space = text.find(' ', space + 1)) {
      if (set_label(text.substr(0, space), style).width > width) break;
      cut = space;
    }
    if (cut == std::string_view::npos || cut == 0) break;
    result.push_back(set_label(text.substr(0, cut), style));
    text.remove_prefix(cut + 1);
  }
  if (!text.empty()) result.push_back(set_label_within(text, style, width));
  return result;
}

TextRun place(const Label& label, double x, double y, int turns, Color color, Color background) {
  TextRun text{label.source, {fixed(x), fixed(y)}, turns, {}, label.runs, color, background};
  const Fixed left = fixed(label.left), right = fixed(label.right), top = fixed(label.top),
              bottom = fixed(label.bottom);
  const auto [ox, oy] = text.origin;
  switch (turns & 3) {
    case 0:
      text.box = {ox + left, oy + top, ox + right, oy + bottom};
      break;
    case 1:
      text.box = {ox + top, oy - right, ox + bottom, oy - left};
      break;
    case 2:
      text.box = {ox - right, oy - bottom, ox - left, oy - top};
      break;
    default:
      text.box = {ox - bottom, oy + left, ox - top, oy + right};
      break;
  }
  return text;
}

}  // namespace plantloop
