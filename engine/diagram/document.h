// A YAML text as a tree in which every key and every value knows where it was written.

#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/mark.h"
#include "engine/base/report.h"
#include "engine/diagram/expression.h"

namespace plantloop {

// One value. Scalars are kept as text: what they mean is decided by who reads them.
struct Node {
  enum class Kind { null, scalar, sequence, mapping };
  Kind kind = Kind::null;
  std::string text;               // of a scalar
  bool quoted = false;            // written with quotes or as a block scalar
  std::vector<Node> items;        // of a sequence; of a mapping the values, in the order of `keys`
  std::vector<std::string> keys;  // of a mapping
  std::vector<Mark> key_marks;
  Mark mark;
  std::uint32_t offset = 0;  // the byte of the source at which it starts; of a quoted scalar the quote
  bool flow = false;         // of a sequence or mapping: written with brackets

  bool is_scalar() const { return kind == Kind::scalar; }
  bool is_sequence() const { return kind == Kind::sequence; }
  bool is_mapping() const { return kind == Kind::mapping; }
  // The value of a key of a mapping, or null.
  const Node* find(std::string_view key) const;
};

// Reads one YAML document; an empty one is a finding. Refuses invalid UTF-8, NUL, duplicate keys, anchors that expand
// without bound, nesting deeper than 100, and a second document. Returns a null node after reporting when nothing could
// be read.
Node read_document(const std::shared_ptr<const Source>& source, Report& report);

// Where the characters of a scalar's text lie in its source, found by scanning the source again.
TextPlace text_place(const Node& scalar);

// The tree of a scalar's text, of a sequence (joined: `[a, b]`) at any depth, or null after reporting.
ExpressionPtr parse_expression(const Node& node, Report& report);

}  // namespace plantloop
