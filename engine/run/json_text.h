// Numbers and texts as JSON writes them.

#pragma once

#include <string>
#include <string_view>

namespace plantloop {

// The shortest number that reads back the same; null for what is not finite.
void add_number(std::string& out, double value);
// The text in quotes, escaped where JSON asks for it.
void add_text(std::string& out, std::string_view text);

}  // namespace plantloop
