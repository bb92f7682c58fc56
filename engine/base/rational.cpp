// Exact rational numbers on 64 bits, with 128 bits in between.

#include "engine/base/rational.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <utility>

#include "engine/base/numbers.h"
#include "engine/base/text.h"

namespace plantloop {
namespace {

__extension__ using Wide = __int128;
__extension__ using WideUnsigned = unsigned __int128;

Wide greatest_common_divisor(Wide a, Wide b) {
  if (a < 0) a = -a;
  if (b < 0) b = -b;
  while (b != 0) a = std::exchange(b, a % b);
  return a;
}

struct Terms {
  std::int64_t num = 0, den = 1;
};

std::optional<Terms> reduced(Wide num, Wide den) {
  if (den == 0) return std::nullopt;
  const Wide divisor = greatest_common_divisor(num, den) * (den < 0 ? -1 : 1);
  num /= divisor;
  den /= divisor;
  constexpr Wide limit = std::numeric_limits<std::int64_t>::max();
  if (num > limit || num < -limit || den > limit) return std::nullopt;
  return Terms{static_cast<std::int64_t>(num), static_cast<std::int64_t>(den)};
}

// num / den rounded to the nearest double, half to even.
double rounded_quotient(Wide num, std::int64_t den) {
  if (num == 0) return 0;
  constexpr Wide exact = Wide(1) << 53;
  // Both are exact as doubles: one IEEE division is the correctly rounded quotient.
  if (num <= exact && num >= -exact && den <= exact) return static_cast<double>(num) / static_cast<double>(den);
  const bool negative = num < 0;
  const WideUnsigned whole = negative ? -static_cast<WideUnsigned>(num) : static_cast<WideUnsigned>(num);
  const auto divisor = static_cast<WideUnsigned>(den);
  WideUnsigned quotient = whole / divisor;
  WideUnsigned rest = whole % divisor;
  int exponent = 0;
  // Bits are added below until 55 are there: 53, one to round on, and the last one says whether anything is left.
  while (quotient < (WideUnsigned(1) << 55)) {
    rest <<= 1;
    quotient = (quotient << 1) | (rest >= divisor ? 1U : 0U);
    if (rest >= divisor) rest -= divisor;
    --exponent;
  }
  while (quotient >= (WideUnsigned(1) << 62)) {
    rest |= quotient & 1U;  // only whether it is zero matters
    quotient >>= 1;
    ++exponent;
  }
  if (rest != 0) quotient |= 1U;
  const double magnitude = std::ldexp(static_cast<double>(static_cast<std::uint64_t>(quotient)), exponent);
  return negative ? -magnitude : magnitude;
}

}  // namespace

std::optional<Rational> Rational::make(std::int64_t num, std::int64_t den) {
  const auto terms = reduced(num, den);
  return terms ? std::optional(Rational(terms->num, terms->den)) : std::nullopt;
}

std::optional<Rational> Rational::from_text(std::string_view text) {
  const bool negative = text.starts_with('-');
  if (negative || text.starts_with('+')) text.remove_prefix(1);
  const std::size_t exponent_at = text.find_first_of("eE");
  const std::string_view digits = text.substr(0, exponent_at);
  long power = 0;
  if (exponent_at != std::string_view::npos) {
    const auto exponent = parse_integer(text.substr(exponent_at + 1));
    if (!exponent || *exponent < -40 || *exponent > 40) return std::nullopt;
    power = *exponent;
  }
  constexpr Wide limit = Wide(1) << 100;
  Wide num = 0;
  bool point = false;
  bool any = false;
  for (const char c : digits) {
    if (c == '.' && !point) {
      point = true;
      continue;
    }
    if (!is_digit(c) || num > limit) return std::nullopt;
    num = 10 * num + (c - '0');
    power -= point ? 1 : 0;
    any = true;
  }
  if (!any) return std::nullopt;
  Wide den = 1;
  for (; power > 0; --power) {
    if (num > limit) return std::nullopt;
    num *= 10;
  }
  for (; power < 0; ++power) {
    if (num != 0 && num % 10 == 0) {
      num /= 10;
      continue;
    }
    if (den > limit) return std::nullopt;
    den *= 10;
  }
  const auto terms = reduced(negative ? -num : num, den);
  return terms ? std::optional(Rational(terms->num, terms->den)) : std::nullopt;
}

double Rational::at(std::int64_t tick) const { return rounded_quotient(Wide(tick) * num_, den_); }

std::string Rational::to_string() const {
  return den_ == 1 ? fmt::format("{}", num_) : fmt::format("{}/{}", num_, den_);
}

std::optional<Rational> add(const Rational& a, const Rational& b) {
  const auto terms = reduced(Wide(a.num_) * b.den_ + Wide(b.num_) * a.den_, Wide(a.den_) * b.den_);
  return terms ? std::optional(Rational(terms->num, terms->den)) : std::nullopt;
}

std::optional<Rational> subtract(const Rational& a, const Rational& b) {
  const auto terms = reduced(Wide(a.num_) * b.den_ - Wide(b.num_) * a.den_, Wide(a.den_) * b.den_);
  return terms ? std::optional(Rational(terms->num, terms->den)) : std::nullopt;
}

std::optional<Rational> multiply(const Rational& a, const Rational& b) {
  const auto terms = reduced(Wide(a.num_) * b.num_, Wide(a.den_) * b.den_);
  return terms ? std::optional(Rational(terms->num, terms->den)) : std::nullopt;
}

std::optional<Rational> divide(const Rational& a, const Rational& b) {
  const auto terms = reduced(Wide(a.num_) * b.den_, Wide(a.den_) * b.num_);
  return terms ? std::optional(Rational(terms->num, terms->den)) : std::nullopt;
}

// gcd(a/b, c/d) = gcd(a d, c b) / (b d)
std::optional<Rational> gcd(const Rational& a, const Rational& b) {
  const Wide common = greatest_common_divisor(Wide(a.num_) * b.den_, Wide(b.num_) * a.den_);
  const auto terms = reduced(common, Wide(a.den_) * b.den_);
  return terms ? std::optional(Rational(terms->num, terms->den)) : std::nullopt;
}

int compare(const Rational& a, const Rational& b) {
  const Wide difference = Wide(a.num_) * b.den_ - Wide(b.num_) * a.den_;
  return difference < 0 ? -1 : difference > 0 ? 1 : 0;
}

}  // namespace plantloop
