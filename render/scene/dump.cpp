// Writes scenes as canonical JSON.

#include "render/scene/dump.h"

#include <fmt/format.h>

#include <iterator>

namespace plantloop {
namespace {

struct Writer {
  std::string out;
  std::size_t longest;

  template <typename... Args>
  void put(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(out), format, std::forward<Args>(args)...);
  }

  void quoted(std::string_view text) {
    out += '"';
    for (const char c : text) {
      if (c == '"' || c == '\\') {
        out += '\\';
        out += c;
      } else if (static_cast<unsigned char>(c) < 0x20) {
        put("\\u{:04x}", static_cast<int>(c));
      } else {
        out += c;
      }
    }
    out += '"';
  }

  void lines(const char* name, const std::vector<Polyline>& polylines) {
    put(",\"{}\":[", name);
    for (std::size_t i = 0; i < polylines.size(); ++i) {
      if (i > 0) out += ',';
      line(polylines[i]);
    }
    out += ']';
  }

  void line(const Polyline& points) {
    if (longest > 0 && points.size() > longest) {
      const Point first = points.front();
      const Point last = points.back();
      put("{{\"count\":{},\"hash\":\"{:016x}\",\"ends\":[{},{},{},{}]}}", points.size(),
          fnv1a(points.data(), points.size() * sizeof(Point)), first.x, first.y, last.x, last.y);
      return;
    }
    out += '[';
    for (std::size_t i = 0; i < points.size(); ++i) put("{}{},{}", i > 0 ? "," : "", points[i].x, points[i].y);
    out += ']';
  }

  void indent(int depth) { out.append(static_cast<std::size_t>(depth), ' '); }

  void write(const Fill& fill, int) {
    put("{{\"fill\":\"{}\"", to_hex(fill.color));
    lines("rings", fill.rings);
    out += '}';
  }

  void write(const Stroke& stroke, int) {
    put("{{\"stroke\":\"{}\",\"width\":{},\"cap\":\"{}\",\"dashes\":[{}]", to_hex(stroke.color), stroke.width,
        stroke.cap == Stroke::Cap::round ? "round" : "butt", fmt::join(stroke.dashes, ","));
    lines("lines", stroke.lines);
    out += '}';
  }

  void write(const TextRun& text, int) {
    out += "{\"text\":";
    quoted(text.source);
    put(",\"color\":\"{}\",\"at\":[{},{}],\"turns\":{},\"box\":[{},{},{},{}],\"runs\":[", to_hex(text.color),
        text.origin.x, text.origin.y, text.turns, text.box.left, text.box.top, text.box.right, text.box.bottom);
    for (std::size_t i = 0; i < text.runs.size(); ++i) {
      const GlyphRun& run = text.runs[i];
      put("{}{{\"font\":{},\"size\":{},\"at\":[{},{}],\"glyphs\":[", i > 0 ? "," : "", run.font, run.size, run.at.x,
          run.at.y);
      for (std::size_t k = 0; k < run.glyphs.size(); ++k)
        put("{}{},{},{}", k > 0 ? "," : "", run.glyphs[k].id, run.glyphs[k].x, run.glyphs[k].y);
      out += "]}";
    }
    out += "]}";
  }

  void write(const Group& group, int depth) {
    out += "{\"role\":";
    quoted(group.role);
    if (!group.name.empty()) {
      out += ",\"name\":";
      quoted(group.name);
    }
    if (group.clip)
      put(",\"clip\":[{},{},{},{}]", group.clip->left, group.clip->top, group.clip->right, group.clip->bottom);
    out += ",\"children\":[";
    for (std::size_t i = 0; i < group.children.size(); ++i) {
      out += i > 0 ? ",\n" : "\n";
      indent(depth + 1);
      std::visit([&](const auto& item) { write(item, depth + 1); }, group.children[i].item);
    }
    out += "]}";
  }
};

}  // namespace

std::uint64_t fnv1a(const void* data, std::size_t size, std::uint64_t start) {
  const auto* bytes = static_cast<const unsigned char*>(data);
  std::uint64_t result = start;
  for (std::size_t i = 0; i < size; ++i) result = (result ^ bytes[i]) * 1099511628211ull;
  return result;
}

std::string to_json(const Scene& scene, std::size_t longest) {
  Writer writer{{}, longest};
  writer.out = "{\"title\":";
  writer.quoted(scene.title);
  writer.put(",\"width\":{},\"height\":{},\"dpi\":{:.6g},\"background\":\"{}\",\n\"fonts\":[", scene.width,
             scene.height, scene.dpi, to_hex(scene.background));
  for (std::size_t i = 0; i < scene.fonts.size(); ++i)
    writer.put("{}{{\"name\":\"{}\",\"sha256\":\"{}\"}}", i > 0 ? "," : "", scene.fonts[i].name, scene.fonts[i].sha256);
  writer.out += "],\n\"root\":";
  writer.write(scene.root, 0);
  writer.out += "}\n";
  return std::move(writer.out);
}

std::uint64_t hash(const Scene& scene) {
  const std::string text = to_json(scene);
  return fnv1a(text.data(), text.size());
}

}  // namespace plantloop
