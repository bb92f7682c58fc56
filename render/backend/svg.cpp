// SVG: paths with coordinates in hundredths of a pixel, each glyph's outline once, groups named by their roles.
//
// Most of a file is the thousands of points of measured signals. Their coordinates are whole eighths of a pixel under a
// scaling: a point is two numbers of one or two digits.

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <utility>

#include "render/backend/backend.h"
#include "render/image.h"
#include "render/text/font.h"

namespace plantloop {
namespace {

std::string escaped(std::string_view text) {
  std::string result;
  for (const char c : text) {
    if (c == '&')
      result += "&amp;";
    else if (c == '<')
      result += "&lt;";
    else if (c == '>')
      result += "&gt;";
    else if (c == '"')
      result += "&quot;";
    else if (static_cast<unsigned char>(c) >= 0x20)
      result += c;
  }
  return result;
}

// 1/256 pixel -> hundredths, rounded.
std::int64_t hundredths(Fixed v) { return (std::int64_t{v} * 100 + (v < 0 ? -128 : 128)) / 256; }

std::int64_t eighths(Fixed v) { return (std::int64_t{v} + (v < 0 ? -16 : 16)) / 32; }

class Writer {
 public:
  std::string write(const Scene& scene) {
    put("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{}\" height=\"{}\" viewBox=\"0 0 {} {}\" role=\"img\" "
        "stroke-linejoin=\"round\">\n",
        scene.width, scene.height, scene.width, scene.height);
    if (!scene.title.empty()) put("<title>{}</title>\n", escaped(scene.title));
    std::string head = std::move(out_);
    out_.clear();
    put("<path fill=\"{}\" d=\"M0 0H{}V{}H0z\"/>\n", color(scene.background), scene.width, scene.height);
    selectable_ = scene.selectable_text;
    group(scene.root);
    out_ += "</svg>\n";
    std::string body = std::move(out_);
    out_.clear();
    definitions();
    return head + out_ + body;
  }

 private:
  std::string out_;
  bool selectable_ = false;
  std::map<Rect, int, bool (*)(const Rect&, const Rect&)> clips_{[](const Rect& a, const Rect& b) {
    return std::tuple(a.left, a.top, a.right, a.bottom) < std::tuple(b.left, b.top, b.right, b.bottom);
  }};
  std::map<std::pair<int, std::uint32_t>, std::size_t> glyphs_;  // numbered as they come

  template <typename... Args>
  void put(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(out_), format, std::forward<Args>(args)...);
  }

  static std::string color(Color c) { return fmt::format("#{:02x}{:02x}{:02x}", c.r, c.g, c.b); }

  void opacity(const char* name, Color c) {
    if (c.a < 255) put(" {}=\"{:.4g}\"", name, c.a / 255.0);
  }

  // A number of hundredths, as short as can be, set off from the one before if need be.
  void number(std::int64_t v, bool first) {
    if (!first && v >= 0) out_ += ' ';
    if (v < 0) out_ += '-';
    const std::int64_t a = v < 0 ? -v : v;
    const std::int64_t whole = a / 100, part = a % 100;
    if (whole > 0 || part == 0) out_ += std::to_string(whole);
    if (part > 0) put(".{:02}", part);
    if (part > 0 && part % 10 == 0) out_.pop_back();
  }

  // The rest of "translate(".
  void place(Point p) {
    number(hundredths(p.x), true);
    number(hundredths(p.y), false);
    out_ += ')';
  }

  void path(const Polyline& line, bool closed) {
    std::int64_t x = 0, y = 0;
    for (std::size_t i = 0; i < line.size(); ++i) {
      const std::int64_t nx = hundredths(line[i].x), ny = hundredths(line[i].y);
      if (i == 0) out_ += 'M';
      if (i == 1) out_ += 'l';
      number(nx - x, i < 2);
      number(ny - y, false);
      x = nx;
      y = ny;
    }
    if (closed) out_ += 'z';
  }

  void long_path(const Polyline& line) {
    std::int64_t x = 0, y = 0;
    for (std::size_t i = 0; i < line.size(); ++i) {
      const std::int64_t nx = eighths(line[i].x), ny = eighths(line[i].y);
      if (i > 1 && nx == x && ny == y) continue;
      if (i == 0) out_ += 'M';
      if (i == 1) out_ += 'l';
      whole(nx - x, i < 2);
      whole(ny - y, false);
      x = nx;
      y = ny;
    }
  }

  static bool is_long(const Stroke& stroke) {
    std::size_t points = 0;
    for (const Polyline& line : stroke.lines) points += line.size();
    return points > 500;
  }

  void item(const Fill& fill) {
    put("<path fill=\"{}\"", color(fill.color));
    opacity("fill-opacity", fill.color);
    out_ += " d=\"";
    for (const Polyline& ring : fill.rings) path(ring, true);
    out_ += "\"/>\n";
  }

  void item(const Stroke& stroke) {
    const bool in_eighths = is_long(stroke);
    const int scale = in_eighths ? 8 : 1;
    put("<path fill=\"none\" stroke=\"{}\" stroke-width=\"", color(stroke.color));
    number(hundredths(scale * stroke.width), true);
    out_ += '"';
    opacity("stroke-opacity", stroke.color);
    if (stroke.cap == Stroke::Cap::round) out_ += " stroke-linecap=\"round\"";
    if (!stroke.dashes.empty()) {
      out_ += " stroke-dasharray=\"";
      for (std::size_t i = 0; i < stroke.dashes.size(); ++i) number(hundredths(scale * stroke.dashes[i]), i == 0);
      out_ += '"';
    }
    if (in_eighths) out_ += " transform=\"scale(.125)\"";
    out_ += " d=\"";
    for (const Polyline& line : stroke.lines) in_eighths ? long_path(line) : path(line, false);
    out_ += "\"/>\n";
  }

  void item(const TextRun& text) {
    put("<g role=\"img\" aria-label=\"{}\" fill=\"{}\" transform=\"translate(", escaped(text.source),
        color(text.color));
    place(text.origin);
    if (text.turns != 0) put("rotate({})", -90 * text.turns);
    out_ += "\">";
    for (const GlyphRun& run : text.runs) {
      const double scale = run.size / (256.0 * units_per_em(run.font));
      out_ += "<g transform=\"";
      if (run.at != Point{}) {
        out_ += "translate(";
        place(run.at);
      }
      put("scale({:.7g})\">", scale);
      for (const GlyphRun::Glyph& glyph : run.glyphs) {
        if (outline(run.font, glyph.id).steps.empty()) continue;
        const std::size_t number = glyphs_.try_emplace({run.font, glyph.id}, glyphs_.size()).first->second;
        put("<use href=\"#g{}\"", number);
        if (glyph.x != 0) put(" x=\"{}\"", glyph.x);
        if (glyph.y != 0) put(" y=\"{}\"", -glyph.y);
        out_ += "/>";
      }
      out_ += "</g>";
    }
    if (selectable_) reading(text);
    out_ += "</g>\n";
  }

  // The words once more, unseen, as long as the outlines.
  void reading(const TextRun& text) {
    Fixed size = 0;
    for (const GlyphRun& run : text.runs) size = std::max(size, run.size);
    const Fixed length = text.turns % 2 == 0 ? text.box.right - text.box.left : text.box.bottom - text.box.top;
    if (size <= 0 || length <= 0) return;
    out_ += "<text fill-opacity=\"0\" font-family=\"sans-serif\" font-size=\"";
    number(hundredths(size), true);
    out_ += "\" textLength=\"";
    number(hundredths(length), true);
    put("\" lengthAdjust=\"spacingAndGlyphs\">{}</text>", escaped(text.source));
  }

  void item(const Group& g) { group(g); }

  void group(const Group& g) {
    put("<g id=\"{}\"", escaped(g.role));
    if (!g.name.empty()) put(" aria-label=\"{}\"", escaped(g.name));
    if (g.clip) {
      const int clip = clips_.emplace(*g.clip, static_cast<int>(clips_.size())).first->second;
      put(" clip-path=\"url(#clip{})\"", clip);
    }
    out_ += ">\n";
    for (const SceneNode& node : g.children) std::visit([&](const auto& i) { item(i); }, node.item);
    out_ += "</g>\n";
  }

  void definitions() {
    out_ += "<defs>\n";
    for (const auto& [r, index] : clips_) {
      put("<clipPath id=\"clip{}\"><path d=\"", index);
      path({{r.left, r.top}, {r.right, r.top}, {r.right, r.bottom}, {r.left, r.bottom}}, true);
      out_ += "\"/></clipPath>\n";
    }
    for (const auto& [key, number] : glyphs_) {
      put("<path id=\"g{}\" d=\"", number);
      glyph(outline(key.first, key.second));
      out_ += "\"/>\n";
    }
    out_ += "</defs>\n";
  }

  // A whole number, set off from the one before if need be.
  void whole(std::int64_t v, bool first = false) {
    if (!first && v >= 0) out_ += ' ';
    out_ += std::to_string(v);
  }

  // y down, relative to the point before; a command stands only where it changes.
  void glyph(const Outline& shape) {
    std::int32_t x = 0, y = 0;
    char last = ' ';
    const auto command = [&](char c) {
      const bool changes = c != last;
      if (changes) out_ += c;
      last = c;
      return changes;
    };
    const auto pair = [&](std::int32_t px, std::int32_t py, bool first) {
      whole(px - x, first);
      whole(-(py - y));
    };
    bool open = false;
    for (const OutlineStep& step : shape.steps) {
      switch (step.kind) {
        case OutlineStep::move:
          if (open) out_ += 'z';
          last = ' ';
          command('M');
          whole(step.x, true);
          whole(-step.y);
          open = true;
          break;
        case OutlineStep::line:
          if (step.y == y)
            whole(step.x - x, command('h'));
          else if (step.x == x)
            whole(-(step.y - y), command('v'));
          else
            pair(step.x, step.y, command('l'));
          break;
        case OutlineStep::quadratic:
          pair(step.x1, step.y1, command('q'));
          pair(step.x, step.y, false);
          break;
        case OutlineStep::cubic:
          pair(step.x1, step.y1, command('c'));
          pair(step.x2, step.y2, false);
          pair(step.x, step.y, false);
          break;
      }
      x = step.x;
      y = step.y;
    }
    if (open) out_ += 'z';
  }
};

std::vector<std::uint8_t> svg_bytes(const Scene& scene) {
  const std::string text = to_svg(scene);
  return {text.begin(), text.end()};
}

}  // namespace

std::string to_svg(const Scene& scene) { return Writer().write(scene); }

extern const Backend backend_svg;
const Backend backend_svg{"svg", svg_bytes};

}  // namespace plantloop
