// YAML text -> Node tree. The only file that knows yaml-cpp, through its events.

#include "engine/diagram/document.h"

#include <yaml-cpp/anchor.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/parser.h>

#include <optional>
#include <sstream>
#include <streambuf>
#include <unordered_map>

#include "engine/base/text.h"
#include "engine/diagram/plain_yaml.h"
#include "engine/diagram/tree.h"

namespace plantloop {
namespace {

constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";

// Thrown inside yaml-cpp's events to stop it after a finding.
struct Stop {};

// Builds the tree from events. A mapping's next scalar is a key when `keys` and `items` are equally many.
class Builder final : public YAML::EventHandler {
 public:
  Builder(const Source& source, std::size_t shift, Report& report)
      : source_(source), shift_(shift), places_(source), report_(report) {}

  Node take() { return std::move(root_); }

  void OnDocumentStart(const YAML::Mark& mark) override {
    if (++documents_ < 2) return;
    report_.error(place(mark), "a second document begins here; a diagram file has one").named("yaml");
    throw Stop{};
  }
  void OnDocumentEnd() override {}

  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    Node node;
    node.offset = offset(mark);
    node.mark = places_.at(node.offset);
    // A value that is missing is missed at its key, not where the next line begins.
    const bool is_value = !open_.empty() && open_.back().node.is_mapping() && !key_expected();
    if (is_value && open_.back().node.key_marks.back().line != node.mark.line) {
      node.mark = open_.back().node.key_marks.back();
    }
    finish(std::move(node), anchor);
  }

  void OnAlias(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    const auto found = anchors_.find(anchor);
    if (found == anchors_.end()) {
      report_.error(place(mark), "this reference stands inside of what it refers to").named("yaml");
      throw Stop{};
    }
    repeat(found->second.count, places_.at(offset(mark)));
    nodes_ += found->second.count - 1;
    finish(Node(found->second.node), 0);
  }

  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& value) override {
    const bool quoted = tag == "!";
    if (!quoted) refuse_tag(mark, tag);
    Node node;
    node.kind = Node::Kind::scalar;
    node.text = value;
    node.quoted = quoted;
    node.offset = offset(mark);
    std::size_t size = scalar_size(source_.text, node.offset, value, quoted);
    if (size == 0) {
      report_.error(places_.at(node.offset), "this quote is never closed").named("yaml");
      throw Stop{};
    }
    node.mark = places_.at(node.offset, size);
    finish(std::move(node), anchor);
  }

  void OnSequenceStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value style) override {
    start(Node::Kind::sequence, mark, tag, anchor, style);
  }
  void OnSequenceEnd() override { end(); }
  void OnMapStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value style) override {
    start(Node::Kind::mapping, mark, tag, anchor, style);
  }
  void OnMapEnd() override { end(); }

 private:
  struct Open {
    Node node;
    YAML::anchor_t anchor = 0;
    std::size_t nodes_before = 0;
  };
  struct Anchored {
    Node node;
    std::size_t count = 1;
  };

  std::uint32_t offset(const YAML::Mark& mark) const {
    return static_cast<std::uint32_t>(static_cast<std::size_t>(std::max(mark.pos, 0)) + shift_);
  }
  Mark place(const YAML::Mark& mark) { return places_.at(offset(mark)); }

  // Copies cost memory, so there is a bound on them.
  void repeat(std::size_t count, const Mark& mark) {
    repeated_ += count;
    if (repeated_ <= most_repeated) return;
    report_.error(mark, "references repeat more than {} entries here", most_repeated).named("yaml");
    throw Stop{};
  }

  void refuse_tag(const YAML::Mark& mark, const std::string& tag) {
    if (tag.empty() || tag == "?") return;
    report_.error(place(mark), "YAML takes a text that begins with '!' for a tag: quote it")
        .hint("'not' is written as a word: not a")
        .named("yaml");
    throw Stop{};
  }

  bool key_expected() const {
    return !open_.empty() && open_.back().node.is_mapping() &&
           open_.back().node.keys.size() == open_.back().node.items.size();
  }

  void start(Node::Kind kind, const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
             YAML::EmitterStyle::value style) {
    if (tag != "!") refuse_tag(mark, tag);
    Open open;
    open.node.kind = kind;
    open.node.offset = offset(mark);
    open.node.mark = places_.at(open.node.offset);
    open.node.flow = style == YAML::EmitterStyle::Flow;
    open.anchor = anchor;
    open.nodes_before = nodes_;
    if (key_expected()) {
      report_.error(open.node.mark, "a key is a text, not a list or a mapping").named("yaml");
      throw Stop{};
    }
    if (open_.size() >= deepest_document) {
      report_.error(open.node.mark, "this is nested more than {} levels deep", deepest_document).named("yaml");
      throw Stop{};
    }
    open_.push_back(std::move(open));
  }

  void end() {
    Open open = std::move(open_.back());
    open_.pop_back();
    if (open.node.flow) {
      repair_colons(open.node, report_);
      repair_commas(open.node, report_);
    }
    if (open.node.is_mapping()) check_keys(open.node, report_);
    finish(std::move(open.node), open.anchor, nodes_ - open.nodes_before + 1);
  }

  void finish(Node node, YAML::anchor_t anchor, std::size_t count = 1) {
    ++nodes_;
    if (anchor != 0) {
      repeat(count, node.mark);
      anchors_[anchor] = {node, count};
    }
    if (open_.empty()) {
      root_ = std::move(node);
    } else if (key_expected()) {
      key(std::move(node));
    } else {
      open_.back().node.items.push_back(std::move(node));
    }
  }

  void key(Node node) {
    Node& mapping = open_.back().node;
    if (!node.is_scalar()) {
      report_.error(node.mark, "a key is missing before ':'").named("yaml");
    } else if (node.text == "<<" && !node.quoted) {
      report_.error(node.mark, "merge keys are not read: write the entries out, or make a subsystem type")
          .named("yaml");
    }
    mapping.keys.push_back(std::move(node.text));
    mapping.key_marks.push_back(node.mark);
  }

  const Source& source_;
  std::size_t shift_;
  Places places_;
  Report& report_;
  Node root_;
  std::vector<Open> open_;
  std::unordered_map<YAML::anchor_t, Anchored> anchors_;
  std::size_t nodes_ = 0;     // of the whole tree so far
  std::size_t repeated_ = 0;  // of them copies
  int documents_ = 0;
};

// A text as a stream, without a copy.
struct TextBuffer : std::streambuf {
  explicit TextBuffer(std::string_view text) {
    char* begin = const_cast<char*>(text.data());
    setg(begin, begin, begin + text.size());
  }
};

// What a file that is no text looks like to its owner; empty for a text.
std::string_view kind_of_binary(std::string_view text) {
  struct Magic {
    std::string_view begin, words;
  };
  constexpr Magic known[] = {{"\x89PNG", "a PNG picture"},
                             {"PK\x03\x04", "a ZIP archive, as .slx and .npz files are"},
                             {"%PDF", "a PDF document"},
                             {"\x1F\x8B", "a compressed file"},
                             {"\xFF\xD8\xFF", "a JPEG picture"},
                             {"\x7F"
                              "ELF",
                              "a program"},
                             {"MATLAB 5", "a MATLAB data file"}};
  for (const Magic& magic : known) {
    if (text.starts_with(magic.begin)) return magic.words;
  }
  return {};
}

bool check_text(const Source& source, Report& report) {
  const std::string_view text = source.text;
  const auto at = [&](std::size_t offset) { return Places(source).at(offset); };
  if (const std::string_view kind = kind_of_binary(text); !kind.empty()) {
    report.error(at(0), "this is {}, and a diagram is a YAML text", kind).named("yaml");
    return false;
  }
  if (text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF")) {
    report.error(at(0), "this file is UTF-16; save it as UTF-8").named("yaml");
    return false;
  }
  if (const auto bad = find_invalid_utf8(text)) {
    report.error(at(*bad), "this byte is no UTF-8; save the file as UTF-8").named("yaml");
    return false;
  }
  if (const std::size_t nul = text.find('\0'); nul != std::string_view::npos) {
    report.error(at(nul), "a NUL stands in the text: delete this byte, which is 0").named("yaml");
    return false;
  }
  return true;
}

Node read_with_yaml_cpp(const Source& source, Report& report) {
  const std::size_t shift = source.text.starts_with(byte_order_mark) ? byte_order_mark.size() : 0;
  TextBuffer buffer(std::string_view(source.text).substr(shift));
  std::istream stream(&buffer);
  Builder builder(source, shift, report);
  try {
    YAML::Parser parser(stream);
    while (parser.HandleNextDocument(builder)) {
    }
    return builder.take();
  } catch (const Stop&) {
    return {};
  } catch (const YAML::Exception& error) {
    const std::size_t at = static_cast<std::size_t>(std::max(error.mark.pos, 0)) + shift;
    const Words words = plain_words(source.text, at, error.msg);
    Finding& finding = report.error(Places(source).at(words.at, words.size), "{}", words.message).named("yaml");
    if (!words.hint.empty()) finding.hint(words.hint);
    return {};
  }
}

void check_all_keys(const Node& node, Report& report) {
  if (node.is_mapping()) check_keys(node, report);
  for (const Node& item : node.items) {
    if (!item.items.empty()) check_all_keys(item, report);
  }
}

}  // namespace

Node read_document(const std::shared_ptr<const Source>& source, Report& report) {
  report.keep(source);
  if (!check_text(*source, report)) return {};
  if (std::optional<Node> plain = read_plain(*source)) {
    check_all_keys(*plain, report);
    return std::move(*plain);
  }
  return read_general(source, report);
}

Node read_general(const std::shared_ptr<const Source>& source, Report& report) {
  const std::size_t before = report.error_count();
  Node root = read_with_yaml_cpp(*source, report);
  if (root.kind == Node::Kind::null && report.error_count() == before) {
    report.error(Places(*source).at(0), "there is no diagram in this file")
        .hint("a diagram begins with the line plantloop: 1; `plantloop new loop` writes one to begin with")
        .named("yaml");
  }
  return root;
}

}  // namespace plantloop
