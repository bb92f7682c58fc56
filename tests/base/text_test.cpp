// UTF-8: validity and lengths.

#include "engine/base/text.h"

#include <gtest/gtest.h>

namespace plantloop {
namespace {

TEST(Text, CountsCharacters) {
  EXPECT_EQ(count_characters("θ [rad]"), 7U);
  EXPECT_EQ(character_length("θx", 0), 2U);
}

TEST(Text, FindsTheFirstByteThatIsNoUtf8) {
  EXPECT_FALSE(find_invalid_utf8("a θ € 𝛼"));
  EXPECT_EQ(find_invalid_utf8("ab\xff"), 2U);
  EXPECT_EQ(find_invalid_utf8("\xC0\xAF"), 0U);          // overlong
  EXPECT_EQ(find_invalid_utf8("a\xED\xA0\x80"), 1U);     // a surrogate
  EXPECT_EQ(find_invalid_utf8("\xF4\x90\x80\x80"), 0U);  // beyond U+10FFFF
  EXPECT_EQ(find_invalid_utf8("x\xE2\x82"), 1U);         // cut
}

TEST(Text, EncodesEveryLength) {
  EXPECT_EQ(encode_utf8(0x41), "A");
  EXPECT_EQ(encode_utf8(0x3B8), "θ");
  EXPECT_EQ(encode_utf8(0x20AC), "€");
  EXPECT_EQ(encode_utf8(0x1D6FC), "𝛼");
}

TEST(Text, IdentifiersAreAscii) {
  EXPECT_TRUE(is_identifier("_a1"));
  for (const char* text : {"", "1a", "a-b", "größe", "a.b"}) EXPECT_FALSE(is_identifier(text)) << text;
}

TEST(Text, ControlCharactersAreNotPrinted) { EXPECT_EQ(printable("a\x1b[31m\tb\xC2\x9B"), "a [31m b "); }

}  // namespace
}  // namespace plantloop
