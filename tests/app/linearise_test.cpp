// S16: plantloop linearise and plantloop trim as a user calls them: closed forms to 1e-8, and what they say to wrong
// words.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

#include "tests/app/program.h"

namespace plantloop::testing_program {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

// theta'' = -9 sin(theta) - 0.8 theta' + u, at rest where sin(theta) = u/9.
constexpr const char* pendulum = R"(plantloop: 1
parameters: {w2: 9, d: 0.8, u0: 0}
blocks:
  u: {type: constant, value: u0}
  theta: {type: integrator, in: omega, initial: 0.2}
  omega: {type: integrator, in: -w2*sin(theta) - d*omega + u}
simulation: {stop: 1}
)";

// Numbers that stand behind a key of the JSON that the program wrote, brackets ignored.
std::vector<double> numbers(const std::string& json, const std::string& key) {
  std::vector<double> found;
  std::size_t at = json.find("\"" + key + "\": ");
  if (at == std::string::npos) return found;
  at += key.size() + 4;
  int depth = 0;
  do {
    const char c = json[at];
    if (c == '[') ++depth;
    if (c == ']') --depth;
    if (c == '-' || (c >= '0' && c <= '9')) {
      char* end = nullptr;
      found.push_back(std::strtod(json.c_str() + at, &end));
      at = static_cast<std::size_t>(end - json.c_str());
      continue;
    }
    ++at;
  } while (depth > 0 && at < json.size());
  return found;
}

// The number behind a word in what the program printed.
double number_after(const std::string& text, const std::string& word) {
  const std::size_t at = text.find(word);
  return at == std::string::npos ? NAN : std::strtod(text.c_str() + at + word.size(), nullptr);
}

class S16LineariseCommand : public testing::Test {
 protected:
  S16LineariseCommand() { place_.write("pendulum.yaml", pendulum); }
  Workplace place_;
};

TEST_F(S16LineariseCommand, WritesTheMatricesOfAPendulumAtItsRest) {
  // u0 = 4.5: theta = pi/6, A = [0 1; -9 cos(pi/6) -0.8] in the order theta, omega.
  const Outcome o = place_.run("linearise pendulum.yaml --set u0=4.5 --trim --input u --output theta --out model.json");
  ASSERT_EQ(o.status, 0) << o.err;
  const std::string json = place_.read("model.json");
  EXPECT_THAT(json, HasSubstr("\"states\": [\"theta\", \"omega\"]"));
  const double k = 9 * std::cos(std::atan(1) * 4 / 6);
  const std::vector<double> A = numbers(json, "A"), B = numbers(json, "B"), C = numbers(json, "C"),
                            D = numbers(json, "D");
  ASSERT_EQ(A.size(), 4U);
  EXPECT_NEAR(A[0], 0, 1e-12);
  EXPECT_NEAR(A[1], 1, 1e-12);
  EXPECT_NEAR(A[2], -k, 1e-8);
  EXPECT_NEAR(A[3], -0.8, 1e-12);
  EXPECT_EQ(B, (std::vector<double>{0, 1}));
  EXPECT_EQ(C, (std::vector<double>{1, 0}));
  EXPECT_EQ(D, (std::vector<double>{0}));
  // The poles: -0.4 +- i sqrt(k - 0.16).
  const std::vector<double> poles = numbers(json, "poles");
  ASSERT_EQ(poles.size(), 4U);
  EXPECT_NEAR(poles[0], -0.4, 1e-8);
  EXPECT_NEAR(std::fabs(poles[1]), std::sqrt(k - 0.16), 1e-8);
}

TEST_F(S16LineariseCommand, PrintsPolesGainAndMargins) {
  place_.write("lag.yaml",
               "plantloop: 1\nblocks:\n  u: {type: constant, value: 0}\n  y: {type: transfer_function, num: [4], den: "
               "[1, 3, 3, 1], in: u}\nsimulation: {stop: 1}\n");
  const Outcome o = place_.run("linearise lag.yaml --input u --output y");
  ASSERT_EQ(o.status, 0) << o.err;
  EXPECT_NEAR(number_after(o.out, "gain at rest: "), 4, 1e-8);
  // 4/(s + 1)^3: the phase is -180 degrees at sqrt(3) rad/s, where the gain is 4/8.
  EXPECT_NEAR(number_after(o.out, "gain margin: "), 2, 1e-5);
  EXPECT_NEAR(number_after(o.out, "gain margin: 2 at "), std::sqrt(3), 1e-5);
}

TEST_F(S16LineariseCommand, WritesTheFrequencyResponse) {
  place_.write("lag.yaml",
               "plantloop: 1\nblocks:\n  u: {type: constant, value: 0}\n  y: {type: first_order, tau: 0.5, in: u}\n"
               "simulation: {stop: 1}\n");
  const Outcome o =
      place_.run("linearise lag.yaml --input u --output y --response r.csv --from 2 --to 2 --points 2 --out m.json");
  ASSERT_EQ(o.status, 0) << o.err;
  const std::string csv = place_.read("r.csv");
  const std::string row = csv.substr(csv.find('\n') + 1);  // 1/(1 + i): 1/sqrt(2) and -45 degrees
  EXPECT_NEAR(std::strtod(row.c_str() + row.find(',') + 1, nullptr), std::sqrt(0.5), 1e-12);
  EXPECT_THAT(csv, HasSubstr("frequency,magnitude of y by u,phase of y by u,real of y by u,imaginary of y by u\n"));
}

TEST_F(S16LineariseCommand, SaysWhatIsNoSignal) {
  const Outcome o = place_.run("linearise pendulum.yaml --input uu --output theta");
  EXPECT_EQ(o.status, 2);
  EXPECT_EQ(o.out, "");
  EXPECT_THAT(o.err,
              AllOf(HasSubstr("error: the input 'uu' is no signal of the diagram"), HasSubstr("did you mean 'u'?")));
}

TEST_F(S16LineariseCommand, NeedsAnInputForAFrequencyResponse) {
  const Outcome o = place_.run("linearise pendulum.yaml --response r.csv");
  EXPECT_EQ(o.status, 2);
  EXPECT_THAT(o.err, HasSubstr("plantloop: a frequency response needs --input and --output\n"));
}

TEST_F(S16LineariseCommand, SaysThatThereIsNoRest) {
  place_.write("ramp.yaml", "plantloop: 1\nblocks:\n  x: {type: integrator, in: 2}\nsimulation: {stop: 1}\n");
  const Outcome o = place_.run("linearise ramp.yaml --trim");
  EXPECT_EQ(o.status, 2);
  EXPECT_THAT(o.err, HasSubstr("error: no rest was found to linearise at: 'x' still changes by 2 per second"));
}

TEST_F(S16LineariseCommand, RefusesALibrary) {
  place_.write("types.yaml", "plantloop: 1\ntypes: {t: {inputs: [u], outputs: [y], blocks: {y: u}}}\n");
  const Outcome o = place_.run("linearise types.yaml");
  EXPECT_EQ(o.status, 2);
  EXPECT_THAT(o.err, HasSubstr("types.yaml is a library: it has types, but no blocks to linearise"));
}

using S16TrimCommand = S16LineariseCommand;

TEST_F(S16TrimCommand, FindsTheRestOfAPendulum) {
  const Outcome o = place_.run("trim pendulum.yaml --set u0=4.5");
  ASSERT_EQ(o.status, 0) << o.err;
  EXPECT_THAT(o.out, HasSubstr("at rest after "));
  EXPECT_NEAR(number_after(o.out, "theta"), std::asin(0.5), 1e-8);
  EXPECT_NEAR(number_after(o.out, "omega"), 0, 1e-8);
}

TEST_F(S16TrimCommand, MovesAnInputUntilAnOutputIsAsWanted) {
  const Outcome o = place_.run("trim pendulum.yaml --input u --output theta=0.7");
  ASSERT_EQ(o.status, 0) << o.err;
  EXPECT_NEAR(number_after(o.out, "inputs:\n  u"), 9 * std::sin(0.7), 1e-8);
}

TEST_F(S16TrimCommand, TellsWhatIsLeftWhereThereIsNoRest) {
  const Outcome o = place_.run("trim pendulum.yaml --input u --bound u=0:1 --output theta=0.7");
  EXPECT_EQ(o.status, 1);
  EXPECT_THAT(o.out, HasSubstr("NOT at rest after "));
}

TEST_F(S16TrimCommand, SaysHowItsOptionsAreWritten) {
  EXPECT_EQ(place_.run("trim pendulum.yaml --output theta").err,
            "plantloop: --output theta: it must be path=number, as in --output y=1.5\n");
  EXPECT_EQ(place_.run("trim pendulum.yaml --fix theta=x").err,
            "plantloop: --fix theta=x: it must be path=number, as in --fix y=1.5\n");
  EXPECT_EQ(place_.run("trim pendulum.yaml --bound u=3:1").err,
            "plantloop: --bound u=3:1: it must be path=lower:upper, as in --bound u=0:10\n");
  EXPECT_THAT(place_.run("trim pendulum.yaml --fix thet=1").err, HasSubstr("error: there is no state 'thet'"));
  EXPECT_EQ(place_.run("trim pendulum.yaml --bound u=3:1").status, 2);
}

}  // namespace
}  // namespace plantloop::testing_program
