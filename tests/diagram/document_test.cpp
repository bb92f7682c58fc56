// Documents: both readers of YAML give the same tree, and every key and value knows its place.

#include "engine/diagram/document.h"

#include <gtest/gtest.h>

#include "engine/diagram/plain_yaml.h"
#include "engine/diagram/tree.h"

namespace plantloop {
namespace {

std::shared_ptr<const Source> source_of(std::string text) {
  return std::make_shared<const Source>(Source{"test.yaml", std::move(text)});
}

// The tree with all its marks, for comparisons.
std::string dump(const Node& node) {
  std::string out = fmt::format("{}@{}:{}+{}#{}{}{}", static_cast<int>(node.kind), node.mark.line, node.mark.column,
                                node.mark.length, node.offset, node.quoted ? "q" : "", node.flow ? "f" : "");
  if (node.is_scalar()) out += "'" + node.text + "'";
  for (std::size_t i = 0; i < node.items.size(); ++i) {
    out += "(";
    if (node.is_mapping()) {
      const Mark& mark = node.key_marks[i];
      out += fmt::format("{}@{}:{}+{}=", node.keys[i], mark.line, mark.column, mark.length);
    }
    out += dump(node.items[i]) + ")";
  }
  return out;
}

// A node's marks point into its source, so that has to stay.
Node read(const std::string& text) {
  static std::vector<std::shared_ptr<const Source>> kept;
  Report report;
  Node node = read_document(kept.emplace_back(source_of(text)), report);
  EXPECT_FALSE(report.has_errors()) << to_text(report);
  return node;
}

std::string errors_of(const std::string& text) {
  Report report;
  read_document(source_of(text), report);
  return to_text(report);
}

constexpr const char* plain_texts[] = {
    "a: 1\n",
    "a: 1",
    "# first\n\na: x + y # why\nb: {c: 1, d: [2, {e: 3}], f: \"q: 'r'\"}   # tail\n\n",
    "a:\n  b: 1\n  c:\n    d: 2\ne: [1, -2, (3)]\n",
    "a:\n- 1\n- {x: 2}\n- k: 3\n  l: 4\n  m:\n    n: 5\nb: 2\n",
    "a:\n  - 1\n  - 'two'\n\n  - b: {}\n    c: []\n",
    "θ: 1\n",
    "label: \"θ [rad]\"\nb: ± 2 % y\nc: θ + T.1:99\n",
    "a: http://x:3/y#z\nb: -c*v\nc: $net\nd: a:b\n",
    "a: it's\nb: {c: it's}\n",
    "a:    \n  b:   1   \n",
    "a: 1 \n  # indented comment\nb: 2\n",
    "plantloop: 1\nblocks:\n  u: {type: step, time: 1}\n  y:\n    type: integrator\n    in: u - y\n",
};

TEST(Document, ThePlainReaderGivesTheSameTreeAsTheGeneralOne) {
  for (const char* text : plain_texts) {
    const auto source = source_of(text);
    const std::optional<Node> plain = read_plain(*source);
    Report report;
    const Node general = read_general(source, report);
    EXPECT_FALSE(report.has_errors()) << to_text(report);
    if (!plain) continue;
    EXPECT_EQ(dump(*plain), dump(general)) << text;
  }
}

TEST(Document, ThePlainReaderTakesWhatDiagramsAreMadeOf) {
  const auto source = source_of(plain_texts[12]);
  EXPECT_TRUE(read_plain(*source).has_value());
}

TEST(Document, ThePlainReaderLeavesUnusualTextsToTheGeneralOne) {
  for (const char* text :
       {"a:\n", "a: &x 1\n", "a: b\n  c\n", "a: \"\\t\"\n", "a: {b: c\n }\n", "a: ~\n", "a: null\n", "---\na: 1\n",
        "a: {b: where(1, 2)}\n", "a:\t1\n", "- a\n", "a: |\n  x\n", "\"a\": 1\n", "a: 1\r\n"}) {
    EXPECT_FALSE(read_plain(*source_of(text)).has_value()) << text;
  }
}

TEST(Document, MarksCountLinesColumnsAndLengthsInCharacters) {
  const Node root = read("# θ\nlabel: \"θ [rad]\"\nθθ: {k: abc, m: 2}\n");
  EXPECT_EQ(root.items[0].mark.line, 2U);
  EXPECT_EQ(root.items[0].mark.column, 8U);
  EXPECT_EQ(root.items[0].mark.length, 9U);
  const Node& flow = root.items[1];
  EXPECT_EQ(flow.mark.column, 5U);
  EXPECT_EQ(flow.key_marks[1].column, 14U);
  EXPECT_EQ(flow.items[0].mark.column, 9U);
  EXPECT_EQ(flow.items[0].mark.length, 3U);
}

TEST(Document, ScalarsStayTexts) {
  const Node root = read("y: yes\nn: no\non: 012\noff: 1_000\n");
  EXPECT_EQ(root.keys, (std::vector<std::string>{"y", "n", "on", "off"}));
  EXPECT_EQ(root.find("y")->text, "yes");
  EXPECT_EQ(root.find("on")->text, "012");
}

TEST(Document, PlacesOfFoldedQuotedAndEscapedTextsAreExact) {
  struct Case {
    const char* text;
    std::size_t byte;
    std::uint32_t line, column;
  };
  const Case cases[] = {
      {"a: x + y\n", 4, 1, 8},
      {"a: 'x + y'\n", 4, 1, 9},
      {"a: 'it''s z'\n", 5, 1, 11},
      {"a: \"x\\t+ y\"\n", 4, 1, 10},
      {"a: \"\\u00e9 + y\"\n", 5, 1, 14},
      {"a: >\n  x +\n  y\n", 4, 3, 3},
      {"a: |-\n    x +\n    y\n", 4, 3, 5},
      {"a: x +\n   y\n", 4, 2, 4},
      {"a: \"x +\\\n   y\"\n", 3, 2, 4},
  };
  for (const Case& c : cases) {
    const Node root = read(c.text);
    const Node& scalar = root.items[0];
    const TextPlace place = text_place(scalar);
    const Mark mark = place.positions.empty() ? Mark{place.start.source, place.start.line,
                                                     place.start.column + static_cast<std::uint32_t>(c.byte), 1}
                                              : place.positions.at(c.byte);
    EXPECT_EQ(mark.line, c.line) << c.text;
    EXPECT_EQ(mark.column, c.column) << c.text;
  }
}

TEST(Document, RefusesTextsThatAreNoUtf8) {
  EXPECT_EQ(errors_of("a: \xff\n"), "test.yaml:1:4: error: this byte is no UTF-8; save the file as UTF-8\n");
  EXPECT_NE(errors_of(std::string("a: \0b\n", 6)).find("a NUL stands in the text"), std::string::npos);
  EXPECT_NE(errors_of("\xff\xfe"
                      "a")
                .find("UTF-16"),
            std::string::npos);
}

TEST(Document, ReadsAByteOrderMarkAndCarriageReturns) {
  const Node root = read(
      "\xEF\xBB\xBF"
      "a: 1\r\nb: [x,\r\n  y]\r\n");
  EXPECT_EQ(root.key_marks[0].column, 1U);
  EXPECT_EQ(root.find("b")->items[1].mark.line, 3U);
  EXPECT_EQ(root.find("b")->items[1].mark.column, 3U);
}

TEST(Document, ReferencesAreRepeatedButNotWithoutBound) {
  const Node root = read("a: &x {k: 1}\nb: *x\n");
  EXPECT_EQ(root.find("b")->find("k")->text, "1");
  std::string bomb = "a0: &a0 [x, x, x, x, x, x, x, x, x, x]\n";
  for (int i = 1; i < 12; ++i) {
    bomb += fmt::format("a{}: &a{} [", i, i);
    for (int k = 0; k < 10; ++k) bomb += fmt::format("{}*a{}", k > 0 ? ", " : "", i - 1);
    bomb += "]\n";
  }
  EXPECT_NE(errors_of(bomb).find("references repeat more than 200000 entries here"), std::string::npos);
}

TEST(Document, FindsDoubleKeysAmongMany) {
  std::string text;
  for (int i = 0; i < 5000; ++i) text += fmt::format("k{}: 1\n", i);
  text += "k17: 2\n";
  EXPECT_NE(errors_of(text).find("test.yaml:5001:1: error: the key 'k17' is written twice"), std::string::npos);
  EXPECT_NE(errors_of(text).find("test.yaml:18:1: note: first written here"), std::string::npos);
}

}  // namespace
}  // namespace plantloop
