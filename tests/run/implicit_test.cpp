// S11: declared constraints, solved inside each evaluation or as variables of the solver (ida), against closed forms
// and published references.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <string>

#include "tests/blocks/diagrams.h"

namespace plantloop::testing_diagrams {
namespace {

TEST(S11Constraints, AreSolvedToRoundingFromTheGuessOn) {
  // y + y^3 = x, x' = -y - 3 y^3 from x = 2: y = exp(-t).
  for (const char* solver : {"dopri5", "bdf", "ida"}) {
    const Signals r = run(std::string(R"yaml(
blocks:
  x: {type: integrator, in: -y - 3*y^3, initial: 2}
  y: {type: algebraic_constraint, residual: y + y^3 - x, initial_guess: 5}
  difference: y - exp(-time)
  left_over: y + y^3 - x
simulation: {stop: 3, rtol: 1e-10, atol: 1e-12, solver: )yaml") +
                          solver + "}\n");
    EXPECT_LT(r.greatest("difference"), 2e-8) << solver;
    EXPECT_LT(r.greatest("left_over"), 1e-13) << solver;
  }
}

TEST(S11Constraints, TakeTheSolutionNearestToTheGuessAndBetweenTheBounds) {
  const auto root = [](const std::string& more) {
    return run("blocks:\n  y: {type: algebraic_constraint, residual: y^2 - 4 - time, " + more +
               "}\nsimulation: {stop: 1}\n")
        .last("y");
  };
  EXPECT_NEAR(root("initial_guess: 1"), std::sqrt(5), 1e-15);
  EXPECT_NEAR(root("initial_guess: -1"), -std::sqrt(5), 1e-15);
  EXPECT_NEAR(root("lower: -10, upper: 0"), -std::sqrt(5), 1e-15);
  EXPECT_NEAR(root("lower: 0, upper: 10"), std::sqrt(5), 1e-15);
}

TEST(S11Constraints, OfAVectorAreSolvedTogether) {
  const Signals r = run(R"yaml(
blocks:
  p: {type: algebraic_constraint, residual: "[p.1^2 + p.2^2 - 4, p.1 - p.2*time]", initial_guess: 1}
  radius: sqrt(p.1^2 + p.2^2) - 2
  slope: p.1 - time*p.2
simulation: {stop: 2}
)yaml");
  EXPECT_LT(r.greatest("radius"), 1e-15);
  EXPECT_LT(r.greatest("slope"), 1e-15);
}

TEST(S11Constraints, OfASampledPartAreFoundAtItsHits) {
  const Signals r = run(R"yaml(
blocks:
  y: {type: algebraic_constraint, residual: y^3 - 8 - time, rate: 0.5, initial_guess: 2}
simulation: {stop: 1}
)yaml");
  EXPECT_NEAR(r.at("y", 0.5), std::cbrt(8.5), 1e-15);
  EXPECT_EQ(r.at("y", 0.9), r.at("y", 0.5));
}

// Book 3.2, pH neutralisation.
std::string neutralisation(const std::string& simulation) {
  return R"yaml(
parameters:
  A1: 207
  A2: 42
  z: 11.5
  n: 0.607
  pK1: -log10(4.47e-7)
  pK2: -log10(5.62e-11)
  Cv4: 4.5860778
  Cv1: 9.5840145
  q1: 16.6
  q2: 0.55
  q30: 15.6
  Wa: [3e-3, -0.03, -3.05e-3]
  Wb: [0, 0.03, 5e-5]
blocks:
  v: {type: step, time: 100, before: q30, after: q30 + 0.5}
  q3: {type: first_order, in: v, tau: 6, initial: q30}
  h2: {type: integrator, in: (q1 - q1e)/A2, initial: 3}
  q1e: Cv1*sqrt(h2)
  h1: {type: integrator, in: (q1e + q2 + q3 - Cv4*(h1 + z)^n)/A1, initial: 14}
  xa:
    type: integrator
    in: (q1e*(Wa.1 - xa) + q2*(Wa.2 - xa) + q3*(Wa.3 - xa))/(A1*h1)
    initial: (q1*Wa.1 + q2*Wa.2 + q30*Wa.3)/(q1 + q2 + q30)
  xb:
    type: integrator
    in: (q1e*(Wb.1 - xb) + q2*(Wb.2 - xb) + q3*(Wb.3 - xb))/(A1*h1)
    initial: (q1*Wb.1 + q2*Wb.2 + q30*Wb.3)/(q1 + q2 + q30)
  pH:
    type: algebraic_constraint
    residual: xa + 10^(pH - 14) - 10^(-pH) + xb*(1 + 2*10^(pH - pK2))/(1 + 10^(pK1 - pH) + 10^(pH - pK2))
    lower: -1
    upper: 15
    initial_guess: 7
  late: {type: transport_delay, in: pH, delay: 10}
  sensor: {type: first_order, in: late, tau: 15, initial: pH}
  sample: {type: zero_order_hold, in: sensor, rate: 25}
record: [v, pH, sensor, sample]
)yaml" + simulation;
}

TEST(S11Constraints, OfTheNeutralisationHoldBothWays) {
  // Figures of the book's model, computed elsewhere: the start to 1e-6, the sensor to 2e-4.
  // The titration curve makes some hundred tolerances of one, and the two methods do not err alike.
  const std::string rest = "output_interval: 25, rtol: 1e-11, atol: 1e-14}\n";
  const Signals inside = run(neutralisation("simulation: {stop: 1100, solver: bdf, " + rest));
  const Signals whole = run(neutralisation("simulation: {stop: 1100, solver: ida, " + rest));
  EXPECT_NEAR(inside.at("pH", 0), 7.0254861, 1e-6);
  EXPECT_NEAR(inside.at("sensor", 200), 7.1829, 2e-4);
  EXPECT_NEAR(inside.last("sensor"), 7.3634, 2e-4);
  const auto one = inside.column("pH"), two = whole.column("pH");
  ASSERT_EQ(one.size(), two.size());
  for (std::size_t i = 0; i < one.size(); ++i) EXPECT_NEAR(one[i], two[i], 1e-8) << "row " << i;
  EXPECT_NEAR(inside.last("sensor"), whole.last("sensor"), 1e-8);
}

TEST(S11Constraints, OfTheChemicalAkzoNobelProblemMeetItsReference) {
  // F. Mazzia, C. Magherini, Test Set for Initial Value Problem Solvers, release 2.4, problem CHEMAKZO at t = 180.
  const std::array<double, 6> reference{0.1150794920661702,    0.1203831471567715e-2, 0.1611562887407974,
                                        0.3656156421249283e-3, 0.1708010885264404e-1, 0.4873531310307455e-2};
  for (const char* solver : {"bdf", "ida"}) {
    const Signals r = run(std::string(R"yaml(
parameters: {k1: 18.7, k2: 0.58, k3: 0.09, k4: 0.42, K: 34.4, klA: 3.3, Ks: 115.83, pCO2: 0.9, H: 737}
blocks:
  r1: k1*y1^4*sqrt(y2)
  r2: k2*y3*y4
  r3: k2/K*y1*y5
  r4: k3*y1*y4^2
  r5: k4*y6^2*sqrt(y2)
  y1: {type: integrator, in: -2*r1 + r2 - r3 - r4, initial: 0.444}
  y2: {type: integrator, in: -0.5*r1 - r4 - 0.5*r5 + klA*(pCO2/H - y2), initial: 0.00123}
  y3: {type: integrator, in: r1 - r2 + r3, initial: 0}
  y4: {type: integrator, in: -r2 + r3 - 2*r4, initial: 0.007}
  y5: {type: integrator, in: r2 - r3 + r5, initial: 0}
  y6: {type: algebraic_constraint, residual: Ks*y1*y4 - y6}
simulation: {stop: 180, rtol: 1e-9, atol: 1e-13, solver: )yaml") +
                          solver + "}\n");
    for (std::size_t i = 0; i < reference.size(); ++i) {
      const double value = r.last("y" + std::to_string(i + 1));
      EXPECT_NEAR(value / reference[i], 1, 2e-7) << solver << ", y" << i + 1;
    }
  }
}

TEST(S11Constraints, OfTheTransistorAmplifierMeetItsReference) {
  // The same test set, problem TRANSAMP at t = 0.2; the capacitors' voltages are states, the nodes' potentials
  // unknowns.
  const std::array<double, 8> reference{-0.5562145012262709e-2, 0.3006522471903042e1, 0.2849958788608128e1,
                                        0.2926422536206241e1,   0.2704617865010554e1, 0.2761837778393145e1,
                                        0.4770927631616772e1,   0.1236995868091548e1};
  for (const char* solver : {"bdf", "ida"}) {
    const Signals r = run(std::string(R"yaml(
parameters: {Ub: 6, UF: 0.026, alpha: 0.99, beta: 1e-6, R0: 1000, R: 9000, C: 1e-6}
blocks:
  Ue: {type: sine, amplitude: 0.1, frequency: 200*pi}
  g1: beta*(exp((y2 - y3)/UF) - 1)
  g2: beta*(exp((y5 - y6)/UF) - 1)
  f1: (y1 - Ue)/R0
  f2: -Ub/R + 2*y2/R - (alpha - 1)*g1
  f3: -g1 + y3/R
  f4: -Ub/R + y4/R + alpha*g1
  f5: -Ub/R + 2*y5/R - (alpha - 1)*g2
  f6: -g2 + y6/R
  f7: -Ub/R + y7/R + alpha*g2
  f8: y8/R
  w1: {type: integrator, in: -f1/C, initial: -3}
  y3: {type: integrator, in: -f3/(2*C), initial: 3}
  w2: {type: integrator, in: -f4/(3*C), initial: 3}
  y6: {type: integrator, in: -f6/(4*C), initial: 3}
  w3: {type: integrator, in: -f7/(5*C), initial: 6}
  y1: w1 + y2
  y2: {type: algebraic_constraint, residual: f1 + f2, initial_guess: 3}
  y4: w2 + y5
  y5: {type: algebraic_constraint, residual: f4 + f5, initial_guess: 3}
  y7: w3 + y8
  y8: {type: algebraic_constraint, residual: f7 + f8}
simulation: {stop: 0.2, rtol: 1e-9, atol: 1e-11, solver: )yaml") +
                          solver + "}\n");
    for (std::size_t i = 0; i < reference.size(); ++i) {
      EXPECT_NEAR(r.last("y" + std::to_string(i + 1)), reference[i], 1e-6) << solver << ", y" << i + 1;
    }
  }
}

TEST(S11Constraints, WithIdaRestartConsistentlyAfterEvents) {
  // q = sqrt(h) as a constraint; the valve shuts at t = 1 and the level stands.
  const Signals r = run(R"yaml(
blocks:
  open: {type: step, time: 1, before: 1, after: 0}
  h: {type: integrator, in: -open*q, initial: 4}
  q: {type: algebraic_constraint, residual: q^2 - h, initial_guess: 2}
  difference: h - where(time < 1, (2 - time/2)^2, 2.25)
simulation: {stop: 2, solver: ida, rtol: 1e-9, atol: 1e-11}
)yaml");
  EXPECT_LT(r.greatest("difference"), 2e-8);
}

}  // namespace
}  // namespace plantloop::testing_diagrams
