// Reading labels, and saying them.

#include "render/text/markup.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace plantloop {
namespace {

struct Script {
  char32_t raised, plain;
};
constexpr Script superscripts[] = {{U'⁰', U'0'}, {U'¹', U'1'}, {U'²', U'2'}, {U'³', U'3'}, {U'⁴', U'4'}, {U'⁵', U'5'},
                                   {U'⁶', U'6'}, {U'⁷', U'7'}, {U'⁸', U'8'}, {U'⁹', U'9'}, {U'⁺', U'+'}, {U'⁻', U'−'},
                                   {U'⁼', U'='}, {U'⁽', U'('}, {U'⁾', U')'}, {U'ⁿ', U'n'}, {U'ⁱ', U'i'}};
constexpr Script subscripts[] = {{U'₀', U'0'}, {U'₁', U'1'}, {U'₂', U'2'}, {U'₃', U'3'}, {U'₄', U'4'}, {U'₅', U'5'},
                                 {U'₆', U'6'}, {U'₇', U'7'}, {U'₈', U'8'}, {U'₉', U'9'}, {U'₊', U'+'}, {U'₋', U'−'},
                                 {U'₌', U'='}, {U'₍', U'('}, {U'₎', U')'}, {U'ₐ', U'a'}, {U'ₑ', U'e'}, {U'ₒ', U'o'},
                                 {U'ₓ', U'x'}, {U'ₕ', U'h'}, {U'ₖ', U'k'}, {U'ₗ', U'l'}, {U'ₘ', U'm'}, {U'ₙ', U'n'},
                                 {U'ₚ', U'p'}, {U'ₛ', U's'}, {U'ₜ', U't'}, {U'ᵢ', U'i'}, {U'ⱼ', U'j'}};

struct Name {
  std::u32string_view name;
  char32_t character;
};
constexpr Name symbols[] = {
    {U"alpha", U'α'},   {U"beta", U'β'},    {U"gamma", U'γ'},  {U"delta", U'δ'},   {U"epsilon", U'ε'},
    {U"zeta", U'ζ'},    {U"eta", U'η'},     {U"theta", U'θ'},  {U"iota", U'ι'},    {U"kappa", U'κ'},
    {U"lambda", U'λ'},  {U"mu", U'μ'},      {U"nu", U'ν'},     {U"xi", U'ξ'},      {U"pi", U'π'},
    {U"rho", U'ρ'},     {U"sigma", U'σ'},   {U"tau", U'τ'},    {U"upsilon", U'υ'}, {U"phi", U'φ'},
    {U"varphi", U'φ'},  {U"chi", U'χ'},     {U"psi", U'ψ'},    {U"omega", U'ω'},   {U"Gamma", U'Γ'},
    {U"Delta", U'Δ'},   {U"Theta", U'Θ'},   {U"Lambda", U'Λ'}, {U"Xi", U'Ξ'},      {U"Pi", U'Π'},
    {U"Sigma", U'Σ'},   {U"Upsilon", U'Υ'}, {U"Phi", U'Φ'},    {U"Psi", U'Ψ'},     {U"Omega", U'Ω'},
    {U"cdot", U'·'},    {U"times", U'×'},   {U"pm", U'±'},     {U"le", U'≤'},      {U"ge", U'≥'},
    {U"ne", U'≠'},      {U"approx", U'≈'},  {U"infty", U'∞'},  {U"int", U'∫'},     {U"sum", U'∑'},
    {U"partial", U'∂'}, {U"nabla", U'∇'},   {U"to", U'→'},     {U"degree", U'°'}};
// With the combining characters that say them.
constexpr Name accents[] = {
    {U"hat", U'\u0302'}, {U"bar", U'\u0304'}, {U"dot", U'\u0307'}, {U"ddot", U'\u0308'}, {U"tilde", U'\u0303'}};

template <std::size_t n>
const Name* find(const Name (&names)[n], std::u32string_view name) {
  const auto* found =
      std::find_if(std::begin(names), std::end(names), [&](const Name& entry) { return entry.name == name; });
  return found == std::end(names) ? nullptr : found;
}

bool is_digit(char32_t c) { return c >= U'0' && c <= U'9'; }

bool is_letter(char32_t c) {
  return (c >= U'a' && c <= U'z') || (c >= U'A' && c <= U'Z') || (c >= 0xC0 && c < 0x2000 && c != 0xD7 && c != 0xF7);
}

bool is_word(char32_t c) { return is_letter(c) || is_digit(c); }

struct Parser {
  std::u32string_view text;
  std::size_t at = 0;
  std::vector<Piece> pieces;
  std::size_t command_end = 0;  // of the last \\command

  void put(int level, char32_t c) {
    if (pieces.empty() || pieces.back().level != level || pieces.back().kind != Piece::Kind::text)
      pieces.push_back({Piece::Kind::text, level, {}, {}});
    pieces.back().text += c;
  }

  // Pieces of an inner text at a level; what is above or below already stays there.
  void put_all(int level, std::vector<Piece> inner) {
    for (Piece& piece : inner) {
      if (piece.level == 0) piece.level = level;
      if (piece.kind == Piece::Kind::text)
        for (const char32_t c : piece.text) put(piece.level, c == U'-' && level != 0 ? U'−' : c);
      else
        pieces.push_back(std::move(piece));
    }
  }

  // What stands between the brace here and its partner, parsed; `at` is then behind it.
  std::vector<Piece> group() {
    std::size_t end = at + 1;
    for (int depth = 1; end < text.size(); ++end) {
      if (text[end] == U'{') ++depth;
      if (text[end] == U'}' && --depth == 0) break;
    }
    Parser inner{text.substr(at + 1, end - at - 1)};
    at = std::min(end + 1, text.size());
    return inner.parse();
  }

  // The argument of a command: a group, another command, or one character.
  std::vector<Piece> argument() {
    while (next() == U' ') ++at;
    if (next() == U'{') return group();
    if (next() == U'\\') {
      Parser inner{text.substr(at)};
      if (inner.command()) {
        at += inner.at;
        return std::move(inner.pieces);
      }
    }
    if (at >= text.size()) return {};
    return {{Piece::Kind::text, 0, std::u32string(1, text[at++]), {}}};
  }

  // \\alpha, \\frac{a}{b}, \\sqrt{x}, \\hat{y}, ...: false when it is no known command.
  bool command() {
    std::size_t end = at + 1;
    while (end < text.size() && ((text[end] >= U'a' && text[end] <= U'z') || (text[end] >= U'A' && text[end] <= U'Z')))
      ++end;
    const std::u32string_view name = text.substr(at + 1, end - at - 1);
    const std::size_t start = at;
    at = end;
    if (name == U"frac") {
      std::vector<Piece> above = argument(), below = argument();
      pieces.push_back({Piece::Kind::fraction, 0, {}, {std::move(above), std::move(below)}});
    } else if (name == U"sqrt") {
      pieces.push_back({Piece::Kind::root, 0, {}, {argument()}});
    } else if (name == U"mathrm" || name == U"text") {
      put_all(0, argument());
    } else if (const auto* accent = find(accents, name)) {
      pieces.push_back({Piece::Kind::accent, 0, std::u32string(1, accent->character), {argument()}});
    } else if (const auto* symbol = find(symbols, name)) {
      put(0, symbol->character);
    } else {
      at = start;
      return false;
    }
    command_end = at;
    return true;
  }

  char32_t next(std::size_t ahead = 0) const { return at + ahead < text.size() ? text[at + ahead] : U'\0'; }

  // How many letters and digits stand right before the mark.
  std::size_t name_before(std::size_t mark) const {
    if (command_end == mark && mark > 0) return 1;
    std::size_t count = 0;
    while (mark - count > command_end && is_word(text[mark - 1 - count])) ++count;
    return count;
  }

  void word(int level) {
    while (is_word(next())) put(level, text[at++]);
  }

  void number(int level) {
    if (next() == U'-' || next() == U'−' || next() == U'+') put(level, text[at] == U'-' ? U'−' : text[at]), ++at;
    while (is_digit(next())) put(level, text[at++]);
  }

  bool subscript() {
    const std::size_t name = name_before(at);
    const bool after_bracket = at > 0 && (text[at - 1] == U')' || text[at - 1] == U'}');
    if (next(1) == U'{') {
      ++at;
      put_all(-1, group());
      return true;
    }
    if ((name == 0 && !after_bracket) || name > 2 || !is_word(next(1))) return false;
    ++at;
    word(-1);
    return true;
  }

  bool superscript() {
    if (at == 0) return false;
    if (next(1) == U'{') {
      ++at;
      put_all(1, group());
      return true;
    }
    const bool sign = next(1) == U'-' || next(1) == U'−' || next(1) == U'+';
    if (is_digit(next(1)) || (sign && is_digit(next(2)))) {
      ++at;
      number(1);
      return true;
    }
    if (!is_letter(next(1)) && next(1) != U'*') return false;
    ++at;
    put(1, text[at++]);
    return true;
  }

  bool unicode_script(const Script* begin, const Script* end, int level) {
    const auto* found = std::find_if(begin, end, [&](const Script& s) { return s.raised == text[at]; });
    if (found == end) return false;
    put(level, found->plain);
    ++at;
    return true;
  }

  // Whether the hyphen here is meant as a minus: between spaces, before a number or a symbol, or in "(k-1)". Others, as
  // in "closed-loop" and "10-20", stay what they are.
  bool minus() const {
    if (text[at] != U'-') return false;
    const char32_t before = at > 0 ? text[at - 1] : U' ';
    const char32_t earlier = at > 1 ? text[at - 2] : U' ';
    if (is_letter(before)) return (earlier == U'(' || earlier == U'[') && is_word(next(1));
    if (before != U' ' && before != U'(' && before != U'=' && before != U'[') return false;
    const bool symbol = is_letter(next(1)) && !is_word(next(2));
    return is_digit(next(1)) || next(1) == U'.' || next(1) == U'∞' || next(1) == U'\\' || symbol ||
           (at > 0 && next(1) == U' ');
  }

  std::vector<Piece> parse() {
    while (at < text.size()) {
      const char32_t c = text[at];
      if (c == U'\\' && (next(1) == U'_' || next(1) == U'^')) {
        put(0, next(1));
        at += 2;
      } else if (c == U'\\' && command()) {
        continue;
      } else if ((c == U'_' && subscript()) || (c == U'^' && superscript())) {
        continue;
      } else if (unicode_script(std::begin(superscripts), std::end(superscripts), 1) ||
                 unicode_script(std::begin(subscripts), std::end(subscripts), -1)) {
        continue;
      } else {
        put(0, minus() ? U'−' : (c < 0x20 ? U' ' : c));
        ++at;
      }
    }
    return std::move(pieces);
  }
};

// In brackets when it is more than one name or number.
std::u32string bracketed(const std::vector<Piece>& pieces) {
  const std::u32string words = readable(pieces);
  const bool simple = std::all_of(words.begin(), words.end(), [](char32_t c) { return is_word(c) || c > 0x7F; });
  return simple ? words : U"(" + words + U")";
}

std::u32string said(const Piece& piece) {
  switch (piece.kind) {
    case Piece::Kind::fraction:
      return bracketed(piece.parts[0]) + U"/" + bracketed(piece.parts[1]);
    case Piece::Kind::root:
      return U"√" + bracketed(piece.parts[0]);
    case Piece::Kind::accent:
      return readable(piece.parts[0]) + piece.text;
    case Piece::Kind::text:
      break;
  }
  return piece.text;
}

}  // namespace

std::vector<Piece> parse_markup(std::u32string_view text) { return Parser{text}.parse(); }

std::u32string readable(const std::vector<Piece>& pieces) {
  std::u32string result;
  for (const Piece& piece : pieces) {
    if (piece.kind != Piece::Kind::text) {
      result += said(piece);
      continue;
    }
    std::u32string marked;
    bool all = true;
    for (const char32_t c : piece.text) {
      const auto find = [&](const Script* begin, const Script* end) {
        const auto* found = std::find_if(begin, end, [&](const Script& s) { return s.plain == c; });
        if (found == end)
          all = false;
        else
          marked += found->raised;
      };
      if (piece.level > 0) find(std::begin(superscripts), std::end(superscripts));
      if (piece.level < 0) find(std::begin(subscripts), std::end(subscripts));
    }
    if (piece.level == 0)
      result += piece.text;
    else if (all)
      result += marked;
    else
      result += (piece.level > 0 ? U"^" : U"_") + piece.text;
  }
  return result;
}

}  // namespace plantloop
