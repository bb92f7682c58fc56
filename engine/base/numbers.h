// Numbers to text and back, the same in every locale.

#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace plantloop {

// The shortest text that reads back as the same number: "0.1", "1e-09", "inf", "nan".
std::string shortest(double value);
// 17 significant digits, as CSV files hold them: "0.10000000000000001".
std::string digits17(double value);
// The number that the whole text is: decimal with optional sign and exponent, or inf. Nothing for any other text.
std::optional<double> parse_number(std::string_view text);
// The integer that the whole text is; nothing for any other text and beyond 64 bits.
std::optional<long> parse_integer(std::string_view text);

}  // namespace plantloop
