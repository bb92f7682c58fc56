// The plain part of YAML, read directly.
//
// Invariant: a text that is accepted here gives the tree that yaml-cpp's events give, to the last mark (tests/diagram
// compares the two). Whatever is unusual - tabs, escapes, anchors, values over several lines, missing values - makes
// the reader give up, so that errors are found in one place only.

#include "engine/diagram/plain_yaml.h"

#include <algorithm>
#include <utility>

#include "engine/base/text.h"
#include "engine/diagram/places.h"

namespace plantloop {
namespace {

constexpr int deepest = 60;

// Thrown inside this file to hand the text to the general reader.
struct Unusual {};

bool is_null_word(std::string_view text) { return text == "~" || text == "null" || text == "Null" || text == "NULL"; }

class PlainReader {
 public:
  explicit PlainReader(const Source& source) : text_(source.text), places_(source) {}

  Node run() {
    next_line();
    if (at_end()) throw Unusual{};
    if (indent_ != 0) throw Unusual{};
    Node root = mapping(0, 1);
    if (!at_end()) throw Unusual{};
    return root;
  }

 private:
  // ---- lines ----
  bool at_end() const { return line_ >= text_.size(); }
  char peek(std::size_t ahead = 0) const { return at_ + ahead < end_ ? text_[at_ + ahead] : '\0'; }

  // Moves to the next line that has more than blanks and a comment; at_ is its first character.
  void next_line() {
    for (line_ = next_; line_ < text_.size(); line_ = next_) {
      const std::size_t found = text_.find('\n', line_);
      end_ = found == std::string_view::npos ? text_.size() : found;
      next_ = end_ + (found == std::string_view::npos ? 0 : 1);
      at_ = line_;
      while (at_ < end_ && text_[at_] == ' ') ++at_;
      indent_ = at_ - line_;
      if (at_ == end_ || text_[at_] == '#') continue;
      if (indent_ == 0 && (text_.substr(at_, 3) == "---" || text_.substr(at_, 3) == "..." || text_[at_] == '%')) {
        throw Unusual{};
      }
      return;
    }
    at_ = end_ = text_.size();
  }

  void spaces() {
    while (peek() == ' ') ++at_;
  }
  // Only blanks and a comment may follow.
  void end_of_value() {
    const std::size_t before = at_;
    spaces();
    if (at_ != end_ && (text_[at_] != '#' || at_ == before)) throw Unusual{};
  }

  // ---- blocks ----
  Node mapping(std::size_t indent, int depth) {
    if (depth > deepest) throw Unusual{};
    Node node;
    node.kind = Node::Kind::mapping;
    place(node, at_, 1);
    do {
      key(node);
      spaces();
      if (at_ == end_ || peek() == '#') {
        node.items.push_back(nested(indent, depth));
      } else {
        node.items.push_back(value(depth));
        end_of_value();
        next_line();
        if (!at_end() && indent_ > indent) throw Unusual{};  // the value goes on there
      }
    } while (!at_end() && indent_ == indent);
    return node;
  }

  void key(Node& node) {
    const std::size_t start = at_;
    while (is_letter(peek()) || is_digit(peek()) || peek() == '.') ++at_;
    const std::string_view name = text_.substr(start, at_ - start);
    if (name.empty() || name[0] == '.' || peek() != ':' || is_null_word(name)) throw Unusual{};
    if (at_ + 1 < end_ && text_[at_ + 1] != ' ') throw Unusual{};
    node.keys.emplace_back(name);
    node.key_marks.push_back(places_.at(start, name.size()));
    ++at_;
  }

  // What stands below `key:`.
  Node nested(std::size_t indent, int depth) {
    next_line();
    if (at_end()) throw Unusual{};
    const bool list = peek() == '-' && (peek(1) == ' ' || peek(1) == '\0');
    if (list && indent_ >= indent) return sequence(indent_, depth + 1);
    if (indent_ <= indent) throw Unusual{};
    return mapping(indent_, depth + 1);
  }

  Node sequence(std::size_t indent, int depth) {
    if (depth > deepest) throw Unusual{};
    Node node;
    node.kind = Node::Kind::sequence;
    place(node, at_, 1);
    while (!at_end() && indent_ == indent && peek() == '-' && peek(1) == ' ') {
      ++at_;
      spaces();
      if (at_ == end_ || peek() == '#' || peek() == '-') throw Unusual{};
      if (is_entry()) {
        const std::size_t inner = at_ - line_;
        node.items.push_back(mapping(inner, depth + 1));
        if (!at_end() && indent_ > indent) throw Unusual{};
      } else {
        node.items.push_back(value(depth));
        end_of_value();
        next_line();
        if (!at_end() && indent_ > indent) throw Unusual{};
      }
    }
    if (!at_end() && indent_ == indent && peek() == '-') throw Unusual{};
    return node;
  }

  // Does `key:` stand here?
  bool is_entry() const {
    std::size_t i = at_;
    while (i < end_ && (is_letter(text_[i]) || is_digit(text_[i]) || text_[i] == '.')) ++i;
    return i > at_ && i < end_ && text_[i] == ':' && (i + 1 == end_ || text_[i + 1] == ' ');
  }

  // ---- values on one line ----
  Node value(int depth) {
    const char c = peek();
    if (c == '{') return flow_mapping(depth + 1);
    if (c == '[') return flow_sequence(depth + 1);
    if (c == '"' || c == '\'') return quoted();
    return block_scalar();
  }

  void check_first() const {
    const char c = peek();
    const bool sign = c == '-' && peek(1) != ' ' && peek(1) != '\0' && peek(1) != '-';
    const bool plain = is_letter(c) || is_digit(c) || std::string_view("(.$+<=/^").find(c) != std::string_view::npos ||
                       static_cast<unsigned char>(c) >= 0x80;
    if (c == '\0' || (!plain && !sign)) throw Unusual{};
  }

  Node block_scalar() {
    check_first();
    const std::size_t start = at_;
    std::size_t stop = end_;
    for (std::size_t i = at_; i < end_; ++i) {
      const char c = text_[i];
      if (c == ':' && (i + 1 == end_ || text_[i + 1] == ' ')) throw Unusual{};
      if (c == '#' && text_[i - 1] == ' ') {
        stop = i;
        break;
      }
    }
    while (stop > start && text_[stop - 1] == ' ') --stop;
    at_ = stop;
    return scalar(start, text_.substr(start, stop - start), false, stop - start);
  }

  Node quoted() {
    const std::size_t start = at_;
    const char quote = peek();
    std::size_t close = start + 1;
    while (close < end_ && text_[close] != quote && text_[close] != '\\') ++close;
    if (close >= end_ || text_[close] != quote) throw Unusual{};
    if (quote == '\'' && close + 1 < end_ && text_[close + 1] == '\'') throw Unusual{};
    at_ = close + 1;
    if (peek() == ':') throw Unusual{};
    return scalar(start, text_.substr(start + 1, close - start - 1), true, at_ - start);
  }

  Node flow_scalar() {
    if (peek() == '"' || peek() == '\'') return quoted();
    check_first();
    const std::size_t start = at_;
    int open = 0;
    for (; at_ < end_; ++at_) {
      const char c = text_[at_];
      if (c == ',' || c == ']' || c == '}') break;
      if (c == '[' || c == '{' || c == '"' || c == '\'') throw Unusual{};
      if (c == ':' && (peek(1) == ' ' || peek(1) == '\0' || peek(1) == ',' || peek(1) == ']' || peek(1) == '}')) {
        throw Unusual{};
      }
      if (c == '#' && text_[at_ - 1] == ' ') throw Unusual{};
      open += c == '(' ? 1 : c == ')' ? -1 : 0;
    }
    if (open != 0) throw Unusual{};  // a comma may have cut it
    std::size_t stop = at_;
    while (stop > start && text_[stop - 1] == ' ') --stop;
    return scalar(start, text_.substr(start, stop - start), false, stop - start);
  }

  Node flow_value(int depth) {
    if (peek() == '{') return flow_mapping(depth + 1);
    if (peek() == '[') return flow_sequence(depth + 1);
    return flow_scalar();
  }

  // After an entry: true when the collection is closed.
  bool flow_end(char closing) {
    spaces();
    if (peek() == closing) {
      ++at_;
      return true;
    }
    if (peek() != ',') throw Unusual{};
    ++at_;
    spaces();
    if (peek() == closing || peek() == ',') throw Unusual{};
    return false;
  }

  Node flow_mapping(int depth) {
    Node node = flow_start(Node::Kind::mapping, depth);
    if (peek() == '}') {
      ++at_;
      return node;
    }
    do {
      key(node);
      spaces();
      node.items.push_back(flow_value(depth));
    } while (!flow_end('}'));
    return node;
  }

  Node flow_sequence(int depth) {
    Node node = flow_start(Node::Kind::sequence, depth);
    if (peek() == ']') {
      ++at_;
      return node;
    }
    do {
      node.items.push_back(flow_value(depth));
    } while (!flow_end(']'));
    return node;
  }

  Node flow_start(Node::Kind kind, int depth) {
    if (depth > deepest) throw Unusual{};
    Node node;
    node.kind = kind;
    node.flow = true;
    place(node, at_, 1);
    // Most have a few entries: one allocation instead of three.
    node.items.reserve(4);
    if (kind == Node::Kind::mapping) {
      node.keys.reserve(4);
      node.key_marks.reserve(4);
    }
    ++at_;
    spaces();
    return node;
  }

  Node scalar(std::size_t start, std::string_view text, bool is_quoted, std::size_t size) {
    if (text.empty() && !is_quoted) throw Unusual{};
    if (!is_quoted && is_null_word(text)) throw Unusual{};
    Node node;
    node.kind = Node::Kind::scalar;
    node.text = text;
    node.quoted = is_quoted;
    place(node, start, size);
    return node;
  }

  void place(Node& node, std::size_t offset, std::size_t size) {
    node.offset = static_cast<std::uint32_t>(offset);
    node.mark = places_.at(offset, size);
  }

  std::string_view text_;
  Places places_;
  std::size_t line_ = 0, next_ = 0;  // where this line and the next one begin
  std::size_t at_ = 0, end_ = 0;     // the place in this line, and its end
  std::size_t indent_ = 0;
};

}  // namespace

std::optional<Node> read_plain(const Source& source) {
  const bool unusual = std::any_of(source.text.begin(), source.text.end(), [](char c) {
    return (static_cast<unsigned char>(c) < 0x20 && c != '\n') || c == '\x7F';
  });
  if (unusual || source.text.starts_with("\xEF\xBB\xBF")) return std::nullopt;
  try {
    return PlainReader(source).run();
  } catch (const Unusual&) {
    return std::nullopt;
  }
}

}  // namespace plantloop
