// A file of hints: what a drawing shall do otherwise than by itself.
//
//   forward: [observer]           # these lie on forward paths
//   feedback: [filter, plant.k]   # these lead back: below, pointing to the left
//   hide: [exact, error]          # these are not drawn

#pragma once

#include <optional>
#include <set>
#include <string>
#include <vector>

#include "engine/graph/graph.h"
#include "render/diagram/sheet.h"

namespace plantloop {

struct DrawingHints {
  std::vector<SheetHint> directions;
  std::set<std::string> hidden;  // full paths
};

// Nothing after reporting what is wrong, names that the diagram does not have among it.
std::optional<DrawingHints> read_hints(const std::string& path, const Graph& graph, Report& report);

}  // namespace plantloop
