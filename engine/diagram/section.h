// Reading a mapping whose keys are known: unknown and misplaced keys, and the types of the values.

#pragma once

#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/diagram/document.h"

namespace plantloop {

// A mapping of the file. `what` names it in findings: "simulation", "parameter 'b'".
class Section {
 public:
  // Reports a node that is no mapping, and each key that is none of `keys`.
  Section(const Node& node, std::string what, std::initializer_list<std::string_view> keys, Report& report);
  Section(const Node& node, std::string what, const std::vector<std::string>& keys, Report& report);

  explicit operator bool() const { return valid_; }
  const Node* find(std::string_view key) const { return valid_ ? node_.find(key) : nullptr; }
  const Mark& mark_of(std::string_view key) const;

  // The value of a key as ...; where it is absent or reported, null, the fallback or nothing.
  ExpressionPtr expression(std::string_view key) const;
  std::string text(std::string_view key, std::string fallback = {}) const;
  std::string unit(std::string_view key) const;
  std::string choice(std::string_view key, std::initializer_list<std::string_view> choices, std::string fallback) const;
  bool boolean(std::string_view key, bool fallback) const;
  std::optional<long> integer(std::string_view key) const;
  // Reports when the key is absent, unless a misspelt one was reported.
  bool require(std::string_view key, const Mark& owner, std::string_view example) const;
  // Whether keys were reported, so that what is missing is probably one of them.
  bool has_unknown_keys() const { return has_unknown_keys_; }

 private:
  const Node& node_;
  std::string what_;
  Report& report_;
  bool valid_ = false;
  bool has_unknown_keys_ = false;
  std::vector<std::string> meant_;  // keys that unknown ones were probably meant to be
};

// "a list", "a mapping", "nothing" or "the text 'abc'", for "expected ..., got ...".
std::string describe(const Node& node);
// Reports and returns false unless the node is a text (a scalar).
bool require_text(const Node& node, std::string_view what, Report& report);
// "a block", "an input".
std::string with_article(std::string_view what);
// The text of a scalar that a person reads; warns where ` #` probably cut it.
std::string plain_text(const Node& node, std::string_view what, Report& report);
// `true` or `false`, a whole number; else reported, and the fallback or nothing.
bool to_boolean(const Node& node, std::string_view key, bool fallback, Report& report);
// One of the choices; else reported, and empty.
std::string to_choice(const Node& node, std::string_view key, const std::vector<std::string_view>& choices,
                      Report& report);
std::optional<long> to_integer(const Node& node, std::string_view key, Report& report);
// Reports a unit text that is none.
void check_unit(const Node& node, Report& report);
// Reports a name that is not made of ASCII letters, digits and underscores or is reserved. `what`: "block",
// "parameter".
bool check_name(const std::string& name, const Mark& mark, std::string_view what, Report& report);
// Where a key that is unknown here belongs: "simulation", or "".
std::string home_of(std::string_view key);

}  // namespace plantloop
