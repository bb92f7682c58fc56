// Looks for faults in scenes.

#include "render/scene/lint.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <map>
#include <set>

namespace plantloop {
namespace {

struct Lint {
  const Scene& scene;
  std::vector<std::string> faults;
  std::vector<const TextRun*> texts;
  std::vector<std::string> homes;  // role of the group of each text
  std::set<std::string> shown_series, explained_series;

  template <typename... Args>
  void fault(fmt::format_string<Args...> format, Args&&... args) {
    faults.push_back(fmt::format(format, std::forward<Args>(args)...));
  }

  void group(const Group& g) {
    if (g.role.find("/series/") != std::string::npos && !g.name.empty() && !g.children.empty())
      shown_series.insert(g.role);
    const std::size_t entry = g.role.find("/legend/"), end = g.role.find("/ends/");
    const std::size_t found = std::min(entry, end);
    if (found != std::string::npos)
      explained_series.insert(g.role.substr(0, found) + "/series/" + g.role.substr(g.role.find('/', found + 1) + 1));
    if (g.role.ends_with("/ticks")) ticks(g);
    for (const SceneNode& node : g.children) std::visit([&](const auto& item) { check(item, g.role); }, node.item);
  }

  void check(const Group& g, const std::string&) { group(g); }

  void points(const std::vector<Polyline>& lines, std::size_t least, const std::string& role) {
    if (lines.empty()) fault("{}: a path without points", role);
    const std::int64_t reach_x = 256 * (scene.width + 64), reach_y = 256 * (scene.height + 64);
    for (const Polyline& line : lines) {
      if (line.size() < least) fault("{}: a path of {} points", role, line.size());
      for (const Point p : line)
        if (p.x < -64 * 256 || p.y < -64 * 256 || p.x > reach_x || p.y > reach_y) {
          fault("{}: a point far outside the picture: {}, {}", role, p.x / 256, p.y / 256);
          break;
        }
    }
  }

  void check(const Fill& fill, const std::string& role) { points(fill.rings, 3, role); }

  void check(const Stroke& stroke, const std::string& role) {
    points(stroke.lines, 2, role);
    if (stroke.width <= 0) fault("{}: a stroke without width", role);
    if (role.find("/series/") == std::string::npos) return;
    const bool cue = stroke.width >= 2.4 * 256 * scene.dpi / 152.4 || !stroke.dashes.empty();
    const double ratio = contrast(over(stroke.color, scene.background), scene.background);
    if (!cue && ratio < 3) fault("{}: contrast of a thin line {:.2f}, at least 3 is readable", role, ratio);
  }

  void check(const TextRun& text, const std::string& role) {
    texts.push_back(&text);
    homes.push_back(role);
    if (text.runs.empty()) fault("{}: a text without letters", role);
    const Rect& b = text.box;
    if (b.left < 0 || b.top < 0 || b.right > scene.width * 256 || b.bottom > scene.height * 256)
      fault("{}: '{}' is partly outside the picture", role, text.source);
    const double ratio = contrast(text.color, text.background);
    if (ratio < 4.5) fault("{}: contrast of '{}' {:.2f}, at least 4.5 is readable", role, text.source, ratio);
  }

  // "−0.5" -> -0.5; false for powers of ten.
  static bool parse(std::string text, double& value) {
    for (std::size_t at; (at = text.find("−")) != std::string::npos;)
      text.replace(at, std::string_view("−").size(), 1, '-');
    char* rest = nullptr;
    value = std::strtod(text.c_str(), &rest);
    return rest && *rest == '\0' && !text.empty();
  }

  // Numbers rise evenly, and their places are in one proportion to them (to their logarithms on a logarithmic axis).
  void ticks(const Group& g) {
    if (g.name == "names") return;  // not numbers
    const bool across = g.role.ends_with("/x/ticks");
    std::vector<double> places, values;
    for (const SceneNode& node : g.children) {
      const auto* text = std::get_if<TextRun>(&node.item);
      if (!text) continue;
      const Rect& b = text->box;
      double value = 0;
      if (parse(text->source, value)) values.push_back(value);
      const double advance_middle = across ? (b.left + b.right) / 2.0 : -text->origin.y;
      places.push_back(advance_middle);
    }
    if (places.size() < 2) fault("{}: {} numbers are too few", g.role, places.size());
    if (places.size() > 11) fault("{}: {} numbers are too many", g.role, places.size());
    for (std::size_t i = 0; i + 1 < places.size(); ++i)
      if (places[i + 1] <= places[i]) fault("{}: the numbers are not in order", g.role);
    if (values.size() != places.size() || values.size() < 3) return;
    if (!std::is_sorted(values.begin(), values.end(), std::less_equal<>()))
      return fault("{}: the numbers do not rise", g.role);
    if (g.name == "symlog") return;  // straight in its middle only
    if (g.name == "log")
      for (double& v : values) v = std::log10(v);
    const double first = values.front(), last = values.back();
    if (g.name != "log") {
      const double step = (last - first) / static_cast<double>(values.size() - 1);
      for (std::size_t i = 0; i + 1 < values.size(); ++i)
        if (std::abs(values[i + 1] - values[i] - step) > 1e-6 * (last - first))
          return fault("{}: the numbers are not evenly spaced", g.role);
    }
    for (std::size_t i = 0; i < values.size(); ++i) {
      const double expected = places.front() + (values[i] - first) / (last - first) * (places.back() - places.front());
      // Middles of ink differ from middles of advances by up to a fifth of a letter.
      if (std::abs(expected - places[i]) > (across ? 4.5 : 1.1) * 256 * scene.dpi / 152.4)
        fault("{}: '{}' stands in the wrong place", g.role, values[i]);
    }
  }

  void overlaps() {
    for (std::size_t i = 0; i < texts.size(); ++i)
      for (std::size_t k = i + 1; k < texts.size(); ++k) {
        const Rect &a = texts[i]->box, &b = texts[k]->box;
        if (a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom)
          fault("'{}' ({}) overlaps '{}' ({})", texts[i]->source, homes[i], texts[k]->source, homes[k]);
      }
  }

  // Either all series with a label are explained or none is (the axes do it), or the key says how many are left out.
  void key() {
    std::map<std::string, int> missing;
    for (const std::string& role : shown_series)
      if (!explained_series.contains(role)) ++missing[role.substr(0, role.find("/series/"))];
    for (const auto& [panel, count] : missing) {
      const bool any = std::any_of(explained_series.begin(), explained_series.end(),
                                   [&, p = panel](const std::string& r) { return r.starts_with(p + "/"); });
      if (any && !explained_series.contains(panel + "/series/more"))
        fault("{}: {} series are missing in the key", panel, count);
    }
  }
};

}  // namespace

std::vector<std::string> lint(const Scene& scene) {
  Lint lint{scene, {}, {}, {}, {}, {}};
  lint.group(scene.root);
  lint.overlaps();
  lint.key();
  return std::move(lint.faults);
}

}  // namespace plantloop
