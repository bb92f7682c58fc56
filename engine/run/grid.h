// Times start + k interval without drift: of decimal numbers the correctly rounded ones, 0.3 and not 3 * 0.1.

#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <optional>

#include "engine/base/rational.h"

namespace plantloop {

class TimeGrid {
 public:
  TimeGrid(double start, double interval) : start_(start), interval_(interval) {
    const auto origin = Rational::from_text(fmt::format("{}", start));
    const auto step = Rational::from_text(fmt::format("{}", interval));
    if (!origin || !step) return;
    exact_start_ = origin;
    exact_interval_ = step;
  }

  double at(std::int64_t k) const {  // s
    if (exact_interval_) {
      if (exact_start_->is_zero()) return exact_interval_->at(k);
      const auto factor = Rational::make(k);
      const auto product = factor ? multiply(*exact_interval_, *factor) : std::nullopt;
      if (const auto sum = product ? add(*product, *exact_start_) : std::nullopt) return sum->to_double();
    }
    return start_ + static_cast<double>(k) * interval_;
  }

 private:
  double start_, interval_;  // s
  std::optional<Rational> exact_start_, exact_interval_;
};

}  // namespace plantloop
