// What the methods of figures and panels share: where they draw, and how a series looks.

#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "render/figure.h"
#include "scripts/host/stack.h"

namespace plantloop::lua {

// The panel that a method was called on; of a figure its first one, which is made when need be.
struct PanelPlace {
  std::shared_ptr<Figure> figure;
  std::size_t panel = 0;
  std::optional<std::size_t> inset;
  Panel& get() const;
};
PanelPlace panel_place(lua_State* L);

// The options that say how a series looks, `right` among them.
const std::vector<std::string>& look_keys();
// `kind` becomes stairs where the style is `steps`.
SeriesLook read_look(lua_State* L, const Options& options, Series::Kind& kind);
// Their declaration for editors.
const std::string& look_type();

}  // namespace plantloop::lua
