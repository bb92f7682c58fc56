// UTF-8 after RFC 3629: no overlong forms, no surrogates, nothing above U+10FFFF.

#include "render/text/utf8.h"

namespace plantloop {

std::u32string from_utf8(std::string_view text) {
  std::u32string result;
  for (std::size_t i = 0; i < text.size();) {
    const auto lead = static_cast<unsigned char>(text[i++]);
    if (lead < 0x80) {
      result += static_cast<char32_t>(lead);
      continue;
    }
    const int more = lead >= 0xF0 && lead < 0xF5   ? 3
                     : lead >= 0xE0 && lead < 0xF0 ? 2
                     : lead >= 0xC2 && lead < 0xE0 ? 1
                                                   : 0;
    char32_t value = lead & (0x3Fu >> more);
    int seen = 0;
    while (seen < more && i < text.size() && (static_cast<unsigned char>(text[i]) & 0xC0) == 0x80) {
      value = (value << 6) | (static_cast<unsigned char>(text[i]) & 0x3Fu);
      ++i;
      ++seen;
    }
    const bool overlong = (more == 2 && value < 0x800) || (more == 3 && value < 0x10000);
    const bool bad = more == 0 || seen < more || overlong || value > 0x10FFFF || (value >= 0xD800 && value < 0xE000);
    result += bad ? U'\uFFFD' : value;
  }
  return result;
}

std::string to_utf8(std::u32string_view characters) {
  std::string result;
  const auto put = [&](char32_t bits) { result += static_cast<char>(bits); };
  for (const char32_t c : characters) {
    if (c < 0x80) {
      put(c);
    } else if (c < 0x800) {
      put(0xC0 | (c >> 6));
      put(0x80 | (c & 0x3F));
    } else if (c < 0x10000) {
      put(0xE0 | (c >> 12));
      put(0x80 | ((c >> 6) & 0x3F));
      put(0x80 | (c & 0x3F));
    } else {
      put(0xF0 | (c >> 18));
      put(0x80 | ((c >> 12) & 0x3F));
      put(0x80 | ((c >> 6) & 0x3F));
      put(0x80 | (c & 0x3F));
    }
  }
  return result;
}

}  // namespace plantloop
