// The plain part of YAML, read directly: what nearly every diagram is written in, ten times faster than in general.

#pragma once

#include <optional>

#include "engine/diagram/document.h"

namespace plantloop {

// The tree of a text that keeps to block mappings, lists, flow collections and scalars on one line each; the same tree
// that the general reader gives, keys not yet checked. Nothing for any other text, right or wrong: the general reader
// decides then.
std::optional<Node> read_plain(const Source& source);

}  // namespace plantloop
