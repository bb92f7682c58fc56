// Numbers to text and back, the same in every locale.

#include "engine/base/numbers.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <limits>

#include "engine/base/text.h"

namespace plantloop {

std::string shortest(double value) { return fmt::format("{}", value); }

std::string digits17(double value) { return fmt::format("{:.17g}", value); }

std::optional<double> parse_number(std::string_view text) {
  const bool negative = text.starts_with('-');
  if (negative || text.starts_with('+')) text.remove_prefix(1);
  const double sign = negative ? -1.0 : 1.0;
  if (text == "inf") return sign * std::numeric_limits<double>::infinity();
  // from_chars would also take "nan", "infinity" and a second sign.
  if (text.empty() || !(is_digit(text[0]) || (text[0] == '.' && text.size() > 1 && is_digit(text[1])))) {
    return std::nullopt;
  }
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (end != text.data() + text.size()) return std::nullopt;
  if (error == std::errc::result_out_of_range) {
    // Too small is zero, too large is no number; from_chars does not say which: a small one has a negative exponent
    // or leading zeros.
    const std::size_t exponent = text.find_first_of("eE");
    const bool small = exponent == std::string_view::npos ? text.starts_with("0") || text.starts_with(".")
                                                          : text.substr(exponent + 1).starts_with('-');
    return small ? std::optional<double>(sign * 0.0) : std::nullopt;
  }
  if (error != std::errc()) return std::nullopt;
  return sign * value;
}

std::optional<long> parse_integer(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  long value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (text.empty() || error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

}  // namespace plantloop
