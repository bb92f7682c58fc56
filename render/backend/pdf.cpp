// PDF: coordinates as whole numbers under a scaling matrix, subsets of the fonts embedded, every text searchable.
//
// Fonts are Type 0 with the glyphs' numbers as codes, never Type 3; ToUnicode says which character a glyph is, and
// ActualText what a label reads as. No date, no random name: the same scenes give the same bytes. After ISO 32000-1.

#include <fmt/format.h>
#include <zlib.h>

#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <set>
#include <span>
#include <utility>

#include "render/backend/backend.h"
#include "render/error.h"
#include "render/image.h"
#include "render/scene/dump.h"
#include "render/text/font.h"
#include "render/text/subset.h"
#include "render/text/utf8.h"

namespace plantloop {
namespace {

// 1/32 pixel: finer than any printer, and a digit shorter than the scene's own numbers.
constexpr int units = 32;
long in_units(Fixed v) { return std::lround(v * (units / 256.0)); }

std::string utf16_hex(std::string_view text, bool with_mark) {
  std::string hex = with_mark ? "FEFF" : "";
  for (const char32_t c : from_utf8(text)) {
    if (c < 0x10000) {
      hex += fmt::format("{:04X}", static_cast<unsigned>(c));
    } else {
      const auto rest = static_cast<unsigned>(c) - 0x10000;
      hex += fmt::format("{:04X}{:04X}", 0xD800 + (rest >> 10), 0xDC00 + (rest & 0x3FF));
    }
  }
  return hex;
}

std::string deflated(const std::string& data) {
  uLongf size = compressBound(static_cast<uLong>(data.size()));
  std::string result(size, '\0');
  if (compress2(reinterpret_cast<Bytef*>(result.data()), &size, reinterpret_cast<const Bytef*>(data.data()),
                static_cast<uLong>(data.size()), 4) != Z_OK)
    throw RenderError("there is no memory to compress the PDF");
  result.resize(size);
  return result;
}

// Numbered objects, in the order in which they are added.
class Objects {
 public:
  int reserve() {
    objects_.emplace_back();
    return static_cast<int>(objects_.size());
  }
  void set(int number, std::string body) { objects_[static_cast<std::size_t>(number) - 1] = std::move(body); }
  int add(std::string body) {
    const int number = reserve();
    set(number, std::move(body));
    return number;
  }
  void set_stream(int number, const std::string& data, const std::string& entries = {}) {
    const std::string packed = deflated(data);
    set(number,
        fmt::format("<</Length {}/Filter/FlateDecode{}>>\nstream\n{}\nendstream", packed.size(), entries, packed));
  }
  int add_stream(const std::string& data, const std::string& entries = {}) {
    const int number = reserve();
    set_stream(number, data, entries);
    return number;
  }

  std::string file(int catalogue, int info) const {
    std::string out = "%PDF-1.5\n%\xC7\xEC\x8F\xA2\n";
    std::vector<std::size_t> places;
    for (std::size_t i = 0; i < objects_.size(); ++i) {
      places.push_back(out.size());
      out += fmt::format("{} 0 obj\n{}\nendobj\n", i + 1, objects_[i]);
    }
    const std::size_t table = out.size();
    out += fmt::format("xref\n0 {}\n0000000000 65535 f \n", objects_.size() + 1);
    for (const std::size_t place : places) out += fmt::format("{:010} 00000 n \n", place);
    const std::string id = fmt::format("{:016x}", fnv1a(out.data(), table));
    out += fmt::format("trailer\n<</Size {}/Root {} 0 R/Info {} 0 R/ID[<{}><{}>]>>\nstartxref\n{}\n%%EOF\n",
                       objects_.size() + 1, catalogue, info, id, id, table);
    return out;
  }

 private:
  std::vector<std::string> objects_;
};

// Everything that the pages share: the glyphs and degrees of opacity that they use.
struct Resources {
  std::array<std::set<std::uint32_t>, font_count> glyphs;
  std::array<std::map<std::uint32_t, std::u32string>, font_count> characters;  // what each glyph reads as
  std::array<SubsetFont, font_count> fonts;
  std::set<int> opacities;
};

// First pass: which glyphs there are, and what they read as.
class Collector {
 public:
  explicit Collector(Resources& resources) : r_(resources) {}

  void group(const Group& g) {
    for (const SceneNode& node : g.children) {
      if (const auto* inner = std::get_if<Group>(&node.item)) group(*inner);
      if (const auto* text = std::get_if<TextRun>(&node.item)) collect(*text);
    }
  }

 private:
  void collect(const TextRun& text) {
    for (const GlyphRun& run : text.runs)
      for (const GlyphRun::Glyph& glyph : run.glyphs) r_.glyphs[static_cast<std::size_t>(run.font)].insert(glyph.id);
    // Characters one by one, with figures of either width; what only stands in a ligature is left to ActualText.
    for (const char32_t c : from_utf8(text.source))
      for (int font = 0; font < font_count; ++font) {
        if (!has_glyph(font, c)) continue;
        for (const bool tabular : {false, true}) {
          const Shaped shaped = shape(font, std::u32string_view(&c, 1), tabular);
          if (shaped.glyphs.size() == 1)
            r_.characters[static_cast<std::size_t>(font)].try_emplace(shaped.glyphs[0].id, std::u32string(1, c));
        }
      }
  }

  Resources& r_;
};

// Second pass: a page's content.
class PageWriter {
 public:
  explicit PageWriter(Resources& resources) : r_(resources) {}

  std::string write(const Scene& scene) {
    const double scale = 72 / scene.dpi / units;
    put("{:.8g} 0 0 {:.8g} 0 {:.6g} cm 1 j\n", scale, -scale, scene.height * 72 / scene.dpi);
    fill_color(scene.background);
    put("0 0 {} {} re f\n", scene.width * units, scene.height * units);
    group(scene.root);
    return std::move(out_);
  }

 private:
  template <typename... Args>
  void put(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(out_), format, std::forward<Args>(args)...);
  }

  static std::string rgb_of(Color c) {
    return fmt::format("{:.4g} {:.4g} {:.4g}", c.r / 255.0, c.g / 255.0, c.b / 255.0);
  }

  void opacity(std::uint8_t a) {
    if (a == opacity_) return;
    opacity_ = a;
    r_.opacities.insert(a);
    put("/A{} gs\n", a);
  }
  void fill_color(Color c) {
    opacity(c.a);
    if (std::string text = rgb_of(c); text != fill_) {
      fill_ = std::move(text);
      put("{} rg\n", fill_);
    }
  }
  void stroke_color(Color c) {
    opacity(c.a);
    if (std::string text = rgb_of(c); text != stroke_) {
      stroke_ = std::move(text);
      put("{} RG\n", stroke_);
    }
  }

  void number(long v) { fmt::format_to(std::back_inserter(out_), FMT_STRING("{} "), v); }

  void path(const Polyline& line, bool closed) {
    for (std::size_t i = 0; i < line.size(); ++i) {
      number(in_units(line[i].x));
      number(in_units(line[i].y));
      out_ += i == 0 ? "m " : "l ";
    }
    if (closed) out_ += "h ";
  }

  void item(const Fill& fill) {
    if (fill.rings.empty()) return;
    fill_color(fill.color);
    for (const Polyline& ring : fill.rings) path(ring, true);
    out_ += "f\n";
  }

  void item(const Stroke& stroke) {
    if (stroke.lines.empty()) return;
    stroke_color(stroke.color);
    std::string dashes = "[";
    for (const Fixed d : stroke.dashes) dashes += fmt::format("{} ", in_units(d));
    const std::string style =
        fmt::format("{} w {} J {}] 0 d\n", in_units(stroke.width), stroke.cap == Stroke::Cap::round ? 1 : 0, dashes);
    if (style != style_) out_ += style_ = style;
    for (const Polyline& line : stroke.lines) path(line, false);
    out_ += "S\n";
  }

  void item(const TextRun& text) {
    fill_color(text.color);
    put("/Span<</ActualText<{}>>>BDC BT\n", utf16_hex(text.source, true));
    // Directions of the text's right and up by quarter turns anticlockwise; y points down here.
    constexpr int right[4][2] = {{1, 0}, {0, -1}, {-1, 0}, {0, 1}}, up[4][2] = {{0, -1}, {-1, 0}, {0, 1}, {1, 0}};
    const int* x = right[text.turns & 3];
    const int* y = up[text.turns & 3];
    for (const GlyphRun& run : text.runs) {
      const SubsetFont& font = r_.fonts[static_cast<std::size_t>(run.font)];
      const double size = run.size * (units / 256.0), upem = units_per_em(run.font);
      put("/F{} {:.6g} Tf\n", run.font, size);
      // Glyphs of one height in one piece.
      for (std::size_t begin = 0; begin < run.glyphs.size();) {
        std::size_t end = begin + 1;
        while (end < run.glyphs.size() && run.glyphs[end].y == run.glyphs[begin].y) ++end;
        const double along = run.at.x * (units / 256.0) + run.glyphs[begin].x / upem * size,
                     aside = -run.at.y * (units / 256.0) + run.glyphs[begin].y / upem * size;
        put("{} {} {} {} {:.7g} {:.7g} Tm[<", x[0], x[1], y[0], y[1],
            text.origin.x * (units / 256.0) + along * x[0] + aside * y[0],
            text.origin.y * (units / 256.0) + along * x[1] + aside * y[1]);
        double pen = run.glyphs[begin].x * 1000 / upem;
        for (std::size_t i = begin; i < end; ++i) {
          const std::uint32_t id = font.glyphs.at(run.glyphs[i].id);
          const double want = run.glyphs[i].x * 1000 / upem;
          if (std::abs(want - pen) > 0.5) put(">{:.5g}<", pen - want);
          put("{:04X}", id);
          pen = (std::abs(want - pen) > 0.5 ? want : pen) + std::round(font.advances[id]);
        }
        out_ += ">]TJ\n";
        begin = end;
      }
    }
    out_ += "ET EMC\n";
  }

  void item(const Group& g) { group(g); }

  void group(const Group& g) {
    if (g.clip) {
      const auto before = std::tuple(fill_, stroke_, style_, opacity_);
      put("q {} {} {} {} re W n\n", in_units(g.clip->left), in_units(g.clip->top),
          in_units(g.clip->right) - in_units(g.clip->left), in_units(g.clip->bottom) - in_units(g.clip->top));
      children(g);
      out_ += "Q\n";
      std::tie(fill_, stroke_, style_, opacity_) = before;
    } else {
      children(g);
    }
  }
  void children(const Group& g) {
    for (const SceneNode& node : g.children) std::visit([&](const auto& i) { item(i); }, node.item);
  }

  Resources& r_;
  std::string out_, fill_, stroke_, style_;
  int opacity_ = 255;
};

// Glyph -> character, for searching and copying; at most 100 lines to a block (ISO 32000-1, 9.10.3).
std::string to_unicode(const SubsetFont& font, const std::map<std::uint32_t, std::u32string>& characters) {
  std::vector<std::string> lines;
  for (const auto& [old, glyph] : font.glyphs) {
    const auto it = characters.find(old);
    if (it != characters.end())
      lines.push_back(fmt::format("<{:04X}><{}>\n", glyph, utf16_hex(to_utf8(it->second), false)));
  }
  std::string map =
      "/CIDInit/ProcSet findresource begin\n12 dict begin\nbegincmap\n/CIDSystemInfo<</Registry(Adobe)/Ordering(UCS)"
      "/Supplement 0>>def\n/CMapName/Adobe-Identity-UCS def\n/CMapType 2 def\n1 begincodespacerange\n<0000><FFFF>\n"
      "endcodespacerange\n";
  for (std::size_t begin = 0; begin < lines.size(); begin += 100) {
    const std::size_t end = std::min(lines.size(), begin + 100);
    map += fmt::format("{} beginbfchar\n", end - begin);
    for (std::size_t i = begin; i < end; ++i) map += lines[i];
    map += "endbfchar\n";
  }
  return map + "endcmap\nCMapName currentdict/CMap defineresource pop\nend\nend\n";
}

// "ABCDEF+Inter": the letters stand for the choice of glyphs.
std::string subset_name(std::string_view name, const SubsetFont& font) {
  std::uint64_t h = fnv1a(font.program.data(), font.program.size());
  std::string result;
  for (int i = 0; i < 6; ++i, h /= 26) result += static_cast<char>('A' + h % 26);
  result += '+';
  for (const char c : name) result += c == ' ' ? '-' : c;
  return result;
}

int add_font(Objects& objects, std::string_view name, const SubsetFont& font,
             const std::map<std::uint32_t, std::u32string>& characters) {
  const std::string called = subset_name(name, font);
  const int program = objects.add_stream(
      font.program, font.is_cff ? "/Subtype/CIDFontType0C" : fmt::format("/Length1 {}", font.program.size()));
  const int descriptor = objects.add(fmt::format(
      "<</Type/FontDescriptor/FontName/{}/Flags 4/FontBBox[{:.0f} {:.0f} {:.0f} {:.0f}]/ItalicAngle 0/Ascent {:.0f}"
      "/Descent {:.0f}/CapHeight {:.0f}/StemV 80/{} {} 0 R>>",
      called, font.box[0], font.box[1], font.box[2], font.box[3], font.ascent, font.descent, font.cap_height,
      font.is_cff ? "FontFile3" : "FontFile2", program));
  std::string widths;
  for (const double advance : font.advances) widths += fmt::format("{:.0f} ", std::round(advance));
  const int descendant = objects.add(
      fmt::format("<</Type/Font/Subtype/{}/BaseFont/{}/CIDSystemInfo<</Registry(Adobe)/Ordering(Identity)/Supplement "
                  "0>>/FontDescriptor {} 0 R{}/W[0[{}]]>>",
                  font.is_cff ? "CIDFontType0" : "CIDFontType2", called, descriptor,
                  font.is_cff ? "" : "/CIDToGIDMap/Identity", widths));
  const int unicode = objects.add_stream(to_unicode(font, characters));
  return objects.add(fmt::format(
      "<</Type/Font/Subtype/Type0/BaseFont/{}/Encoding/Identity-H/DescendantFonts[{} 0 R]/ToUnicode {} 0 R>>", called,
      descendant, unicode));
}

std::vector<std::uint8_t> pdf_bytes(const Scene& scene) {
  const std::string text = to_pdf({&scene, 1});
  return {text.begin(), text.end()};
}

}  // namespace

std::string to_pdf(std::span<const Scene> pages) {
  Resources resources;
  Collector collector(resources);
  for (const Scene& scene : pages) collector.group(scene.root);
  for (int font = 0; font < font_count; ++font) {
    const auto f = static_cast<std::size_t>(font);
    if (!resources.glyphs[f].empty()) resources.fonts[f] = subset(font, resources.glyphs[f]);
  }
  Objects objects;
  const int catalogue = objects.reserve(), tree = objects.reserve(), shared = objects.reserve();
  std::string kids;
  for (const Scene& scene : pages) {
    const int content = objects.add_stream(PageWriter(resources).write(scene));
    const int page = objects.add(
        fmt::format("<</Type/Page/Parent {} 0 R/MediaBox[0 0 {:.6g} {:.6g}]/Resources {} 0 R/Contents {} 0 R>>", tree,
                    scene.width * 72 / scene.dpi, scene.height * 72 / scene.dpi, shared, content));
    kids += fmt::format("{} 0 R ", page);
  }
  std::string fonts, states;
  const std::vector<SceneFont> names = scene_fonts();
  for (std::size_t f = 0; f < font_count; ++f)
    if (!resources.glyphs[f].empty())
      fonts +=
          fmt::format("/F{} {} 0 R", f, add_font(objects, names[f].name, resources.fonts[f], resources.characters[f]));
  for (const int a : resources.opacities)
    states += fmt::format("/A{}<</CA {:.4g}/ca {:.4g}>>", a, a / 255.0, a / 255.0);
  objects.set(shared, fmt::format("<</Font<<{}>>/ExtGState<<{}>>>>", fonts, states));
  objects.set(tree, fmt::format("<</Type/Pages/Kids[{}]/Count {}>>", kids, pages.size()));
  objects.set(catalogue, fmt::format("<</Type/Catalog/Pages {} 0 R>>", tree));
  const std::string title = pages.empty() ? "" : pages[0].title;
  const int info = objects.add(fmt::format("<</Producer(Plantloop)/Title<{}>>>", utf16_hex(title, true)));
  return objects.file(catalogue, info);
}

extern const Backend backend_pdf;
const Backend backend_pdf{"pdf", pdf_bytes};

}  // namespace plantloop
