// Tables of named options as blocks of figures' words, the same that diagrams use.

#pragma once

#include <string>

#include "engine/diagram/model.h"
#include "scripts/host/stack.h"

namespace plantloop::lua {

// What the table says in these words; others that it may hold are left to the caller. Throws ScriptError for values of
// another kind.
FigureBlock block_of(lua_State* L, const Options& options, const FigureWords& words);
// The table at the index, which may have no other keys.
FigureBlock block_at(lua_State* L, int index, const std::string& what, const FigureWords& words);

// "{label?: string, limits?: number[], ...}", for editors.
std::string table_type(const FigureWords& words);

// Of pl.figure and figure:panel: axes are `x`, `y` and `right` here.
const FigureWords& script_figure_words();
const FigureWords& script_panel_words();
const FigureWords& script_inset_words();

}  // namespace plantloop::lua
