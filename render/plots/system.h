// What plot types share that show a linear system: given as a transfer function or as a measured frequency response.

#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "render/error.h"
#include "render/numbers/frequency.h"
#include "render/plots/plot.h"

namespace plantloop {

// "0.35", "−12", "1.8·10⁻⁵": three digits for remarks.
inline std::string short_number(double v) {
  if (!std::isfinite(v)) return std::isnan(v) ? "?" : v > 0 ? "∞" : "−∞";
  std::string text = fmt::format("{:.3g}", v);
  if (const std::size_t e = text.find('e'); e != std::string::npos)
    text = fmt::format("{}·10^{{{}}}", text.substr(0, e), std::stoi(text.substr(e + 1)));
  return text.starts_with('-') ? "−" + text.substr(1) : text;
}

// The inputs `num`, `den`, `delay`.
struct System {
  Plot::Column num, den;
  Plot::Real delay;

  System(Plot* plot, Need need, const std::vector<std::string_view>& instead = {})
      : num(plot, "num", "the numerator's coefficients, descending powers of s", need, instead),
        den(plot, "den", "the denominator's coefficients", need, instead),
        delay(plot, "delay", 0, "dead time [s]") {}

  Transfer system(const Given& given) const {
    for (const Plot::Column* part : {&num, &den}) {
      const bool given_zero = std::all_of(given[*part].begin(), given[*part].end(), [](double c) { return c == 0; });
      if (given_zero) throw RenderError("'num' and 'den' must have a coefficient that is not zero");
      if (!std::all_of(given[*part].begin(), given[*part].end(), [](double c) { return std::isfinite(c); }))
        throw RenderError("the coefficients of 'num' and 'den' must be finite");
    }
    if (!(given[delay] >= 0) || !std::isfinite(given[delay])) throw RenderError("'delay' must be 0 or greater");
    return {given[num], given[den], given[delay]};
  }
};

// The inputs of a system, or `w`, `re`, `im`; with the frequencies between which it is shown.
struct FrequencyData : System {
  Plot::Column w, re, im;
  Plot::Real from, to;

  explicit FrequencyData(Plot* plot)
      : System(plot, Need::optional, {"w"}),
        w(plot, "w", "frequencies [rad/s] of a measured response, instead of num and den", Need::optional),
        re(plot, "re", "its real parts", Need::optional),
        im(plot, "im", "its imaginary parts", Need::optional),
        from(plot, "from", 0, "lowest frequency [rad/s]; 0: a decade below the slowest pole or zero"),
        to(plot, "to", 0, "highest frequency [rad/s]; 0: a decade above the fastest") {}

  Response response(const Given& given) const {
    if (given.has(w)) {
      check_lengths("w", given[w], "re", given[re]);
      check_lengths("w", given[w], "im", given[im]);
      return respond(given[w], given[re], given[im]);
    }
    if (!given.has(num) || !given.has(den)) throw RenderError("this needs 'num' and 'den', or 'w', 're' and 'im'");
    const auto end = [](double v) { return v > 0 ? std::optional(v) : std::nullopt; };
    return respond(system(given), end(given[from]), end(given[to]));
  }
};

}  // namespace plantloop
