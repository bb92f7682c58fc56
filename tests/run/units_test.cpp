// S2 and S3: units are followed through expressions and blocks; known ones that differ must not meet.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "engine/graph/unit_facts.h"
#include "tests/blocks/diagrams.h"

namespace plantloop::testing_diagrams {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::string check(const std::string& body) { return findings(body + "simulation: {stop: 1}\n"); }

Unit unit(const char* text) { return std::get<Unit>(parse_unit(text)); }

TEST(S3Units, OfADataSheetFitThroughParametersWiresAndIntegrators) {
  EXPECT_THAT(check(R"(
parameters:
  U: {value: 24, unit: V}
  R: {value: 1.2, unit: Ohm}
  L: {value: 2.1e-3, unit: H}
  kt: {value: 0.052, unit: N m/A}
  J: {value: 1.6e-4, unit: kg m^2}
  friction: {value: 2e-4, unit: N m s/rad}
  tau_e: {value: L/R, unit: s}
  tau_m: {value: J*R/kt^2, unit: s}
  w0: {value: U/kt, unit: rad/s}
blocks:
  u: {type: step, time: 0.01, after: U, unit: V}
  i: {type: integrator, in: (u - R*i - kt*w)/L, unit: A}
  w: {type: integrator, in: (kt*i - friction*w)/J, unit: rad/s}
  share: w/w0
)"),
              IsEmpty());
}

TEST(S3Units, ThatDifferMustNotBeAdded) {
  EXPECT_EQ(check("parameters:\n  a: {value: 1, unit: V}\n  b: {value: 2, unit: A}\nblocks:\n  y: a + b\n"),
            "test.yaml:6:8: error: 'a' in V and 'b' in A are added\n"
            "    6 |   y: a + b\n"
            "      |        ^\n"
            "  V is m^2 kg s^-3 A^-1, A is A\n"
            "test.yaml:3:3: note: 'a' is in V\n"
            "    3 |   a: {value: 1, unit: V}\n"
            "      |   ^\n"
            "test.yaml:4:3: note: 'b' is in A\n"
            "    4 |   b: {value: 2, unit: A}\n"
            "      |   ^\n");
}

TEST(S3Units, OfOneDimensionSayWhatToWrite) {
  EXPECT_THAT(check("parameters:\n  a: {value: 1, unit: ms}\n  b: {value: 2, unit: s}\nblocks:\n  y: a + b\n"),
              AllOf(HasSubstr("'a' in ms and 'b' in s are added"), HasSubstr("write 0.001*a for a number in s")));
  EXPECT_THAT(check("parameters:\n  a: {value: 90, unit: deg}\nblocks:\n  y: {expr: a, unit: rad}\n"),
              AllOf(HasSubstr("'y' is in rad, but 'a' is in deg"), HasSubstr("write pi/180*a")));
  EXPECT_THAT(check("parameters:\n  T: {value: 20, unit: degC}\nblocks:\n  y: {expr: T, unit: K}\n"),
              HasSubstr("write T + 273.15"));
  EXPECT_THAT(check("parameters:\n  n: {value: 20, unit: rpm}\nblocks:\n  y: {expr: n, unit: rad/s}\n"),
              HasSubstr("write pi/30*n"));
  EXPECT_THAT(check("parameters:\n  v: {value: 90, unit: km/h}\nblocks:\n  y: {expr: v, unit: m/s}\n"),
              HasSubstr("numbers are never converted"));
}

TEST(S3Units, ConvertedByALiteralAreTakenAsWritten) {
  EXPECT_THAT(check("parameters:\n  a: {value: 1, unit: ms}\n  b: {value: 2, unit: s}\nblocks:\n  y: 0.001*a + b\n"),
              IsEmpty());
}

TEST(S3Units, OfTemperaturesKnowThatTheirZeroIsNotZero) {
  const std::string two =
      "parameters:\n  a: {value: 20, unit: degC}\n  b: {value: 30, unit: degC}\n  c: {value: 3, unit: K}\n";
  EXPECT_THAT(check(two + "blocks:\n  d: {expr: b - a, unit: K}\n  e: {expr: a + c, unit: degC}\n"), IsEmpty());
  EXPECT_THAT(check(two + "blocks:\n  y: a > c\n"), HasSubstr("'a' in degC and 'c' in K are compared"));
  EXPECT_THAT(check(two + "blocks:\n  y: {expr: b - a, unit: degC}\n"),
              HasSubstr("'y' is in degC, but 'b - a' is in K"));
}

TEST(S3Units, OfPortsAndParametersOfBlocksAreHeldAgainstWhatIsWritten) {
  EXPECT_THAT(check("parameters:\n  T: {value: 200, unit: ms}\nblocks:\n  y: {type: first_order, in: 1, tau: T}\n"),
              AllOf(HasSubstr("'y.tau' is in s, but 'T' is in ms"), HasSubstr("write 0.001*T")));
  EXPECT_THAT(check(R"(
blocks:
  f: {expr: 3, unit: kN}
  a: {type: t, in: {force: f}}
types:
  t: {inputs: {force: {unit: N}}, blocks: {y: force}, outputs: [y]}
)"),
              AllOf(HasSubstr("the input 'a.force' is in N, but 'f' is in kN"), HasSubstr("write 1000*f")));
}

TEST(S3Units, OfAStateAreThoseOfItsStart) {
  const std::string text =
      "parameters: {l: {value: 5, unit: mm}, v: {value: 1, unit: m/s}}\n"
      "blocks:\n  x: {type: integrator, in: v, unit: m, initial: l}\n  z: {type: integrator, in: v, initial: "
      "0.001*l}\n";
  EXPECT_THAT(check(text), AllOf(HasSubstr("'x' is in m, but it begins with a number in mm"),
                                 HasSubstr("0.001*initial would be in m"), testing::Not(HasSubstr("'z'"))));
}

TEST(S3Units, GoThroughGainsSumsProductsAndLags) {
  const std::string head =
      "parameters:\n  k: {value: 2, unit: N/m}\n  x: {value: 1, unit: m}\n  F: {value: 1, unit: N}\n  T: {value: 1, "
      "unit: s}\n";
  EXPECT_THAT(check(head + "blocks:\n  g: {type: gain, k: k, in: x}\n  s: {type: sum, in: [g, F]}\n"), IsEmpty());
  EXPECT_THAT(check(head + "blocks:\n  g: {type: gain, k: k, in: x}\n  s: {type: sum, in: [g, x]}\n"),
              AllOf(HasSubstr("in 's' 's.terms.1' in N and 's.terms.2' in m are added")));
  EXPECT_THAT(check(head + "blocks:\n  p: {type: product, in: [k, x]}\n  y: p - x\n"),
              HasSubstr("'p' in N and 'x' in m are subtracted"));
  EXPECT_THAT(check(head + "blocks:\n  v: {type: integrator, in: F}\n  y: v + x\n"),
              HasSubstr("'v' in m kg s^-1 and 'x' in m are added"));
  EXPECT_THAT(
      check(head + "blocks:\n  v: {type: integrator, in: F, unit: m}\n"),
      AllOf(HasSubstr("'v' is in m, but it changes by N in a second"), HasSubstr("what is integrated to m is in m/s")));
}

TEST(S3Units, ThatAreNotKnownAreSilentUnlessAskedFor) {
  const std::string text =
      "parameters:\n  a: {value: 1, unit: V}\n  b: 2\nblocks:\n  y: a + b + 3\nsimulation: {stop: 1}\n";
  EXPECT_THAT(findings(text), IsEmpty());
  EXPECT_THAT(findings(text + "checks: {units: note}\n"), HasSubstr("note: 'a' in V and 'b' without a unit are added"));
}

TEST(S3Units, ChangeNoNumberAndNoStructure) {
  const std::string blocks = "blocks:\n  x: {type: integrator, in: -x/T, initial: 1%}\nsimulation: {stop: 1}\n";
  const auto with = [&](std::string text, const std::string& unit) { return text.replace(text.find('%'), 1, unit); };
  const Signals plain = run("parameters:\n  T: 1\n" + with(blocks, ""));
  const Signals stated = run("parameters:\n  T: {value: 1, unit: s}\n" + with(blocks, ", unit: m"));
  EXPECT_EQ(plain.column("x"), stated.column("x"));
  EXPECT_EQ(stated.recording().columns[0].unit, "m");
}

TEST(S3Units, HaveAnAlgebra) {
  const auto known = [](const char* text) { return UnitFact::known(unit(text)); };
  const auto text = [](const UnitFact& f) { return f.is_known() ? unit_text(f.unit) : std::string("?"); };
  EXPECT_EQ(text(unit_after(Op::mul, known("V"), known("A"), {})), "W");
  EXPECT_EQ(text(unit_after(Op::div, known("m"), known("s"), {})), "m/s");
  EXPECT_EQ(text(unit_after(Op::sqrt, known("m^2/s^2"), {}, {})), "m/s");
  EXPECT_EQ(text(unit_after(Op::sqrt, known("m"), {}, {})), "?");
  EXPECT_EQ(text(unit_after(Op::pow, known("mm"), UnitFact::literal(3), {})), "1e-09 m^3");
  EXPECT_EQ(text(unit_after(Op::mul, known("m"), UnitFact::literal(2), {})), "?");
  EXPECT_EQ(text(unit_after(Op::add, known("m"), UnitFact::literal(2), {})), "m");
  EXPECT_EQ(text(unit_after(Op::sin, known("rad"), {}, {})), "1");
  EXPECT_TRUE(same_unit(unit("Hz"), unit("rad/s")));
  EXPECT_FALSE(same_unit(unit("%"), unit("1")));
}

}  // namespace
}  // namespace plantloop::testing_diagrams
