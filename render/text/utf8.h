// UTF-8 to characters and back.

#pragma once

#include <string>
#include <string_view>

namespace plantloop {

// Bytes that are no UTF-8 become U+FFFD, one for each maximal broken part.
std::u32string from_utf8(std::string_view text);

std::string to_utf8(std::u32string_view characters);

}  // namespace plantloop
