// UTF-8 texts: validity and lengths in characters, as people count them in an editor.

#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace plantloop {

// A byte that continues a character begun before it.
constexpr bool continues_character(char c) { return (static_cast<unsigned char>(c) & 0xC0U) == 0x80U; }
constexpr bool is_digit(char c) { return c >= '0' && c <= '9'; }
constexpr bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }

// Number of characters (code points) of a valid UTF-8 text.
std::size_t count_characters(std::string_view text);
// Length in bytes of the character that begins at text[at]; 1 for a byte that begins none.
std::size_t character_length(std::string_view text, std::size_t at);
// The offset of the first byte that is no UTF-8 (overlong forms and surrogates included), or nothing.
std::optional<std::size_t> find_invalid_utf8(std::string_view text);
// The code point as UTF-8.
std::string encode_utf8(char32_t code);
// The text without control characters: each becomes a space, so that nothing printed can steer a terminal.
std::string printable(std::string_view text);
// ASCII letters, digits and underscores, no digit first.
bool is_identifier(std::string_view text);

}  // namespace plantloop
