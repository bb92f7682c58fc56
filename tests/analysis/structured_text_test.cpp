// What `export` writes, interpreted, against the blocks that it was made of, sample by sample.

#include "engine/analysis/structured_text.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cctype>
#include <cmath>
#include <functional>
#include <map>
#include <stdexcept>
#include <vector>

namespace plantloop {
namespace {

using ::testing::HasSubstr;

// A strict interpreter of function blocks with LREAL variables: assignments, IF, arithmetic, comparisons and the
// standard functions. Everything else is an error, so is a variable that is read before it has a value.
class FunctionBlock {
 public:
  explicit FunctionBlock(const std::string& text) {
    read_tokens(text);
    expect("FUNCTION_BLOCK");
    name = take();
    while (peek().rfind("VAR", 0) == 0) declarations();
    begin_ = at_;
  }
  std::string name;
  std::vector<std::string> inputs, outputs;

  std::map<std::string, double> call(const std::map<std::string, double>& given) {
    for (const std::string& temporary : temporaries_) values_.erase(temporary);
    for (const auto& [input, value] : given) values_[input] = value;
    at_ = begin_;
    statements(true);
    expect("END_FUNCTION_BLOCK");
    if (at_ != tokens_.size()) throw std::runtime_error("text behind END_FUNCTION_BLOCK");
    std::map<std::string, double> result;
    for (const std::string& output : outputs) result[output] = values_.at(output);
    return result;
  }

 private:
  void read_tokens(const std::string& text) {
    for (std::size_t i = 0; i < text.size();) {
      const auto c = static_cast<unsigned char>(text[i]);
      if (std::isspace(c) != 0) {
        ++i;
      } else if (text.compare(i, 2, "(*") == 0) {
        i = text.find("*)", i) + 2;
      } else if (std::isalpha(c) != 0) {
        std::size_t end = i;
        while (end < text.size() && (std::isalnum(static_cast<unsigned char>(text[end])) != 0 || text[end] == '_'))
          ++end;
        tokens_.push_back(text.substr(i, end - i));
        i = end;
      } else if (std::isdigit(c) != 0) {
        std::size_t used = 0;
        (void)std::stod(text.substr(i), &used);
        tokens_.push_back(text.substr(i, used));
        if (tokens_.back().find('.') == std::string::npos) throw std::runtime_error("not LREAL: " + tokens_.back());
        i += used;
      } else {
        const std::string two = text.substr(i, 2);
        const bool wide = two == ":=" || two == "<=" || two == ">=" || two == "<>";
        tokens_.push_back(text.substr(i, wide ? 2 : 1));
        i += wide ? 2 : 1;
      }
    }
  }
  const std::string& peek() const { return tokens_.at(at_); }
  std::string take() { return tokens_.at(at_++); }
  bool accept(const std::string& token) {
    if (at_ < tokens_.size() && peek() == token) return ++at_, true;
    return false;
  }
  void expect(const std::string& token) {
    if (!accept(token)) throw std::runtime_error("expected " + token + ", got " + peek());
  }

  void declarations() {
    const std::string section = take();
    while (!accept("END_VAR")) {
      const std::string variable = take();
      if (!known_.insert({variable, section}).second) throw std::runtime_error("declared twice: " + variable);
      expect(":");
      expect("LREAL");
      if (accept(":=")) values_[variable] = factor();
      expect(";");
      if (section == "VAR_INPUT") inputs.push_back(variable);
      if (section == "VAR_OUTPUT") outputs.push_back(variable);
      if (section == "VAR_TEMP") temporaries_.push_back(variable);
    }
  }

  bool ends() const {
    return peek() == "END_FUNCTION_BLOCK" || peek() == "END_IF" || peek() == "ELSE" || peek() == "ELSIF";
  }
  void statements(bool run) {
    while (!ends()) {
      if (accept("IF")) {
        bool done = false;
        do {
          const bool holds = expression() != 0;
          expect("THEN");
          statements(run && holds && !done);
          done = done || holds;
        } while (accept("ELSIF"));
        if (accept("ELSE")) statements(run && !done);
        expect("END_IF");
      } else {
        const std::string target = take();
        if (known_.count(target) == 0 || known_[target] == "VAR_INPUT")
          throw std::runtime_error("cannot be assigned: " + target);
        expect(":=");
        dry_ = !run;
        const double value = expression();
        dry_ = false;
        if (run) values_[target] = value;
      }
      expect(";");
    }
  }

  // OR, AND, comparisons, sums, products, signs.
  double expression() {
    double a = conjunction();
    while (accept("OR")) a = (conjunction() != 0) || a != 0 ? 1 : 0;
    return a;
  }
  double conjunction() {
    double a = comparison();
    while (accept("AND")) a = (comparison() != 0) && a != 0 ? 1 : 0;
    return a;
  }
  double comparison() {
    const double a = sum();
    if (accept("<")) return a < sum() ? 1 : 0;
    if (accept(">")) return a > sum() ? 1 : 0;
    if (accept("<=")) return a <= sum() ? 1 : 0;
    if (accept(">=")) return a >= sum() ? 1 : 0;
    if (accept("=")) return a == sum() ? 1 : 0;
    if (accept("<>")) return a != sum() ? 1 : 0;
    return a;
  }
  double sum() {
    double a = product();
    for (;;) {
      if (accept("+")) {
        a = a + product();
      } else if (accept("-")) {
        a = a - product();
      } else {
        return a;
      }
    }
  }
  double product() {
    double a = factor();
    for (;;) {
      if (accept("*")) {
        a = a * factor();
      } else if (accept("/")) {
        a = a / factor();
      } else {
        return a;
      }
    }
  }
  double factor() {
    if (accept("-")) return -factor();
    if (accept("(")) {
      const double a = expression();
      expect(")");
      return a;
    }
    const std::string token = take();
    if (std::isdigit(static_cast<unsigned char>(token[0])) != 0) return std::stod(token);
    if (accept("(")) {
      std::vector<double> a{expression()};
      while (accept(",")) a.push_back(expression());
      expect(")");
      return function(token, a);
    }
    if (known_.count(token) == 0) throw std::runtime_error("not declared: " + token);
    if (dry_ && values_.count(token) == 0) return 0;
    if (values_.count(token) == 0) throw std::runtime_error("read before it has a value: " + token);
    return values_.at(token);
  }
  static double function(const std::string& name, const std::vector<double>& a) {
    static const std::map<std::string, std::function<double(double)>> unary{
        {"ABS", [](double x) { return std::fabs(x); }},  {"SQRT", [](double x) { return std::sqrt(x); }},
        {"EXP", [](double x) { return std::exp(x); }},   {"LN", [](double x) { return std::log(x); }},
        {"LOG", [](double x) { return std::log10(x); }}, {"SIN", [](double x) { return std::sin(x); }},
        {"COS", [](double x) { return std::cos(x); }},   {"TAN", [](double x) { return std::tan(x); }},
        {"ATAN", [](double x) { return std::atan(x); }}, {"TRUNC", [](double x) { return std::trunc(x); }}};
    if (a.size() == 1 && unary.count(name) != 0) return unary.at(name)(a[0]);
    if (a.size() == 2 && name == "MIN") return std::fmin(a[0], a[1]);
    if (a.size() == 2 && name == "MAX") return std::fmax(a[0], a[1]);
    if (a.size() == 2 && name == "EXPT") return std::pow(a[0], a[1]);
    throw std::runtime_error("no such function: " + name);
  }

  std::vector<std::string> tokens_;
  std::size_t at_ = 0, begin_ = 0;
  bool dry_ = false;
  std::map<std::string, std::string> known_;
  std::map<std::string, double> values_;
  std::vector<std::string> temporaries_;
};

std::string exported(const std::string& text, std::string* findings = nullptr, const std::string& part = "part") {
  Report report;
  const auto diagram = Diagram::from_text("plantloop: 1\n" + text, "test.yaml", report);
  const auto written =
      diagram ? structured_text(diagram->model_pointer(), {.part = part, .name = "", .set = {}}, report) : std::nullopt;
  if (findings != nullptr) {
    *findings = to_text(report);
  } else {
    EXPECT_TRUE(written) << to_text(report);
  }
  return written.value_or("");
}

// Runs the diagram, whose inputs `part.*` are sampled at its rate, and the text; the greatest difference of an output.
double difference(const std::string& text) {
  FunctionBlock block(exported(text));
  Report report;
  const auto diagram = Diagram::from_text("plantloop: 1\n" + text, "test.yaml", report);
  const auto run = diagram->run({}, report);
  EXPECT_TRUE(run) << to_text(report);
  if (!run) return 1e300;
  std::map<std::string, std::vector<double>> samples;
  const Recording& recording = run->recording;
  for (std::size_t c = 0; c < recording.columns.size(); ++c) {
    for (const std::size_t row : recording.hits.at(1))
      samples[recording.columns[c].name.substr(5)].push_back(recording.at(row, c));
  }
  const std::size_t count = samples.at(block.inputs.at(0)).size();
  EXPECT_GT(count, 50u);
  double greatest = 0;
  for (std::size_t k = 0; k < count; ++k) {
    std::map<std::string, double> in;
    for (const std::string& name : block.inputs) in[name] = samples.at(name).at(k);
    for (const auto& [name, value] : block.call(in))
      greatest = std::max(greatest, std::fabs(value - samples.at(name).at(k)));
  }
  return greatest;
}

// A blended PI controller: gains from weights over a scheduling signal, limits with an integral that tracks.
constexpr const char* blended = R"(
types:
  blended_pi:
    inputs: [w, y, h]
    blocks:
      mu: {type: gaussian_weights, in: h, centres: [1, 1.4, 1.8], widths: 0.2}
      kp: dot(mu, [1.9, 1.2, 0.4])
      u: {type: discrete_pid, in: {e: w - y, kp: kp, ki: 0.3*kp}, lower: -0.4, upper: 0.6, anti_windup: clamp}
    outputs: {u: u, gain: kp}
blocks:
  w: {type: random_levels, lower: -1, upper: 1, hold: 4, rate: 0.5}
  y: {type: random_levels, lower: -0.5, upper: 0.5, rate: 0.5}
  h: {type: random_levels, lower: 0.8, upper: 2, hold: 3, rate: 0.5}
  part: {type: blended_pi, in: {w: w, y: y, h: h}, rate: 0.5}
simulation: {stop: 100}
record: [part.w, part.y, part.h, part.u, part.gain]
)";

TEST(StructuredText, OfABlendedControllerComputesWhatTheDiagramDoes) { EXPECT_LT(difference(blended), 1e-12); }

TEST(StructuredText, OfIntegerArithmeticGivesTheSameCodes) {
  for (const char* const overflow : {"saturate", "wrap"}) {
    EXPECT_EQ(difference(std::string(R"(
types:
  small:
    inputs: [w, y]
    blocks:
      read: {type: adc, in: y, bits: 10, lower: -2, upper: 2}
      c: {type: fixed_point_pi, in: w - read.y, kp: 1.7, ki: 0.9, word_length: 12, fraction_length: 9, gain_fraction: 8,
          accumulator_length: 20, rounding: floor, anti_windup: none, overflow: )") +
                         overflow + R"(}
      out: {type: dac, in: c.u, bits: 8, lower: -4, upper: 4}
    outputs: {u: out.y, code: c.code}
blocks:
  w: {type: random_levels, lower: -2, upper: 2, hold: 4, rate: 0.25}
  y: {type: random_levels, lower: -3, upper: 3, rate: 0.25}
  part: {type: small, in: {w: w, y: y}, rate: 0.25}
simulation: {stop: 60}
record: [part.w, part.y, part.u, part.code]
)"),
              0)
        << overflow;
  }
}

TEST(StructuredText, OfFunctionsAndConditionsComputesWhatTheDiagramDoes) {
  EXPECT_LT(difference(R"(
types:
  many:
    inputs: [a]
    blocks:
      z: {type: unit_delay, in: 0.5*z + tanh(a), initial: 0.25}
      f: exp(-a^2) + sin(a)*cos(a) - sqrt(abs(a)) + log(2 + a^2) + atan(a) + cosh(a)/3 + sinh(a)
      g: round(3*a) + floor(a) - 2*ceil(a) + trunc(7*a) + sign(a) + mod(5*a, 3)
      c: where(a > 0.2 and z < 1 or a <= -1, max(a, z), min(a, -z))
    outputs: [z, f, g, c]
blocks:
  a: {type: random_levels, lower: -2, upper: 2, rate: 1}
  part: {type: many, in: a, rate: 1}
simulation: {stop: 200}
record: [part.a, part.z, part.f, part.g, part.c]
)"),
            1e-12);
}

TEST(StructuredText, MovesStatesAllAtOnce) {
  EXPECT_EQ(difference(R"(
types:
  line:
    inputs: [a]
    blocks:
      x: {type: unit_delay, in: a, initial: 3}
      w: {type: unit_delay, in: x, initial: 2}
      y: {type: unit_delay, in: w, initial: 1}
    outputs: [x, w, y]
blocks:
  a: {type: random_levels, lower: -2, upper: 2, rate: 1}
  part: {type: line, in: a, rate: 1}
simulation: {stop: 60}
record: [part.a, part.x, part.w, part.y]
)"),
            0);
}

TEST(StructuredText, SaysWhatHasNoCounterpart) {
  const auto about = [](const std::string& inside) {
    std::string findings;
    exported("types: {t: {inputs: [a], blocks: {b: " + inside +
                 "}, outputs: [b]}}\nblocks: {a: {type: random_levels, rate: 1}, part: {type: t, in: a}}\n"
                 "simulation: {stop: 3}\n",
             &findings);
    return findings;
  };
  EXPECT_THAT(
      about("{type: integrator, in: a}"),
      HasSubstr("'part.b' cannot be written as structured text: it reads a continuous state that is no input of "
                "the part"));
  EXPECT_THAT(about("{type: sample_delay, in: a, samples: 3}"), HasSubstr("is computed by more than arithmetic"));
  EXPECT_THAT(about("a + time"), HasSubstr("reads the time"));
  std::string findings;
  exported("blocks: {a: 1}\nsimulation: {stop: 1}\n", &findings, "a");
  EXPECT_THAT(findings, HasSubstr("the part 'a' is no subsystem of the diagram"));
}

}  // namespace
}  // namespace plantloop
