// A condition that must hold throughout a run.

#include <fmt/format.h>
#include <string>

#include "engine/block.h"
#include "engine/block_algebra.h"

namespace plantloop {
namespace {

struct Assertion final : Block {
  static constexpr auto summary = "End the run with an error when a condition does not hold.";
  static constexpr auto details =
      "The run fails at the instant at which u falls to 0 or below: located exactly where u is continuous, else at the "
      "sample. Of a vector every element must hold. Expectations about a result stand under expect: and do not end a "
      "run.";
  static constexpr auto example = R"(
blocks:
  level: {type: first_order, in: 1, tau: 2}
  never_over: {type: assertion, in: level < 1.2, message: the tank runs over}
simulation: {stop: 10}
expect: [{signal: never_over, measure: min, value: 1}]
)";

  Input u{this, "u", {.doc = "the condition: holds while greater than 0"}};
  Text message{this, "message", {.doc = "what the error says"}};
  Output y{this, "y", {.doc = "1 where the condition holds, else 0"}};

  void outputs(Now now, Out out) const override {
    const Array holds = (now[u] > 0.0).array;
    out[y] = holds;
    std::string text = fmt::format("the assertion '{}' does not hold", now.path());
    if (!message.value().empty()) text += ": " + message.value();
    insist(now, least(holds), escaped(text));
  }

 private:
  // Braces of the message are no places for numbers.
  static std::string escaped(const std::string& text) {
    std::string out;
    for (const char c : text) out += c == '{' || c == '}' ? std::string(2, c) : std::string(1, c);
    return out;
  }
};

}  // namespace

PLANTLOOP_BLOCK(assertion, Assertion)

}  // namespace plantloop
