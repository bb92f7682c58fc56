// Expression text -> tokens, with what newcomers from other languages write recognised.

#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "engine/diagram/expression.h"

namespace plantloop {

struct Token {
  enum class Kind { number, name, symbol, end };
  Kind kind = Kind::end;
  std::string_view text;  // as written; of a symbol what was meant, `and` for `&&`
  std::size_t at = 0;     // byte of the expression's text
  std::size_t size = 0;   // bytes as written
  bool space_before = false;

  bool is(std::string_view symbol) const { return kind == Kind::symbol && text == symbol; }
};

// The tokens, an end token last. Findings are reported; `failed` says that there were any.
struct Tokens {
  std::vector<Token> list;
  bool failed = false;
};
Tokens tokenize(std::string_view text, const TextPlace& place, Report& report);

// The place of bytes [at, at + size) of an expression's text.
Mark mark_at(std::string_view text, const TextPlace& place, std::size_t at, std::size_t size);

// What to write for a name of another language: "ln" -> "log"; "" when nothing is known.
std::string_view familiar_function(std::string_view name);

}  // namespace plantloop
