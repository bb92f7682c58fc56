// What the engine made of a diagram and why, as text for people.

#pragma once

#include <memory>
#include <optional>
#include <string>

#include "engine/graph/graph.h"

namespace plantloop {

// Order, rates, sizes, events, restarts and what cannot be changed without compiling again. With a name ("plant",
// "plant.u", "controller.ki") everything about that one: what drives it and reads it, its rate with the chain of
// reasons, and which inputs reach it at the same instant. Nothing when the diagram is wrong or has no such name (see
// the report).
std::optional<std::string> explain(std::shared_ptr<const Model> model, const Overrides& set, const std::string& name,
                                   Report& report);

}  // namespace plantloop
