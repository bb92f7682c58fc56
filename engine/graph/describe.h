// What the block types' declarations say, as text for people and as a JSON schema for editors.

#pragma once

#include <string>

#include "engine/block.h"
#include "engine/diagram/figure_words.h"

namespace plantloop {

// Everything about one block type: what goes in, what it can be told, what it remembers, what comes out, what it does.
std::string block_text(const BlockType& type);
std::string block_markdown(const BlockType& type);

// All block types by group, one line each.
std::string catalogue_text();
std::string catalogue_markdown();

// The JSON schema of diagram files (draft 2020-12), made from the declarations of blocks and, where they are
// given, of plot types.
std::string diagram_schema(const PlotWords& plots = no_plots());

}  // namespace plantloop
