// A diagram as a linear model at the point that a script's table tells.

#pragma once

#include "engine/analysis/linearise.h"
#include "scripts/host/objects.h"
#include "scripts/host/session.h"

namespace plantloop::lua {

// Of the diagram that the point's `diagram` names, else of `self`, at its initial values, after `time` seconds or, with
// `trim`, at the rest near there. Behind the outputs that were asked for stand the inputs' own values, as outputs.
LinearModel local_model(lua_State* L, const DiagramObject& self, LineariseRequest request, const Options& point);

}  // namespace plantloop::lua
