// Exact rational numbers, for periods and offsets: the n-th hit of a clock is one correctly rounded number.

#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace plantloop {

// num/den in lowest terms, den > 0. Operations give nothing when the result does not fit 64 bits.
class Rational {
 public:
  constexpr Rational() = default;
  // Nothing when den is 0 or the reduced numbers do not fit.
  static std::optional<Rational> make(std::int64_t num, std::int64_t den = 1);
  // "0.1", "-12", "1e-3", "2.5E2"; nothing for any other text, and when it does not fit.
  static std::optional<Rational> from_text(std::string_view text);

  std::int64_t num() const { return num_; }
  std::int64_t den() const { return den_; }
  bool is_zero() const { return num_ == 0; }
  bool is_negative() const { return num_ < 0; }

  double to_double() const { return at(1); }  // correctly rounded
  double at(std::int64_t tick) const;         // tick * num / den, correctly rounded (half to even)
  std::string to_string() const;              // "1/3", "5"

  friend std::optional<Rational> add(const Rational& a, const Rational& b);
  friend std::optional<Rational> subtract(const Rational& a, const Rational& b);
  friend std::optional<Rational> multiply(const Rational& a, const Rational& b);
  friend std::optional<Rational> divide(const Rational& a, const Rational& b);  // nothing when b is 0
  // The greatest number that both are whole multiples of: the base period of two rates. Not negative.
  friend std::optional<Rational> gcd(const Rational& a, const Rational& b);
  // Negative, zero or positive as a is less than, equal to or greater than b.
  friend int compare(const Rational& a, const Rational& b);
  friend bool operator==(const Rational& a, const Rational& b) = default;
  friend bool operator<(const Rational& a, const Rational& b) { return compare(a, b) < 0; }

 private:
  constexpr Rational(std::int64_t num, std::int64_t den) : num_(num), den_(den) {}
  std::int64_t num_ = 0;
  std::int64_t den_ = 1;
};

std::optional<Rational> add(const Rational& a, const Rational& b);
std::optional<Rational> subtract(const Rational& a, const Rational& b);
std::optional<Rational> multiply(const Rational& a, const Rational& b);
std::optional<Rational> divide(const Rational& a, const Rational& b);
std::optional<Rational> gcd(const Rational& a, const Rational& b);
int compare(const Rational& a, const Rational& b);

}  // namespace plantloop
