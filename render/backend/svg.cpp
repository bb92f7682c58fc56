// SVG: paths with coordinates in hundredths of a pixel, each glyph's outline once, groups named by their roles.

#include <fmt/format.h>

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

class Writer {
 public:
  std::string write(const Scene& scene) {
    put("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{}\" height=\"{}\" viewBox=\"0 0 {} {}\" role=\"img\">\n",
        scene.width, scene.height, scene.width, scene.height);
    if (!scene.title.empty()) put("<title>{}</title>\n", escaped(scene.title));
    std::string head = std::move(out_);
    out_.clear();
    put("<path fill=\"{}\" d=\"M0 0H{}V{}H0z\"/>\n", color(scene.background), scene.width, scene.height);
    group(scene.root);
    out_ += "</svg>\n";
    std::string body = std::move(out_);
    out_.clear();
    definitions();
    return head + out_ + body;
  }

 private:
  std::string out_;
  std::map<Rect, int, bool (*)(const Rect&, const Rect&)> clips_{[](const Rect& a, const Rect& b) {
    return std::tuple(a.left, a.top, a.right, a.bottom) < std::tuple(b.left, b.top, b.right, b.bottom);
  }};
  std::map<std::pair<int, std::uint32_t>, bool> glyphs_;

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

  void path(const Polyline& line, bool closed) {
    // Tenths do for the thousands of points of a measured signal.
    const std::int64_t grain = line.size() > 500 ? 10 : 1;
    std::int64_t x = 0, y = 0;
    for (std::size_t i = 0; i < line.size(); ++i) {
      const std::int64_t nx = (hundredths(line[i].x) + grain / 2) / grain * grain,
                         ny = (hundredths(line[i].y) + grain / 2) / grain * grain;
      if (i == 0) out_ += 'M';
      if (i == 1) out_ += 'l';
      number(nx - x, i < 2);
      number(ny - y, false);
      x = nx;
      y = ny;
    }
    if (closed) out_ += 'z';
  }

  void item(const Fill& fill) {
    put("<path fill=\"{}\"", color(fill.color));
    opacity("fill-opacity", fill.color);
    out_ += " d=\"";
    for (const Polyline& ring : fill.rings) path(ring, true);
    out_ += "\"/>\n";
  }

  void item(const Stroke& stroke) {
    put("<path fill=\"none\" stroke=\"{}\" stroke-width=\"", color(stroke.color));
    number(hundredths(stroke.width), true);
    out_ += "\" stroke-linejoin=\"round\"";
    opacity("stroke-opacity", stroke.color);
    if (stroke.cap == Stroke::Cap::round) out_ += " stroke-linecap=\"round\"";
    if (!stroke.dashes.empty()) {
      out_ += " stroke-dasharray=\"";
      for (std::size_t i = 0; i < stroke.dashes.size(); ++i) number(hundredths(stroke.dashes[i]), i == 0);
      out_ += '"';
    }
    out_ += " d=\"";
    for (const Polyline& line : stroke.lines) path(line, false);
    out_ += "\"/>\n";
  }

  void item(const TextRun& text) {
    put("<g role=\"img\" aria-label=\"{}\" fill=\"{}\" transform=\"translate({:.8g} {:.8g})", escaped(text.source),
        color(text.color), text.origin.x / 256.0, text.origin.y / 256.0);
    if (text.turns != 0) put("rotate({})", -90 * text.turns);
    out_ += "\">";
    for (const GlyphRun& run : text.runs) {
      const double scale = run.size / (256.0 * units_per_em(run.font));
      put("<g transform=\"translate({:.8g} {:.8g})scale({:.9g})\">", run.at.x / 256.0, run.at.y / 256.0, scale);
      for (const GlyphRun::Glyph& glyph : run.glyphs) {
        if (outline(run.font, glyph.id).steps.empty()) continue;
        glyphs_[{run.font, glyph.id}] = true;
        put("<use href=\"#{}{}\"", static_cast<char>('a' + run.font), glyph.id);
        if (glyph.x != 0) put(" x=\"{}\"", glyph.x);
        if (glyph.y != 0) put(" y=\"{}\"", -glyph.y);
        out_ += "/>";
      }
      out_ += "</g>";
    }
    out_ += "</g>\n";
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
    for (const auto& [key, used] : glyphs_) {
      put("<path id=\"{}{}\" d=\"", static_cast<char>('a' + key.first), key.second);
      glyph(outline(key.first, key.second));
      out_ += "\"/>\n";
    }
    out_ += "</defs>\n";
  }

  void whole(std::int32_t v) {
    if (v >= 0) out_ += ' ';
    out_ += std::to_string(v);
  }

  // y down, relative to the point before.
  void glyph(const Outline& shape) {
    std::int32_t x = 0, y = 0;
    const auto pair = [&](std::int32_t px, std::int32_t py) {
      whole(px - x);
      whole(-(py - y));
    };
    bool open = false;
    for (const OutlineStep& step : shape.steps) {
      switch (step.kind) {
        case OutlineStep::move:
          if (open) out_ += 'z';
          out_ += 'M';
          whole(step.x);
          whole(-step.y);
          open = true;
          break;
        case OutlineStep::line:
          out_ += 'l';
          pair(step.x, step.y);
          break;
        case OutlineStep::quadratic:
          out_ += 'q';
          pair(step.x1, step.y1);
          pair(step.x, step.y);
          break;
        case OutlineStep::cubic:
          out_ += 'c';
          pair(step.x1, step.y1);
          pair(step.x2, step.y2);
          pair(step.x, step.y);
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
