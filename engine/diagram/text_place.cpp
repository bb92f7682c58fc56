// Where the characters of a scalar lie in its source, found by scanning the source again.

#include "engine/base/text.h"
#include "engine/diagram/document.h"
#include "engine/diagram/places.h"

namespace plantloop {
namespace {

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }

int hex_digits(char c) { return c == 'x' ? 2 : c == 'u' ? 4 : c == 'U' ? 8 : 0; }

// Walks the source beside the text. A blank of the text is where the source has its run of blanks or breaks; any other
// byte is the next one of the source that is no blank, with escapes decoded as far as their size goes.
class Walk {
 public:
  Walk(const Node& scalar, std::string_view source) : text_(scalar.text), source_(source), at_(scalar.offset) {
    const char first = at_ < source.size() ? source[at_] : '\0';
    if (scalar.quoted && (first == '"' || first == '\'')) {
      quote_ = first;
      ++at_;
    } else if (scalar.quoted) {
      at_ = std::min(source.find('\n', at_), source.size());  // the line of | or >
    }
  }

  // Byte offsets in the source, one for each byte of the text.
  std::vector<std::size_t> run() {
    std::vector<std::size_t> places;
    places.reserve(text_.size());
    for (std::size_t i = 0; i < text_.size();) {
      const std::size_t size = text_[i] == ' ' || text_[i] == '\n' ? blank() : character(i);
      places.insert(places.end(), size, last_);
      i += size;
    }
    return places;
  }

 private:
  char peek(std::size_t ahead = 0) const { return at_ + ahead < source_.size() ? source_[at_ + ahead] : '\0'; }

  std::size_t blank() {
    last_ = at_;
    if (peek() == ' ' || peek() == '\t' || peek() == '\n')
      ++at_;
    else if (quote_ == '"' && peek() == '\\' && peek(1) != '\n')
      at_ += 2;
    return 1;
  }

  std::size_t character(std::size_t i) {
    for (;;) {
      while (is_blank(peek()) && text_[i] != peek()) ++at_;
      if (quote_ == '"' && peek() == '\\' && (peek(1) == '\n' || peek(1) == '\r'))
        at_ += 2;
      else
        break;
    }
    last_ = at_;
    const std::size_t size = character_length(text_, i);
    if (quote_ == '"' && peek() == '\\') {
      at_ += 2 + static_cast<std::size_t>(hex_digits(peek(1)));
    } else if (quote_ == '\'' && peek() == '\'' && peek(1) == '\'') {
      at_ += 2;
    } else {
      at_ += size;
    }
    return std::min(size, text_.size() - i);
  }

  std::string_view text_, source_;
  std::size_t at_;
  std::size_t last_ = 0;
  char quote_ = '\0';
};

}  // namespace

TextPlace text_place(const Node& scalar) {
  TextPlace place{.start = scalar.mark, .positions = {}};
  if (!scalar.mark.source || scalar.mark.line == 0) return place;
  const std::string_view source = scalar.mark.source->text;
  const std::string_view here = source.substr(std::min<std::size_t>(scalar.offset, source.size()));
  if (!scalar.quoted && here.starts_with(scalar.text)) return place;
  // Quoted, but on one line and without escapes.
  if (scalar.quoted && here.size() > scalar.text.size() + 1 && (here[0] == '"' || here[0] == '\'') &&
      here.substr(1).starts_with(scalar.text) && here[scalar.text.size() + 1] == here[0] &&
      scalar.text.find('\n') == std::string::npos) {
    place.start.column += 1;
    place.start.length -= std::min(place.start.length - 1, 2U);
    return place;
  }
  Places places(*scalar.mark.source);
  for (const std::size_t offset : Walk(scalar, source).run()) place.positions.push_back(places.at(offset));
  if (!place.positions.empty()) place.start = place.positions.front();
  return place;
}

namespace {

ExpressionPtr join(const Node& sequence, Report& report) {
  auto tree = std::make_shared<Expression>();
  tree->kind = Expression::Kind::vector;
  tree->mark = sequence.mark;
  if (sequence.items.empty()) {
    report.error(sequence.mark, "a vector has at least one element").named("expression");
    return nullptr;
  }
  bool complete = true;
  for (const Node& item : sequence.items) {
    ExpressionPtr part = item.is_sequence() ? join(item, report) : parse_expression(item, report);
    complete = complete && part;
    tree->arguments.push_back(std::move(part));
  }
  return complete ? tree : nullptr;
}

}  // namespace

ExpressionPtr parse_expression(const Node& node, Report& report) {
  switch (node.kind) {
    case Node::Kind::scalar:
      return parse_expression(node.text, text_place(node), report);
    case Node::Kind::sequence:
      return join(node, report);
    case Node::Kind::mapping:
      report.error(node.mark, "an expression was expected here, not a mapping").named("expression");
      return nullptr;
    case Node::Kind::null:
      report.error(node.mark, "an expression was expected here").named("expression");
      return nullptr;
  }
  return nullptr;
}

}  // namespace plantloop
