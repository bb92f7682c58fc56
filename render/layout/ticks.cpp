// Chooses ticks, rounds ends outwards, writes labels.

#include "render/layout/ticks.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <optional>

namespace plantloop {
namespace {

// Values beyond this are drawn as if they were this: differences stay finite. Below `smallest` all is zero.
constexpr double largest = 1e300;
constexpr double smallest = 1e-303;

double tamed(double value) {
  if (std::abs(value) < smallest) return 0;
  return std::clamp(value, -largest, largest);
}

// A step m 10^e.
struct Step {
  int mantissa = 1;
  int exponent = 0;
  double penalty = 0;  // place in the order of niceness, 0 to 1
  double size() const { return scaled(mantissa); }
  // whole 10^exponent, rounded once where ten to the exponent is exact.
  double scaled(double whole) const {
    if (exponent >= 0) return whole * std::pow(10.0, exponent);
    if (exponent >= -300) return whole / std::pow(10.0, -exponent);
    return whole / 1e300 / std::pow(10.0, -exponent - 300);
  }
};

constexpr std::array<Step, 5> decimal_steps{{{1, 0, 0}, {5, 0, 0.2}, {2, 0, 0.2}, {25, -1, 1.0}, {4, 0, 2.0}}};

// First and last multiple of the step that are labelled.
struct Choice {
  Step step;
  std::int64_t first = 0, last = 0;
  double score = -1e9;
};

constexpr std::int64_t most_intervals = 10;

double square(double x) { return x * x; }

// The score of a labelling after Talbot et al., equations 1 to 4, legibility left out. Ends beyond the data are
// forgiven more when they are wanted (`loose`).
double score(const Choice& c, double lower, double upper, double target, bool loose) {
  const double step = c.step.size();
  const double count = static_cast<double>(c.last - c.first + 1);
  const double span = upper - lower;
  const double begin = static_cast<double>(c.first) * step, end = static_cast<double>(c.last) * step;
  const double simplicity = 1 - c.step.penalty + (c.first <= 0 && c.last >= 0 ? 0.3 : 0);
  const double coverage =
      1 - 0.5 * (square((upper - end) / span) + square((lower - begin) / span)) / square(loose ? 0.2 : 0.1);
  const double ours = (count - 1) / std::max(end - begin, span);
  const double wanted = (target - 1) / span;
  const double density = 2 - std::max(ours / wanted, wanted / ours);
  return 0.25 * simplicity + 0.2 * std::max(coverage, -2.0) + 0.55 * density;
}

std::vector<Step> steps_near(double size, bool degrees) {
  std::vector<Step> result;
  if (degrees && size > 4 && size < 400) {
    for (const Step& step : {Step{90, 0, 0}, Step{45, 0, 0}, Step{180, 0, 0}, Step{30, 0, 0.9}, Step{15, 0, 0.6},
                             Step{10, 0, 0.5}, Step{5, 0, 0.4}, Step{360, 0, 0.1}, Step{20, 0, 0.7}})
      result.push_back(step);
    return result;
  }
  if (!std::isfinite(size) || size <= 0) return result;
  if (degrees && size >= 400 && size < 1e9) {
    // Whole turns: 360, 720, 1800 and ten times as much each.
    for (int e = static_cast<int>(std::floor(std::log10(size / 360))) - 1; e <= 6; ++e)
      for (const Step& step : {Step{36, e + 1, 0}, Step{72, e + 1, 0.2}, Step{18, e + 2, 0.2}}) result.push_back(step);
    return result;
  }
  const int decade = static_cast<int>(std::floor(std::log10(size)));
  for (int e = decade - 1; e <= decade + 1; ++e)
    for (Step step : decimal_steps) {
      step.exponent += e;
      result.push_back(step);
    }
  return result;
}

// The best multiples of nice steps: enclosing the ends (`loose`) or inside them.
Choice choose(double lower, double upper, double target, bool loose, bool degrees, int intervals) {
  Choice best;
  const double span = upper - lower;
  for (const Step& step : steps_near(span / std::max(target - 1, 1.0), degrees)) {
    const double size = step.size();
    if (!(size > 0) || span / size > 60) continue;
    const double a = lower / size, b = upper / size;
    const double slack = 1e-9;  // of a step: an end that is a multiple but for rounding counts as one
    if (std::abs(a) > 1e15 || std::abs(b) > 1e15) continue;
    Choice c{step, 0, 0};
    if (loose) {
      c.first = std::llround(std::floor(a + slack));
      c.last = std::llround(std::ceil(b - slack));
    } else {
      c.first = std::llround(std::ceil(a - slack));
      c.last = std::llround(std::floor(b + slack));
    }
    if (c.last - c.first > most_intervals) continue;
    if (intervals > 0) {
      // Grow to the wanted number, alternately above and below, but do not leave zero.
      if (c.last - c.first > intervals) continue;
      while (c.last - c.first < intervals) {
        const bool less_room_above = static_cast<double>(c.last) - b <= a - static_cast<double>(c.first);
        const bool upwards = c.first == 0 || (c.last != 0 && less_room_above);
        if (upwards)
          ++c.last;
        else
          --c.first;
      }
    }
    if (c.last <= c.first) continue;
    c.score = score(c, lower, upper, target, loose);
    if (c.score > best.score) best = c;
  }
  return best;
}

// The finest step with which the zeros of both axes of a twin stand at one height; none when that wastes half the
// panel.
Choice choose_level(double lower, double upper, int intervals, int below) {
  Choice best;
  const int above = intervals - below;
  if (below <= 0 || above <= 0) return best;
  const double least = std::max(-lower / below, upper / above);
  for (const Step& step : steps_near(least, false)) {
    const double size = step.size();
    if (size < least * (1 - 1e-9) || upper - lower < 0.5 * intervals * size) continue;
    if (best.score < -1e8 || size < best.step.size()) best = {step, -below, above, 0};
  }
  return best;
}

// whole 10^exponent as a plain decimal with U+2212.
std::string decimal(std::int64_t whole, int exponent) {
  std::string digits = std::to_string(std::abs(whole));
  if (whole == 0) return "0";
  if (exponent > 0) digits.append(static_cast<std::size_t>(exponent), '0');
  if (exponent < 0) {
    const auto places = static_cast<std::size_t>(-exponent);
    if (digits.size() <= places) digits.insert(0, places + 1 - digits.size(), '0');
    digits.insert(digits.size() - places, 1, '.');
    while (digits.back() == '0') digits.pop_back();
    if (digits.back() == '.') digits.pop_back();
  }
  if (whole < 0) digits = fmt::format("−{}", digits);
  return digits;
}

int decade_of(double value) { return static_cast<int>(std::floor(std::log10(value) + 1e-12)); }

// One exponent for all labels, a multiple of three, when they would be long otherwise.
int shared_exponent(double most) {
  if (most == 0) return 0;
  const int decade = decade_of(most);
  if (decade >= -2 && decade < 5) return 0;
  return 3 * static_cast<int>(std::floor(decade / 3.0));
}

// A round number to be subtracted from all labels when they share their leading digits: 0 if they do not.
std::int64_t shared_offset(const Choice& c) {
  const std::int64_t m = c.step.mantissa;
  const std::int64_t low = c.first * m, high = c.last * m;
  if ((low <= 0 && high >= 0) || std::to_string(std::max(std::abs(low), std::abs(high))).size() < 6) return 0;
  std::int64_t unit = 1;
  while (unit <= high - low) unit *= 10;
  const std::int64_t middle = low + (high - low) / 2;
  const std::int64_t offset = (middle + (middle < 0 ? -unit / 2 : unit / 2)) / unit * unit;
  const std::string kept = std::to_string(std::max(std::abs(low - offset), std::abs(high - offset)));
  return kept.size() + 2 < std::to_string(std::abs(high)).size() ? offset : 0;
}

void write_linear_labels(Ruler& ruler, const Choice& c) {
  const std::int64_t m = c.step.mantissa;
  const std::int64_t offset = shared_offset(c);
  const double most =
      c.step.scaled(static_cast<double>(std::max(std::abs(c.first * m - offset), std::abs(c.last * m - offset))));
  ruler.exponent = shared_exponent(most);
  ruler.offset = c.step.scaled(static_cast<double>(offset));
  for (std::int64_t k = c.first; k <= c.last; ++k)
    ruler.ticks.push_back(
        {c.step.scaled(static_cast<double>(k * m)), decimal(k * m - offset, c.step.exponent - ruler.exponent)});
  if (ruler.exponent != 0) ruler.note = fmt::format("×10^{{{}}}", ruler.exponent);
  if (offset == 0) return;
  const int exponent = shared_exponent(std::abs(ruler.offset)) / 3 * 3;
  const bool whole = std::abs(ruler.offset) < 1e9 && std::abs(ruler.offset) >= 1e-3;
  const std::string number = decimal(std::abs(offset), c.step.exponent - (whole ? 0 : exponent));
  ruler.note += fmt::format("{}{} {}", ruler.note.empty() ? "" : " ", offset < 0 ? "−" : "+", number);
  if (!whole) ruler.note += fmt::format("·10^{{{}}}", exponent);
}

Ruler linear(const RulerWish& wish) {
  Ruler ruler;
  double lower = tamed(wish.data_lower), upper = tamed(wish.data_upper);
  const bool empty = !(wish.data_lower <= wish.data_upper);
  if (empty) lower = 0, upper = 1;
  std::optional<double> fixed_lower, fixed_upper;
  if (wish.limits.lower && std::isfinite(*wish.limits.lower)) fixed_lower = tamed(*wish.limits.lower);
  if (wish.limits.upper && std::isfinite(*wish.limits.upper)) fixed_upper = tamed(*wish.limits.upper);
  if (fixed_lower && fixed_upper && *fixed_lower > *fixed_upper) std::swap(fixed_lower, fixed_upper);
  if (fixed_lower) lower = *fixed_lower, upper = std::max(lower, upper);
  if (fixed_upper) upper = *fixed_upper, lower = std::min(lower, upper);

  const double magnitude = std::max(std::abs(lower), std::abs(upper));
  if (upper - lower <= 1e-12 * magnitude || magnitude == 0) {
    // Nothing varies: show the value against zero, or zero in the middle.
    if (fixed_lower && fixed_upper) fixed_upper.reset();
    const double width = magnitude == 0 ? 1 : magnitude;
    if (!fixed_lower) lower = std::min(lower - (lower < 0 ? 0.2 * width : 0), lower == 0 ? -width : 0.0);
    if (!fixed_upper)
      upper = std::max(upper + (upper > 0 ? 0.2 * width : 0), upper == 0 || fixed_lower ? upper + width : 0.0);
    if (upper <= lower) upper = lower + width;
  } else if (!wish.tight) {
    const double span = upper - lower;
    // What is zero but for rounding is zero.
    if (!fixed_lower && std::abs(lower) < 1e-9 * span) lower = 0;
    if (!fixed_upper && std::abs(upper) < 1e-9 * span) upper = 0;
    if (!fixed_lower && lower > 0 && lower < 0.15 * upper) lower = 0;
    if (!fixed_upper && upper < 0 && upper > 0.15 * lower) upper = 0;
    // Lines do not run along the edge; but an angle may touch its multiple of 45 degrees.
    const double room = wish.degrees ? 0 : 0.01 * span;
    if (!fixed_lower && lower != 0) lower -= room;
    if (!fixed_upper && upper != 0) upper += room;
    lower = tamed(lower);
    upper = tamed(upper);
  }
  ruler.lower = lower;
  ruler.upper = upper;
  const double target = wish.intervals > 0 ? wish.intervals + 1 : std::clamp(wish.length / wish.spacing, 3.0, 9.0);
  if (wish.tight || (fixed_lower && fixed_upper)) {
    set_ticks(ruler, target, wish.degrees);
    return ruler;
  }
  Choice loose = choose(lower, upper, target, true, wish.degrees, wish.intervals);
  if (wish.intervals > 0 && lower < 0 && upper > 0) {
    const Choice level = choose_level(lower, upper, wish.intervals, wish.intervals_below_zero);
    if (level.score > -1e8) loose = level;
  }
  if (loose.score < -1e8) {
    set_ticks(ruler, target, wish.degrees);
    return ruler;
  }
  const double step = loose.step.size();
  if (!fixed_lower) ruler.lower = static_cast<double>(loose.first) * step;
  if (!fixed_upper) ruler.upper = static_cast<double>(loose.last) * step;
  Choice inside = loose;
  if (fixed_lower) inside.first = std::llround(std::ceil(lower / step - 1e-9));
  if (fixed_upper) inside.last = std::llround(std::floor(upper / step + 1e-9));
  write_linear_labels(ruler, inside);
  return ruler;
}

// Decades between labels: 1, 2, 5, 10, 20, ...
int nice_stride(int least) {
  for (int decade = 1;; decade *= 10)
    for (const int m : {1, 2, 5})
      if (m * decade >= least) return m * decade;
}

// Where less than two powers of ten are seen, the numbers are those of a straight axis.
void label_plainly(Ruler& ruler, double target) {
  if (ruler.ticks.size() >= 2) return;
  Ruler plain;
  plain.lower = ruler.lower;
  plain.upper = ruler.upper;
  set_ticks(plain, target, false);
  ruler.ticks = plain.ticks;
  ruler.minor.clear();
  ruler.note = plain.note;
  ruler.exponent = plain.exponent;
  ruler.offset = plain.offset;
}

Ruler logarithmic(const RulerWish& wish) {
  Ruler ruler;
  ruler.scale = Scale::log;
  double lower = std::clamp(wish.data_lower, smallest, largest), upper = std::clamp(wish.data_upper, smallest, largest);
  if (!(wish.data_lower <= wish.data_upper) || !(wish.data_upper > 0)) lower = 0.1, upper = 10;
  const auto given = [](const std::optional<double>& end) { return end && *end > 0 && std::isfinite(*end); };
  const bool fixed_lower = given(wish.limits.lower);
  bool fixed_upper = given(wish.limits.upper);
  if (fixed_lower) lower = tamed(*wish.limits.lower);
  if (fixed_upper) upper = tamed(*wish.limits.upper);
  if (fixed_lower && fixed_upper && lower > upper) std::swap(lower, upper);
  if (lower < smallest) lower = smallest;
  upper = std::max(upper, lower);
  if (upper <= lower * (1 + 1e-12)) fixed_upper = false;

  double a = std::log10(lower), b = std::log10(upper);
  const bool decades = b - a > 0.9 || b - a < 1e-9;
  const double slack = 1e-9;
  if (b - a < 1e-9) a -= fixed_lower ? 0 : 0.5, b += 0.5;
  if (decades && !wish.tight) {
    if (!fixed_lower) a = std::floor(a + slack);
    if (!fixed_upper) b = std::ceil(b - slack);
  } else if (!wish.tight) {
    // Less than a decade: end at a whole multiple of a power of ten.
    const auto round_out = [&](double v, bool up) {
      const double decade = std::floor(v + slack), m = std::pow(10.0, v - decade);
      return decade + std::log10(up ? std::ceil(m - slack) : std::floor(m + slack));
    };
    if (!fixed_lower) a = round_out(a, false);
    if (!fixed_upper) b = round_out(b, true);
  }
  ruler.lower = fixed_lower ? lower : std::pow(10.0, a);
  ruler.upper = fixed_upper ? upper : std::pow(10.0, b);
  const int first = static_cast<int>(std::floor(a + slack)), last = static_cast<int>(std::ceil(b - slack));
  const double target = std::clamp(wish.length / wish.spacing, 3.0, 9.0);
  const int stride = nice_stride(static_cast<int>(std::ceil((b - a) / target)));
  const bool few = std::floor(b + slack) - std::ceil(a - slack) < 2;
  // Between fewer than three powers of ten also 2 and 5 are labelled, and all the others, where there is room between
  // them.
  const double decade = wish.length / (b - a);
  const bool rare = std::log10(2.0) * decade > wish.gap;
  const bool dense = b - a < 0.7 && std::log10(10.0 / 9) * decade > wish.gap;
  const auto power = [](int m, int e) { return e >= 0 ? m * std::pow(10.0, e) : m / std::pow(10.0, -e); };
  for (int e = first - 1; e <= last; ++e) {
    for (int m = 1; m < 10; ++m) {
      const double value = e < -300 ? m * std::pow(10.0, e) : power(m, e);
      if (value < ruler.lower * (1 - slack) || value > ruler.upper * (1 + slack)) continue;
      const bool labelled =
          few ? m == 1 || (rare && (m == 2 || m == 5)) || dense : m == 1 && ((e % stride) + stride) % stride == 0;
      if (labelled && few) {
        const bool plain = e >= -4 && e < 6;
        ruler.ticks.push_back({value, plain ? decimal(m, e) : fmt::format("{}·10^{{{}}}", m, e)});
      } else if (labelled) {
        ruler.ticks.push_back({value, fmt::format("10^{{{}}}", e)});
      } else if (stride == 1 || (m == 1 && stride <= 10)) {
        ruler.minor.push_back(value);
      }
    }
  }
  label_plainly(ruler, target);
  return ruler;
}

// Straight within the threshold, one unit to the decade beyond it.
double bent(double value, double threshold) {
  const double size = std::abs(value) / threshold;
  if (size <= 1) return value / threshold;
  return std::copysign(1 + std::log10(size), value);
}

Ruler symmetric(const RulerWish& wish) {
  Ruler ruler;
  ruler.scale = Scale::symlog;
  double lower = tamed(wish.data_lower), upper = tamed(wish.data_upper);
  if (!(wish.data_lower <= wish.data_upper)) lower = -1, upper = 1;
  const auto given = [](const std::optional<double>& end) { return end && std::isfinite(*end); };
  const bool fixed_lower = given(wish.limits.lower), fixed_upper = given(wish.limits.upper);
  if (fixed_lower) lower = tamed(*wish.limits.lower);
  if (fixed_upper) upper = tamed(*wish.limits.upper);
  if (lower > upper) std::swap(lower, upper);
  double most = std::max(std::abs(lower), std::abs(upper));
  if (!(most > 0)) most = 1;
  const int decade = decade_of(most);
  // Four decades on the larger side are mostly what is wanted.
  ruler.threshold = wish.threshold > 0 && std::isfinite(wish.threshold) ? tamed(wish.threshold)
                                                                        : std::pow(10.0, std::max(decade - 3, -300));
  ruler.threshold = std::max(ruler.threshold, smallest);
  const double c = ruler.threshold;
  const auto outward = [&](double v) {
    if (v == 0) return v;
    const double power = std::pow(10.0, std::ceil(std::log10(std::abs(v) / c) - 1e-9));
    return std::copysign(std::max(c, std::min(c * power, 1e3 * largest)), v);
  };
  ruler.lower = fixed_lower ? lower : outward(std::min(lower, 0.0));
  ruler.upper = fixed_upper ? upper : outward(std::max(upper, 0.0));
  if (!(ruler.lower < ruler.upper)) ruler.upper = ruler.lower + std::max(c, std::abs(ruler.lower));
  const double span = bent(ruler.upper, c) - bent(ruler.lower, c);
  const double target = std::clamp(wish.length / wish.spacing, 3.0, 9.0);
  const int stride = nice_stride(static_cast<int>(std::ceil(span / target)));
  const int first = static_cast<int>(std::ceil(std::log10(c) - 1e-9));
  for (int sign : {-1, 1}) {
    std::vector<Tick> side;
    for (int k = 0; k < 640; ++k) {
      const int e = first + k;
      const double value = sign * std::pow(10.0, e);
      if (!std::isfinite(value) ||
          std::abs(value) > std::max(std::abs(ruler.lower), std::abs(ruler.upper)) * (1 + 1e-9))
        break;
      const double slack = 1e-9 * std::abs(value);
      if (value < ruler.lower - slack || value > ruler.upper + slack) continue;
      // Beside zero there must be room.
      const bool near_zero = std::abs(bent(value, c)) / span * wish.length < wish.gap;
      if (k % stride == 0 && !near_zero)
        side.push_back({value, fmt::format("{}10^{{{}}}", sign < 0 ? "−" : "", e)});
      else if (stride == 1)
        ruler.minor.push_back(value);
    }
    if (sign < 0) {
      std::reverse(side.begin(), side.end());
      ruler.ticks = std::move(side);
      if (ruler.lower <= 0 && ruler.upper >= 0) ruler.ticks.push_back({0, "0"});
    } else {
      ruler.ticks.insert(ruler.ticks.end(), side.begin(), side.end());
    }
  }
  label_plainly(ruler, target);
  return ruler;
}

}  // namespace

void set_ticks(Ruler& ruler, double target, bool degrees) {
  ruler.ticks.clear();
  ruler.note.clear();
  ruler.exponent = 0;
  ruler.offset = 0;
  const Choice choice = choose(ruler.lower, ruler.upper, target, false, degrees, 0);
  if (choice.score > -1e8) write_linear_labels(ruler, choice);
}

Ruler make_ruler(const RulerWish& wish) {
  Ruler ruler = wish.scale == Scale::log      ? logarithmic(wish)
                : wish.scale == Scale::symlog ? symmetric(wish)
                                              : linear(wish);
  if (!wish.named) return ruler;
  ruler.named = true;
  ruler.ticks.clear();
  ruler.minor.clear();
  ruler.note.clear();
  int count = 0;
  for (const AxisTick& tick : *wish.named) {
    const double at = position(ruler, tick.at);
    if (!(at >= -1e-9 && at <= 1 + 1e-9)) continue;
    if (count++ % wish.every == 0) ruler.ticks.push_back({tick.at, tick.label});
  }
  return ruler;
}

double position(const Ruler& ruler, double value) {
  // Ticks may lie a little beyond `largest`, and differences must stay finite.
  if (ruler.scale == Scale::linear)
    return (std::clamp(value, -1e3 * largest, 1e3 * largest) - ruler.lower) / (ruler.upper - ruler.lower);
  if (ruler.scale == Scale::symlog) {
    const double low = bent(ruler.lower, ruler.threshold);
    return (bent(value, ruler.threshold) - low) / (bent(ruler.upper, ruler.threshold) - low);
  }
  if (!(value > 0)) return std::numeric_limits<double>::quiet_NaN();
  const double a = std::log10(ruler.lower);
  return (std::log10(value) - a) / (std::log10(ruler.upper) - a);
}

}  // namespace plantloop
