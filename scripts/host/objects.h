// Diagrams, runs and figures as scripts hold them.

#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "engine/run/diagram.h"
#include "render/figure.h"
#include "scripts/host/sandbox.h"

namespace plantloop::lua {

inline constexpr const char* diagram_kind = "diagram";
inline constexpr const char* run_kind = "run";
inline constexpr const char* figure_kind = "figure";
inline constexpr const char* panel_kind = "panel";

struct DiagramObject {
  std::shared_ptr<Diagram> diagram;
  Overrides set;  // of diagram:with
};

// Immutable; its memory counts as the script's.
struct RunObject {
  RunObject(DiagramRun given, std::shared_ptr<Diagram> of) : run(std::move(given)), diagram(std::move(of)) {}
  DiagramRun run;
  std::shared_ptr<Diagram> diagram;
  std::size_t bytes = 0;
  const Recording& recording() const { return run.recording; }
};
using RunPointer = std::unique_ptr<RunObject>;

// Pushes a run; its memory is checked against the limit.
void push_run(lua_State* L, DiagramRun run, std::shared_ptr<Diagram> diagram);
// The column with this name, or an error that names the nearest ones.
std::size_t column_of(const RunObject& run, const std::string& name);

struct FigureObject {
  std::shared_ptr<Figure> figure;
  Panel first;  // as pl.figure was told; becomes the first panel when a series is added
};
struct PanelObject {
  std::shared_ptr<Figure> figure;
  std::size_t index = 0;
  std::optional<std::size_t> inset;  // of that panel
};

}  // namespace plantloop::lua
