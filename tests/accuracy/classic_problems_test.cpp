// S9: diagrams of well-known test problems err no more than the same equations programmed by hand around the same
// method.
//
// The references have 15 digits: computed in 113-bit arithmetic (Radau IIA of order 13, or Gragg-Bulirsch-Stoer of
// order 18, at tolerances of 1e-21) and equal to the published ones of the Test Set for Initial Value Problem Solvers
// as far as those go.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <ostream>
#include <string>
#include <vector>

#include "engine/run/diagram.h"
#include "tests/accuracy/hand_written.h"
#include "tests/accuracy/right_sides.h"

namespace plantloop::accuracy {
namespace {

struct Problem {
  const char* name;  // of the file in problems/, and its solver
  std::vector<double> reference;
  std::function<std::vector<double>(double stop, const Tolerances&)> by_hand;
  // Of SUNDIALS programmed by hand with differenced Jacobians: the largest errors around rtol 1e-6, 1e-8 and 1e-10, in
  // tolerances, as measured with its version 6.4 by the test's own rule.
  std::vector<double> sundials = {};
};
void PrintTo(const Problem& p, std::ostream* out) { *out << p.name; }

using Method = std::vector<double> (*)(const Rates&, std::vector<double>, double, const Tolerances&);

template <typename Equations>
auto hand_written(Method method, const std::vector<double>& initial) {
  return [=](double stop, const Tolerances& tol) {
    return method([](double t, const double* x, double* rate) { Equations::template rates<double>(t, x, rate); },
                  initial, stop, tol);
  };
}

struct Oscillator {
  template <typename T>
  static void rates(T t, const T* x, T* rate) {
    rate[0] = x[1];
    rate[1] = 100 * (std::sin(3 * t) - x[0]) - 2 * x[1];
  }
};

// x'' + 2 x' + 100 x = 100 sin 3t from (1, 0).
std::vector<double> oscillator_at(double t) {
  const double p = 91, q = 6, amplitude = 100 / (p * p + q * q);  // 100 - 9, 2*3
  const double w = std::sqrt(99.0), a = 1 + q * amplitude, b = (a - 3 * p * amplitude) / w;
  const double c = std::cos(w * t), s = std::sin(w * t), e = std::exp(-t);
  return {amplitude * (p * std::sin(3 * t) - q * std::cos(3 * t)) + e * (a * c + b * s),
          amplitude * 3 * (p * std::cos(3 * t) + q * std::sin(3 * t)) + e * ((b * w - a) * c - (a * w + b) * s)};
}

// Sums of exponentials by partial fractions.
std::vector<double> stiff_linear_at(double t) {
  const double p = -100.0 / 9900, q = p / -9999, b1 = 1 - p, a1 = b1 / -99;
  return {(1 - a1 - q) * std::exp(-t) + a1 * std::exp(-100 * t) + q * std::exp(-1e4 * t),
          b1 * std::exp(-100 * t) + p * std::exp(-1e4 * t), std::exp(-1e4 * t)};
}

std::vector<Problem> problems() {
  const std::vector<double> pleiades{3, 3, -1, -3, 2, -2,   2,    3, -3, 2, 0,     0, -4, 4,
                                     0, 0, 0,  0,  0, 1.75, -1.5, 0, 0,  0, -1.25, 1, 0,  0};
  const std::vector<double> arenstorf{0.994, 0, 0, -2.00158510637908252240537862224};
  const std::vector<double> robertson_at_40{0.71582706871940509, 9.1855347645577639e-06, 0.28416374574583036};
  return {
      {"oscillator", oscillator_at(5), hand_written<Oscillator>(by_dopri5, {1, 0})},
      {"stiff_linear", stiff_linear_at(1), {}, {4.78, 8.29, 15.7}},
      {"van_der_pol_5", {-1.6012968795428539, 0.19832667633866208}, hand_written<VanDerPol<5>>(by_dopri5, {2, 0})},
      {"van_der_pol_1000", {1.706167732170465, -0.00089280970102481655}, {}, {27.2, 43.3, 55.1}},
      {"robertson", robertson_at_40, {}, {15.7, 13.6, 31.2}},
      {"robertson_long", {0.017865921142099464, 7.2747514684363186e-08, 0.98213400611038585}, {}, {17.8, 33.9, 36}},
      {"robertson_dae", robertson_at_40, {}, {4.15, 8.43, 10.2}},
      {"hires",
       {0.00073713125733255412, 0.00014424857263161597, 5.8887297409673389e-05, 0.0011756513432831255,
        0.0023863561988309493, 0.0062389682527415998, 0.002849998395185501, 0.0028500016048144992},
       {},
       {61.8, 142, 212}},
      {"oregonator", {1.0008148703185227, 1228.1785215498874, 132.05549428465045}, {}, {351, 56.3, 542}},
      {"brusselator", {0.49863707126834785, 4.5967803494520112}, hand_written<Brusselator>(by_dopri5, {1.5, 3})},
      {"pleiades",
       {0.37061391439705129,  3.2372840920572331,   -3.2225590324183233,  0.65970914557753084, 0.34255817071565798,
        1.562172101400631,    -0.70030929222124954, -3.9434375855173921,  -3.2713809739725499, 5.2250818434565442,
        -2.5906124349774695,  1.1982136933922746,   -0.24296823449358234, 1.0914492404289797,  3.4170038063143148,
        1.3545845016255012,   -2.5900655978107754,  2.0250537347142411,   -1.1558151001604491, -0.80729881702230217,
        0.59523963542087188,  -3.7412449612340085,  0.3773459685750629,   0.93868588695510789, 0.36679222272005699,
        -0.34740463538084944, 2.3449154481809369,   -1.9470204342632919},
       hand_written<Pleiades>(by_dopri5, pleiades)},
      {"arenstorf",
       {0.99399999999990884, -3.0309430229632148e-13, -4.9285365810242989e-11, -2.0015851063932702},
       hand_written<Arenstorf>(by_dopri5, arenstorf)},
      {"pollution",
       {0.056462554800227695,   0.13424841304223386,    4.1397343310994269e-09, 0.0055231402074843592,
        2.018977262302196e-07,  1.4645418634939658e-07, 0.077842491189979646,   0.32450753533960181,
        0.0074940133838804057,  1.6222931573015603e-08, 1.1358638332570748e-08, 0.0022305059757213599,
        0.00020871628828986301, 1.3969210168401578e-05, 0.0089648848568982945,  4.352846369330103e-18,
        0.0068992196962634055,  0.0001007803037365946,  1.7721465139699842e-06, 5.6829432923163925e-05},
       {},
       {9, 15.2, 25.8}},
      {"akzo_nobel",
       {0.11507949206617022, 0.0012038314715677151, 0.16115628874079742, 0.00036561564212492829, 0.017080108852644041,
        0.004873531310307455},
       {},
       {2.57, 4.81, 7.87}},
      {"transistor_amplifier",
       {-0.0055621450122616277, 3.006522471903043, 2.8499587886081288, 2.9264225362062418, 2.7046178650105547,
        2.7618377783931429, 4.7709276316167725, 1.2369958680915472},
       {},
       {50.7, 10.6, 10.6}},
  };
}

class ClassicProblem : public ::testing::TestWithParam<Problem> {};

// In units of the tolerance, the worst of all components.
double error_of(const std::vector<double>& x, const std::vector<double>& reference, const Tolerances& tol) {
  double worst = 0;
  for (std::size_t i = 0; i < x.size(); ++i)
    worst = std::max(worst, std::abs(x[i] - reference[i]) / (tol.atol + tol.rtol * std::abs(reference[i])));
  return worst;
}

TEST_P(ClassicProblem, S9ErrsNoMoreThanThreeTimesWhatTheMethodErrsByHand) {
  const Problem& problem = GetParam();
  Report report;
  const auto diagram = Diagram::load(std::string("tests/accuracy/problems/") + problem.name + ".yaml", report);
  ASSERT_NE(diagram, nullptr) << to_text(report);
  // The error at one tolerance is partly luck, for errors of different signs cancel at the end of a run: what counts is
  // the largest of neighbouring ones, three times, or what the program by hand errs somewhere in the whole range.
  const std::vector<double> decades{1e-6, 1e-8, 1e-10}, neighbours{0.4, 0.6, 0.8, 1.0, 1.25, 1.6, 2.5};
  std::vector<double> ours(3, 0), by_hand(3, 0.1);
  for (std::size_t d = 0; d < decades.size(); ++d) {
    for (const double factor : neighbours) {
      const Tolerances tol{decades[d] * factor, 1e-3 * decades[d] * factor};
      RunRequest request;
      request.rtol = tol.rtol, request.atol = tol.atol;
      const auto run = diagram->run(request, report);
      ASSERT_TRUE(run) << to_text(report);
      std::vector<double> x;
      for (std::size_t i = 0; i < run->recording.columns.size(); ++i)
        x.push_back(run->recording.at(run->recording.rows() - 1, i));
      ours[d] = std::max(ours[d], error_of(x, problem.reference, tol));
      by_hand[d] = std::max(by_hand[d], problem.by_hand
                                            ? error_of(problem.by_hand(run->options.stop, tol), problem.reference, tol)
                                            : problem.sundials[d]);
    }
  }
  const double anywhere = *std::max_element(by_hand.begin(), by_hand.end());
  for (std::size_t d = 0; d < decades.size(); ++d)
    EXPECT_LE(ours[d], std::max(3 * by_hand[d], anywhere)) << "rtol " << decades[d];
}

INSTANTIATE_TEST_SUITE_P(Problems, ClassicProblem, ::testing::ValuesIn(problems()),
                         [](const auto& about) { return std::string(about.param.name); });

}  // namespace
}  // namespace plantloop::accuracy
