// Setting labels: font fallback, scripts, fractions, roots and accents, and measuring.

#include "render/text/label.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "render/text/font.h"
#include "render/text/markup.h"
#include "render/text/utf8.h"

namespace plantloop {
namespace {

int font_for(char32_t c, int wanted) {
  if (has_glyph(wanted, c) || !has_glyph(font_fallback, c)) return wanted;
  return font_fallback;
}

Fixed fixed(double pixels) { return static_cast<Fixed>(std::lround(pixels * 256)); }

// Puts a label that is set already behind another's beginning.
void merge(Label& label, const Label& part, double dx, double dy) {
  for (GlyphRun run : part.runs) {
    run.at.x += fixed(dx);
    run.at.y += fixed(dy);
    label.runs.push_back(std::move(run));
  }
  label.left = std::min(label.left, dx + part.left);
  label.right = std::max(label.right, dx + part.right);
  label.top = std::min(label.top, dy + part.top);
  label.bottom = std::max(label.bottom, dy + part.bottom);
}

Label set_text(std::u32string_view text, const LabelStyle& style) {
  Label label;
  double pen = 0;
  const int wanted = style.strong ? font_strong : font_text;
  for (std::size_t begin = 0; begin < text.size();) {
    const int font = font_for(text[begin], wanted);
    std::size_t end = begin + 1;
    while (end < text.size() && font_for(text[end], wanted) == font) ++end;
    const Shaped shaped = shape(font, text.substr(begin, end - begin), style.tabular);
    GlyphRun run{font, fixed(style.size), {fixed(pen), 0}, shaped.glyphs};
    const double scale = style.size / units_per_em(font);
    for (const auto& glyph : run.glyphs) {
      const Outline& ink = outline(font, glyph.id);
      if (ink.steps.empty()) continue;
      label.left = std::min(label.left, pen + (glyph.x + ink.left) * scale);
      label.right = std::max(label.right, pen + (glyph.x + ink.right) * scale);
      label.top = std::min(label.top, -(glyph.y + ink.top) * scale);
      label.bottom = std::max(label.bottom, -(glyph.y + ink.bottom) * scale);
    }
    label.runs.push_back(std::move(run));
    pen += shaped.advance * scale;
    begin = end;
  }
  label.width = pen;
  return label;
}

// Of one character, with the ink's own ends and not the origin's.
struct Sign {
  int font = font_text;
  std::uint32_t glyph = 0;
  double left = 0, right = 0, top = 0, bottom = 0;  // of the ink at one pixel to the em, y up
};
Sign sign(char32_t character, const LabelStyle& style) {
  Sign s;
  s.font = font_for(character, style.strong ? font_strong : font_text);
  const Shaped shaped = shape(s.font, std::u32string_view(&character, 1), false);
  if (shaped.glyphs.empty()) return s;
  s.glyph = shaped.glyphs[0].id;
  const Outline& ink = outline(s.font, s.glyph);
  const double em = units_per_em(s.font);
  s.left = ink.left / em, s.right = ink.right / em, s.top = ink.top / em, s.bottom = ink.bottom / em;
  return s;
}

// A sign at a size, with its ink's left end and lower end there; y down.
void put_sign(Label& label, const Sign& s, double size, double left, double bottom) {
  Label part;
  part.runs.push_back({s.font, fixed(size), {0, 0}, {{s.glyph, 0, 0}}});
  part.left = s.left * size, part.right = s.right * size, part.top = -s.top * size, part.bottom = -s.bottom * size;
  merge(label, part, left - s.left * size, bottom + s.bottom * size);
}

// A thin bar, of the strokes that tables are drawn with: so it is text in every format. `middle` is its height, y down.
void put_bar(Label& label, const LabelStyle& style, double left, double middle, double width) {
  const Sign stroke = sign(U'─', style);
  const double tall = stroke.top - stroke.bottom, wide = stroke.right - stroke.left;
  if (!(tall > 0) || !(wide > 0)) return;
  const double size = std::min(0.055 * style.size / tall, width / wide), each = wide * size;
  const int count = std::max(1, static_cast<int>(std::ceil(width / each - 1e-9)));
  for (int i = 0; i < count; ++i) {
    const double at = count == 1 ? 0 : (width - each) * i / (count - 1);
    put_sign(label, stroke, size, left + at, middle + tall * size / 2);
  }
}

Label set_pieces(const std::vector<Piece>& pieces, const LabelStyle& style);

Label set_fraction(const Piece& piece, const LabelStyle& style) {
  const LabelStyle small{0.8 * style.size, style.strong, style.tabular};
  const Label above = set_pieces(piece.parts[0], small), below = set_pieces(piece.parts[1], small);
  const double side = 0.08 * style.size, gap = 0.13 * style.size, middle = -0.32 * style.size;
  Label label;
  label.width = std::max(above.width, below.width) + 4 * side;
  put_bar(label, style, side, middle, label.width - 2 * side);
  merge(label, above, (label.width - above.width) / 2, middle - gap - std::max(above.bottom, 0.0));
  merge(label, below, (label.width - below.width) / 2, middle + gap - std::min(below.top, -x_height * small.size));
  return label;
}

Label set_root(const Piece& piece, const LabelStyle& style) {
  const Label body = set_pieces(piece.parts[0], style);
  const Sign root = sign(U'√', style);
  const double gap = 0.12 * style.size, bottom = std::max(body.bottom, 0.0) + 0.03 * style.size;
  const double top = std::min(body.top, -x_height * style.size) - gap;
  const double size = (bottom - top) / std::max(root.top - root.bottom, 0.1);
  const double wide = (root.right - root.left) * size, thick = 0.055 * style.size;
  Label label;
  put_sign(label, root, size, 0.03 * style.size, bottom);
  const double start = 0.03 * style.size + wide;
  put_bar(label, style, start - 0.4 * thick, top + thick / 2, body.width + 0.14 * style.size);
  merge(label, body, start + 0.04 * style.size, 0);
  label.width = start + body.width + 0.16 * style.size;
  return label;
}

// Above the middle of the ink, at one distance from it whatever the letter.
Label set_accent(const Piece& piece, const LabelStyle& style) {
  Label label = set_pieces(piece.parts[0], style);
  const double middle = (label.left + label.right) / 2,
               above = std::min(label.top, -0.4 * style.size) - 0.09 * style.size;
  const char32_t mark = piece.text[0];
  if (mark == U'\u0304') {
    const double width = std::max(0.8 * (label.right - label.left), 0.3 * style.size);
    put_bar(label, style, middle - width / 2, above - 0.02 * style.size, width);
    return label;
  }
  const char32_t spacing = mark == U'\u0302' ? U'ˆ' : mark == U'\u0307' ? U'˙' : mark == U'\u0308' ? U'¨' : U'˜';
  const Sign s = sign(spacing, style);
  put_sign(label, s, style.size, middle - (s.right - s.left) * style.size / 2, above);
  return label;
}

Label set_piece(const Piece& piece, const LabelStyle& style) {
  switch (piece.kind) {
    case Piece::Kind::fraction:
      return set_fraction(piece, style);
    case Piece::Kind::root:
      return set_root(piece, style);
    case Piece::Kind::accent:
      return set_accent(piece, style);
    case Piece::Kind::text:
      break;
  }
  return set_text(piece.text, style);
}

Label set_pieces(const std::vector<Piece>& pieces, const LabelStyle& style) {
  Label label;
  double pen = 0;
  // Sub- and superscript of one letter stand above each other.
  double script_start = 0, script_end = 0;
  int previous = 0;
  for (const Piece& piece : pieces) {
    if (piece.level == 0) pen = std::max(pen, script_end);
    if (piece.level != 0 && previous == 0) script_start = pen;
    if (piece.level != 0 && previous == -piece.level) pen = script_start;
    const double size = piece.level == 0 ? style.size : 0.73 * style.size;
    const double lift = piece.level > 0 ? 0.36 * style.size : piece.level < 0 ? -0.17 * style.size : 0;
    const bool stacked = piece.level != 0 && previous == -piece.level;
    const double apart = stacked ? 0.1 * style.size * piece.level : 0;
    const Label part = set_piece(piece, {size, style.strong, style.tabular});
    merge(label, part, pen, -lift - apart);
    pen += part.width;
    script_end = piece.level == 0 ? 0 : std::max(script_end, pen);
    previous = piece.level;
  }
  label.width = std::max(pen, script_end);
  return label;
}

}  // namespace

Label set_label(std::string_view text, const LabelStyle& style) {
  const std::vector<Piece> pieces = parse_markup(from_utf8(text));
  Label label = set_pieces(pieces, style);
  label.size = style.size;
  label.source = to_utf8(readable(pieces));
  return label;
}

Label set_label_within(std::string_view text, const LabelStyle& style, double width) {
  Label whole = set_label(text, style);
  if (whole.width <= width) return whole;
  const std::size_t bracket = text.ends_with(']') ? text.rfind(" [") : std::string_view::npos;
  const std::string unit = bracket == std::string_view::npos ? "" : std::string(text.substr(bracket));
  const std::u32string characters = from_utf8(text.substr(0, bracket));
  std::size_t fits = 0, fails = characters.size();
  while (fails - fits > 1) {
    const std::size_t middle = (fits + fails) / 2;
    const Label part = set_label(to_utf8(characters.substr(0, middle)) + "…" + unit, style);
    (part.width <= width ? fits : fails) = middle;
  }
  std::u32string kept = characters.substr(0, fits);
  while (!kept.empty() && kept.back() == U' ') kept.pop_back();
  if (kept.empty() && !unit.empty()) return set_label(unit.substr(1), style);
  return set_label(to_utf8(kept) + "…" + unit, style);
}

Label set_label_shortened(std::string_view text, const LabelStyle& style, double width) {
  Label best = set_label(text, style);
  if (best.width <= width) return best;
  // Braces belong together: markup is cut at the end only.
  if (text.find_first_of("{\\") != std::string_view::npos) return set_label_within(text, style, width);
  const std::u32string characters = from_utf8(text);
  const auto shortened = [&](std::size_t kept) {
    std::u32string head = characters.substr(0, kept - kept / 2), tail = characters.substr(characters.size() - kept / 2);
    while (!head.empty() && head.back() == U' ') head.pop_back();
    while (!tail.empty() && tail.front() == U' ') tail.erase(0, 1);
    return set_label(to_utf8(head) + "…" + to_utf8(tail), style);
  };
  std::size_t fits = 0, fails = characters.size();
  while (fails - fits > 1) {
    const std::size_t middle = (fits + fails) / 2;
    (shortened(middle).width <= width ? fits : fails) = middle;
  }
  return shortened(fits);
}

std::vector<std::string> distinct_parts(const std::vector<std::string>& texts) {
  if (texts.size() < 2) return texts;
  const std::string& first = texts.front();
  std::size_t shortest = first.size(), head = first.size(), tail = first.size();
  for (const std::string& text : texts) {
    shortest = std::min(shortest, text.size());
    head =
        std::min(head, static_cast<std::size_t>(
                           std::mismatch(first.begin(), first.end(), text.begin(), text.end()).first - first.begin()));
    tail = std::min(
        tail, static_cast<std::size_t>(std::mismatch(first.rbegin(), first.rend(), text.rbegin(), text.rend()).first -
                                       first.rbegin()));
  }
  // Back to the ends of words.
  const auto at_end = [&](const std::string& text, std::size_t size) { return size == 0 || text[size - 1] == ' '; };
  while (!at_end(first, head)) --head;
  while (tail > 0 && first[first.size() - tail] != ' ') --tail;
  if (head + tail >= shortest) tail = 0;
  if (head >= shortest) head = 0;
  if (head == 0 && tail == 0) return texts;
  std::vector<std::string> parts;
  for (const std::string& text : texts)
    parts.push_back((head > 0 ? "…" : "") + text.substr(head, text.size() - head - tail) + (tail > 0 ? "…" : ""));
  return parts;
}

std::vector<Label> set_lines(std::string_view text, const LabelStyle& style, double width, int lines) {
  std::vector<Label> result;
  while (!text.empty() && result.size() + 1 < static_cast<std::size_t>(lines)) {
    if (set_label(text, style).width <= width) break;
    std::size_t cut = std::string_view::npos;
    for (std::size_t space = text.find(' '); space != std::string_view::npos; space = text.find(' ', space + 1)) {
      // Not inside braces.
      const std::string_view before = text.substr(0, space);
      if (std::count(before.begin(), before.end(), '{') > std::count(before.begin(), before.end(), '}')) continue;
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
