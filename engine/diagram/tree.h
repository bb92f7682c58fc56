// What both readers of YAML share: how a mapping and a sequence are finished, and where a scalar ends.

#pragma once

#include "engine/diagram/document.h"
#include "engine/diagram/places.h"

namespace plantloop {

constexpr int deepest_document = 100;
constexpr std::size_t most_repeated = 200'000;  // nodes that references repeat

// The document by yaml-cpp, whose text was checked to be UTF-8 without NUL.
Node read_general(const std::shared_ptr<const Source>& source, Report& report);

// Repairs and reports values that a comma cut: `{in: where(a > 0, b, c)}`.
void repair_commas(Node& node, Report& report);
// Repairs and reports keys whose colon has no space behind it: `{type:gain, in: x}`.
void repair_colons(Node& node, Report& report);
// Reports keys that are written twice and merge keys.
void check_keys(const Node& mapping, Report& report);

// The bytes of the source that a scalar covers from `offset` on, as far as its first line. Reports a quote that is
// never closed; returns 0 then.
std::size_t scalar_size(std::string_view source, std::size_t offset, std::string_view text, bool quoted);

// What the syntax error that yaml-cpp met at a byte of the source is about, in plain words.
struct Words {
  std::size_t at = 0, size = 1;
  std::string message;
  std::string hint;
};
Words plain_words(std::string_view source, std::size_t at, std::string_view message);

}  // namespace plantloop
