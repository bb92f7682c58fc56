// Expression text -> tree, by descent through the precedences.
//
//   or < and < not < comparison < + - < * / < unary < ^ (from the right) < primary

#include <fmt/format.h>

#include <algorithm>
#include <unordered_map>
#include <variant>

#include "engine/base/numbers.h"
#include "engine/base/text.h"
#include "engine/base/units.h"
#include "engine/diagram/expression_lexer.h"

namespace plantloop {
namespace {

constexpr int deepest_nesting = 200;
constexpr int deepest_tree = 1000;  // what a long chain of operators may reach

using Kind = Expression::Kind;

// A subtree and how many levels it has; null after a finding.
struct Part {
  std::shared_ptr<Expression> tree;
  int depth = 1;
  explicit operator bool() const { return tree != nullptr; }
};

const FunctionSignature* find_function(std::string_view name) {
  static const auto index = [] {
    std::unordered_map<std::string_view, const FunctionSignature*> map;
    for (const FunctionSignature& function : expression_functions()) map.emplace(function.name, &function);
    return map;
  }();
  const auto found = index.find(name);
  return found == index.end() ? nullptr : found->second;
}

bool is_comparison(const Token& token) {
  constexpr std::string_view all[] = {"<", "<=", ">", ">=", "==", "!="};
  return token.kind == Token::Kind::symbol && std::find(std::begin(all), std::end(all), token.text) != std::end(all);
}

class Parser {
 public:
  Parser(std::string_view text, const TextPlace& place, Report& report)
      : text_(text), place_(place), report_(report), tokens_(tokenize(text, place, report)) {}

  ExpressionPtr run() {
    if (tokens_.list.size() == 1) {
      if (!tokens_.failed) error(0, text_.size(), "the expression is empty");
      return nullptr;
    }
    // A stray character makes what follows unreadable; one finding is enough.
    Part whole = disjunction();
    if (whole && token().kind != Token::Kind::end) {
      left_over();
      return nullptr;
    }
    return whole && !tokens_.failed ? whole.tree : nullptr;
  }

 private:
  const Token& token(std::size_t ahead = 0) const {
    return tokens_.list[std::min(at_ + ahead, tokens_.list.size() - 1)];
  }
  bool is_word(std::string_view word) const {
    return (token().kind == Token::Kind::name || token().kind == Token::Kind::symbol) && token().text == word;
  }
  Mark mark(const Token& t) const { return mark_at(text_, place_, t.at, t.size); }
  std::string_view written(const Token& t) const { return text_.substr(t.at, t.size); }

  template <typename... Args>
  Finding* error(std::size_t at, std::size_t size, fmt::format_string<Args...> words, Args&&... args) {
    if (tokens_.failed) return nullptr;  // what follows the first finding is often its consequence
    tokens_.failed = true;
    return &report_.error(mark_at(text_, place_, at, size), words, std::forward<Args>(args)...).named("expression");
  }
  template <typename... Args>
  Part fail(const Token& t, std::string_view hint, fmt::format_string<Args...> words, Args&&... args) {
    Finding* finding = error(t.at, t.size, words, std::forward<Args>(args)...);
    if (finding && !hint.empty()) finding->hint(std::string(hint));
    return {};
  }
  // A finding that does not stop the parser: its tree is still readable.
  template <typename... Args>
  Finding& complain(const Token& t, fmt::format_string<Args...> words, Args&&... args) {
    tokens_.failed = true;
    return report_.error(mark(t), words, std::forward<Args>(args)...).named("expression");
  }

  Part node(Kind kind, const Token& t, std::string text, std::vector<Part> arguments) {
    auto tree = std::make_shared<Expression>();
    tree->kind = kind;
    tree->text = std::move(text);
    tree->mark = mark(t);
    int depth = 0;
    tree->arguments.reserve(arguments.size());
    for (Part& argument : arguments) {
      depth = std::max(depth, argument.depth);
      tree->arguments.push_back(std::move(argument.tree));
    }
    if (depth >= deepest_tree) {
      return fail(t, "split it into blocks, or add up a vector with sum([...])",
                  "this expression has more than {} operators in a row", deepest_tree);
    }
    return {std::move(tree), depth + 1};
  }
  Part binary(const Token& t, Part left, Part right) {
    if (!left || !right) return {};
    std::vector<Part> both;
    both.reserve(2);
    both.push_back(std::move(left));
    both.push_back(std::move(right));
    return node(Kind::binary, t, std::string(t.text), std::move(both));
  }
  Part unary(const Token& t, Part argument) {
    if (!argument) return {};
    std::vector<Part> one;
    one.push_back(std::move(argument));
    return node(Kind::unary, t, std::string(t.text), std::move(one));
  }

  Part disjunction() {
    Part left = conjunction();
    while (left && is_word("or")) {
      const Token& t = take();
      left = binary(t, std::move(left), conjunction());
    }
    return left;
  }

  Part conjunction() {
    Part left = negation();
    while (left && is_word("and")) {
      const Token& t = take();
      left = binary(t, std::move(left), negation());
    }
    return left;
  }

  Part negation() {
    if (!is_word("not")) return comparison();
    const Deeper deeper(*this);
    if (!deeper.ok) return {};
    const Token& t = take();
    return unary(t, negation());
  }

  Part comparison() {
    Part left = additive();
    if (!left || !is_comparison(token())) return left;
    const std::size_t first = at_;
    const Token& t = take();
    Part right = additive();
    if (right && is_comparison(token())) {
      const Token& middle_begin = tokens_.list[first + 1];
      const Token& middle_end = tokens_.list[at_ - 1];
      const std::string_view middle = text_.substr(middle_begin.at, middle_end.at + middle_end.size - middle_begin.at);
      const bool equal = t.text == "==" && token().is("==");
      return fail(token(),
                  equal ? fmt::format("write a == b and b == c, with b being {}", middle)
                        : fmt::format("write a {} b and b {} c, with b being {}", t.text, token().text, middle),
                  "comparisons cannot be chained");
    }
    return binary(t, std::move(left), std::move(right));
  }

  Part additive() {
    Part left = multiplicative();
    while (left && (token().is("+") || token().is("-"))) {
      const Token& t = take();
      left = binary(t, std::move(left), multiplicative());
    }
    return left;
  }

  Part multiplicative() {
    Part left = signed_power();
    while (left && (token().is("*") || token().is("/"))) {
      const Token& t = take();
      left = binary(t, std::move(left), signed_power());
    }
    return left;
  }

  Part signed_power() {
    if (!token().is("-") && !token().is("+")) return power();
    const Deeper deeper(*this);
    if (!deeper.ok) return {};
    const Token& t = take();
    return unary(t, signed_power());
  }

  // -x^2 is -(x^2), 2^-x is 2^(-x), and a^b^c is a^(b^c).
  Part power() {
    Part base = primary();
    if (!base || !token().is("^")) return base;
    const Deeper deeper(*this);
    if (!deeper.ok) return {};
    const Token& t = take();
    return binary(t, std::move(base), signed_power());
  }

  Part primary() {
    const Deeper deeper(*this);
    if (!deeper.ok) return {};
    const Token& t = token();
    Part part;
    if (t.kind == Token::Kind::number) {
      part = number();
    } else if (t.kind == Token::Kind::name) {
      part = name();
    } else if (t.is("(")) {
      part = brackets();
    } else if (t.is("[")) {
      part = vector();
    } else {
      return operand_missing();
    }
    if (part) check_follower();
    return part;
  }

  Part number() {
    const Token& t = take();
    const auto value = parse_number(t.text);
    if (!value) return fail(t, "", "the number {} is too large", t.text);
    Part part = node(Kind::number, t, std::string(t.text), {});
    if (part) part.tree->number = *value;
    return part;
  }

  Part name() {
    const Token& t = token();
    const bool word = t.text == "and" || t.text == "or" || t.text == "not";
    if (word) return operand_missing();
    if (token(1).is("(")) return call();
    take();
    if (find_function(t.text)) {
      return fail(t, fmt::format("a call is written {}(...)", t.text), "'{}' is a function", t.text);
    }
    Part part = node(Kind::name, t, {}, {});
    if (part) split(t, *part.tree);
    return part;
  }

  void split(const Token& t, Expression& tree) {
    std::string_view rest = t.text;
    if (const std::size_t colon = rest.find(':'); colon != std::string_view::npos) {
      tree.slice_end = parse_integer(rest.substr(colon + 1)).value_or(0);
      rest = rest.substr(0, colon);
    }
    tree.parts.reserve(1 + static_cast<std::size_t>(std::count(rest.begin(), rest.end(), '.')));
    for (;;) {
      const std::size_t point = rest.find('.');
      tree.parts.emplace_back(rest.substr(0, point));
      if (point == std::string_view::npos) break;
      rest.remove_prefix(point + 1);
    }
    const long begin = parse_integer(tree.parts.back()).value_or(0);
    if (tree.slice_end != 0 && tree.slice_end < begin) {
      complain(t, "the slice {}:{} ends before it begins", begin, tree.slice_end);
    }
  }

  Part call() {
    const Token& t = take();
    const Token& open = take();
    const FunctionSignature* function = find_function(t.text);
    if (!function) unknown_function(t);
    std::vector<Part> arguments;
    if (!list(open, ")", arguments)) return {};
    const int n = static_cast<int>(arguments.size());
    if (function && (n < function->least || (function->most >= 0 && n > function->most))) wrong_count(t, *function, n);
    if (t.text == "pow" && n == 2) {
      Part power = node(Kind::binary, t, "^", std::move(arguments));
      return power;
    }
    return node(Kind::call, t, std::string(t.text), std::move(arguments));
  }

  void unknown_function(const Token& t) {
    if (asks_for_derivative(t.text)) {
      complain(t, "there is no pure derivative: it would amplify noise and steps without bound")
          .hint(
              "write a block, {type: filtered_derivative, in: x}, which has a pole at N; or velocity_pi for a "
              "controller in velocity form")
          .hint("the derivative of a state is the integrator's input: give that a name of its own")
          .named("no-derivative");
      return;
    }
    Finding& finding = complain(t, "there is no function '{}'", t.text);
    if (const std::string_view ours = familiar_function(t.text); !ours.empty()) {
      finding.hint(fmt::format("write {}", ours));
      return;
    }
    std::vector<std::string> names;
    for (const FunctionSignature& known : expression_functions()) names.emplace_back(known.name);
    const std::string near = nearest(t.text, names);
    if (!near.empty()) {
      finding.hint(fmt::format("did you mean '{}'?", near));
    } else if (token().kind == Token::Kind::number && token(1).is(")")) {
      finding.hint(fmt::format("an element is written with a dot, {}.{}; a product with *", t.text, token().text));
    } else {
      finding.hint(fmt::format("a product is written with *: {}*(...)", t.text));
    }
  }

  void wrong_count(const Token& t, const FunctionSignature& function, int n) {
    const std::string expected = function.most < 0 ? fmt::format("at least {}", function.least)
                                 : function.least == function.most
                                     ? fmt::format("{}", function.least)
                                     : fmt::format("{} or {}", function.least, function.most);
    const bool one = expected == "1" || expected == "at least 1";
    Finding& finding = complain(t, "{} takes {} argument{}, here are {}", t.text, expected, one ? "" : "s", n);
    if (t.text == "atan" && n == 2)
      finding.hint("the angle of a point is atan2(y, x)");
    else if (t.text == "log" && n == 2)
      finding.hint("a logarithm to another base is log(x)/log(b)");
    else if (t.text == "round" && n == 2)
      finding.hint("rounded to steps of q: round(x/q)*q");
    else
      finding.hint(std::string(function.doc));
  }

  // Arguments up to the closing bracket, which is taken. False after a finding.
  bool list(const Token& open, std::string_view closing, std::vector<Part>& parts) {
    if (token().is(closing)) {
      take();
      return true;
    }
    for (;;) {
      Part part = disjunction();
      if (!part) return false;
      parts.push_back(std::move(part));
      if (token().is(",")) {
        take();
        continue;
      }
      if (!token().is(closing)) {
        unclosed(open, closing);
        return false;
      }
      take();
      return true;
    }
  }

  Part brackets() {
    const Token& open = take();
    if (token().is(")")) return fail(open, "", "there is nothing between these brackets");
    Part inner = disjunction();
    if (!inner) return {};
    if (token().is(",")) return fail(token(), "a vector is written [a, b]", "a comma stands between round brackets");
    if (!token().is(")")) {
      unclosed(open, ")");
      return {};
    }
    take();
    return inner;
  }

  Part vector() {
    const Token& open = take();
    std::vector<Part> parts;
    if (token().is("]")) return fail(open, "", "a vector has at least one element");
    if (!list(open, "]", parts)) return {};
    return node(Kind::vector, open, {}, std::move(parts));
  }

  void unclosed(const Token& open, std::string_view closing) {
    const Token& t = token();
    if (t.kind == Token::Kind::end) {
      const std::size_t last = text_.find_last_not_of(" \t\n\r");
      Finding* finding = error(open.at, open.size, "the bracket '{}' is never closed", open.text);
      if (finding && place_.start.source) finding->also(mark_at(text_, place_, last, 1), "the expression ends here");
      return;
    }
    if (t.is(")") || t.is("]")) {
      Finding* finding = error(t.at, t.size, "'{}' does not close '{}'", t.text, open.text);
      if (finding) finding->also(mark(open), "opened here");
      return;
    }
    if (closing == "]" && (t.kind == Token::Kind::number || t.kind == Token::Kind::name)) {
      fail(t, "write [1, 2, 3]", "elements of a vector are separated by commas");
      return;
    }
    left_over();
  }

  // Something stands behind a whole expression.
  void left_over() {
    const Token& t = token();
    if (t.is(")") || t.is("]")) {
      error(t.at, t.size, "'{}' closes a bracket that was never opened", t.text);
    } else if (t.is(",")) {
      const Token& before = tokens_.list[at_ > 0 ? at_ - 1 : 0];
      const bool decimal = before.kind == Token::Kind::number && token(1).kind == Token::Kind::number;
      fail(t,
           decimal ? fmt::format("a decimal number has a point, {}.{}; a vector is written [a, b]", written(before),
                                 written(token(1)))
                   : "a vector is written [a, b]",
           "a comma separates the arguments of a function or the elements of a vector");
    } else {
      operator_missing(t);
    }
  }

  void operator_missing(const Token& t) {
    const Token& before = tokens_.list[at_ > 0 ? at_ - 1 : 0];
    const bool after_number = before.kind == Token::Kind::number;
    if (after_number && t.kind == Token::Kind::number && !t.space_before) {
      error(before.at, t.at + t.size - before.at, "'{}{}' is no number: it has two points", written(before),
            written(t));
      return;
    }
    if (tokens_.list.front().text == "if" || t.text == "if") {
      fail(t, "a choice is written where(condition, a, b)", "an operator is missing before '{}'", written(t));
      return;
    }
    const bool unit = after_number && t.kind == Token::Kind::name && is_unit(t.text);
    fail(t, unit ? "a number is written without its unit; a parameter can state it: {value: 3, unit: kg}" : "",
         "an operator is missing before '{}'", written(t));
  }

  static bool is_unit(std::string_view name) { return std::holds_alternative<Unit>(parse_unit(name)); }

  // x[1], (a)(b), a b: said where it happens.
  void check_follower() {
    const Token& t = token();
    const Token& before = tokens_.list[at_ - 1];
    if (t.is("[") && !t.space_before) {
      fail(t, fmt::format("write {}.1; elements count from 1", before.kind == Token::Kind::name ? before.text : "x"),
           "an element is written with a dot, not with brackets");
    } else if (t.is("(")) {
      fail(t, "a product is written with *", "an operator is missing before '('");
    }
  }

  Part operand_missing() {
    const Token& t = token();
    if (t.kind == Token::Kind::end) {
      const Token& last = tokens_.list[at_ - 1];
      Finding* finding = error(last.at, last.size, "the expression ends after '{}'", written(last));
      if (finding && ends_in_comment())
        finding->hint("' #' begins a comment; quote the expression if it goes on there");
      return {};
    }
    if (is_word("not")) return fail(t, "write (not a)", "'not' binds weaker than the operator before it");
    const std::string before = at_ > 0 ? fmt::format(" after '{}'", written(tokens_.list[at_ - 1])) : "";
    if (t.is(")") || t.is("]")) {
      if (at_ == 0) return fail(t, "", "'{}' closes a bracket that was never opened", t.text);
      return fail(t, "", "something is missing before '{}'", t.text);
    }
    return fail(t, "", "'{}' stands where a number, a name or a bracket was expected{}", written(t), before);
  }

  bool ends_in_comment() const {
    const Mark& start = place_.start;
    if (!start.source) return false;
    std::string_view rest = start.source->text;
    for (std::uint32_t line = 1; line < start.line; ++line) {
      const std::size_t end = rest.find('\n');
      if (end == std::string_view::npos) return false;
      rest.remove_prefix(end + 1);
    }
    rest = rest.substr(0, rest.find('\n'));
    const std::size_t found = rest.find(text_);
    if (found == std::string_view::npos) return false;
    rest.remove_prefix(found + text_.size());
    const std::size_t next = rest.find_first_not_of(' ');
    return next != std::string_view::npos && next > 0 && rest[next] == '#';
  }

  const Token& take() { return tokens_.list[at_ < tokens_.list.size() - 1 ? at_++ : at_]; }

  struct Deeper {
    explicit Deeper(Parser& p) : parser(p), ok(++p.nesting_ <= deepest_nesting) {
      if (!ok) {
        const Token& t = p.token();
        p.error(t.at, t.size, "this expression is nested more than {} levels deep", deepest_nesting);
      }
    }
    ~Deeper() { --parser.nesting_; }
    Deeper(const Deeper&) = delete;
    Deeper& operator=(const Deeper&) = delete;
    Parser& parser;
    bool ok;
  };

  std::string_view text_;
  const TextPlace& place_;
  Report& report_;
  Tokens tokens_;
  std::size_t at_ = 0;
  int nesting_ = 0;
};

}  // namespace

ExpressionPtr parse_expression(std::string_view text, const TextPlace& place, Report& report) {
  constexpr std::size_t longest = 1 << 20;
  if (text.size() > longest) {
    report.error(place.start, "this expression is longer than {} characters", longest).named("expression");
    return nullptr;
  }
  return Parser(text, place, report).run();
}

}  // namespace plantloop
