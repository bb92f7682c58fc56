// Constants and the past before a record as parameters: against complex steps, other optimisers, closed forms, chance.

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <complex>

#include "identify/data/excitation.h"
#include "identify/error.h"
#include "identify/linear/filter.h"
#include "identify/linear/fit_linear.h"
#include "identify/linear/order.h"
#include "identify/linear/prediction_error.h"
#include "identify/linear/state_space.h"
#include "identify/model_file/model_file.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXcd;
using Eigen::VectorXd;
using Complex = std::complex<double>;

template <typename... T>
VectorXd numbers(T... x) {
  const double list[] = {static_cast<double>(x)...};
  return Eigen::Map<const VectorXd>(list, sizeof...(T));
}

// Numbers from -0.5 to 0.5 that any program can make.
VectorXd lcg(std::uint64_t state, Index count) {
  VectorXd x(count);
  for (double& each : x) {
    state = (1103515245 * state + 12345) % (1ULL << 31);
    each = static_cast<double>(state) / static_cast<double>(1ULL << 31) - 0.5;
  }
  return x;
}

// A process about y = 7 and u = 2 that has run for 40 samples when the record begins; with signals that any program can
// make, which are not independent of each other, or with normal ones.
DataSet running(const Orders& orders, const VectorXd& theta, Index samples, std::uint64_t seed = 1, double noise = 0.6,
                bool normal = false) {
  const Index all = samples + 40;
  const auto inputs = static_cast<Index>(orders.nb.size());
  MatrixXd u(all, inputs);
  for (Index i = 0; i < inputs; ++i) {
    const std::uint64_t own = seed + 10 * static_cast<std::uint64_t>(i);
    const VectorXd raw = 2 + 2 * (normal ? white_noise(all, 0.3, own) : lcg(own, all)).array();
    for (Index k = 0; k < all; ++k) u(k, i) = raw[k - k % 3];
  }
  PolynomialModel m = make_polynomial_model(orders, make_data_set(u, MatrixXd::Zero(all, 1), 1), 0);
  m.set_parameters(theta);
  VectorXd y =
      7 +
      filter(m.C, multiply(m.A, m.D), noise * (normal ? white_noise(all, 0.3, seed + 1) : lcg(seed + 1, all))).array();
  for (Index i = 0; i < inputs; ++i) {
    const auto which = static_cast<std::size_t>(i);
    y += filter(m.numerator(which), multiply(m.A, m.F[which]), VectorXd(u.col(i)));
  }
  return make_data_set(u.bottomRows(samples), y.tail(samples), 1);
}

const Orders oe{.nb = {2}, .nf = {2}, .delay = {0}};
const Orders armax{.na = 2, .nc = 1, .nb = {2}, .nf = {0}, .delay = {1}};
const Orders bj{.nc = 1, .nd = 1, .nb = {2}, .nf = {2}, .delay = {0}};
const VectorXd oe_theta = numbers(1, 0.5, -1.5, 0.7);
const VectorXd armax_theta = numbers(-1.5, 0.7, 1, 0.5, 0.8);
const VectorXd bj_theta = numbers(1, 0.5, 0.6, -0.8, -1.5, 0.7);

// The same criteria minimised by scipy.optimize.least_squares over all parameters and over the two values that the past
// leaves behind 1/F.
struct Reference {
  const char* name;
  Orders orders;
  VectorXd truth;
  bool offset;
  Initial initial;
  double sse;
  VectorXd theta, deviations;
};

class Optimum : public ::testing::TestWithParam<Reference> {};

TEST_P(Optimum, IsThatOfAnotherOptimiser) {
  const Reference& r = GetParam();
  const DataSet data = running(r.orders, r.truth, 90);
  const PolynomialModel m = fit_linear(data, r.orders, {.offset = r.offset, .initial = r.initial});
  EXPECT_NEAR(m.fit.reached * 90, r.sse, 1e-9 * r.sse);
  const VectorXd theta = m.parameters();
  ASSERT_EQ(theta.size(), r.theta.size());
  for (Index i = 0; i < theta.size(); ++i) {
    EXPECT_NEAR(theta[i], r.theta[i], 1e-6 * r.deviations[i]) << m.parameter_names()[static_cast<std::size_t>(i)];
    // Their Jacobian is one of differences.
    EXPECT_NEAR(std::sqrt(m.covariance(i, i)), r.deviations[i], 2e-6 * r.deviations[i]);
  }
  // The residuals are those of the fit.
  EXPECT_NEAR(residuals(m, data)[0].squaredNorm(), r.sse, 1e-9 * r.sse);
}

INSTANTIATE_TEST_SUITE_P(
    Structures, Optimum,
    ::testing::Values(
        Reference{"oe_estimate", oe, oe_theta, false, Initial::estimate, 157.9115566748,
                  numbers(1.362060351, 0.733036818, -1.376511053, 0.5670025575),
                  numbers(0.2453174, 0.3881879, 0.0468153, 0.03318047)},
        Reference{"oe_offset_rest", oe, oe_theta, true, Initial::rest, 244.722153135,
                  numbers(0.9859896423, -0.05452704032, -1.585618942, 0.7693565317, 11.79857299),
                  numbers(0.1586257, 0.1941035, 0.02438553, 0.01927926, 0.646306)},
        Reference{"oe_offset_estimate", oe, oe_theta, true, Initial::estimate, 2.819487075791,
                  numbers(0.9606865219, 0.5386428287, -1.497138825, 0.6986001772, 7.099936681),
                  numbers(0.02556909, 0.03443765, 0.003951752, 0.002984849, 0.095888)},
        Reference{"armax_estimate", armax, armax_theta, false, Initial::estimate, 4.845168982117,
                  numbers(-1.431868444, 0.5967158817, 1.160341333, 0.649146586, 0.806812518),
                  numbers(0.03162371, 0.02781462, 0.04824652, 0.05861946, 0.06665176)},
        Reference{"armax_offset_rest", armax, armax_theta, true, Initial::rest, 14.93391544822,
                  numbers(-1.699488921, 0.8836941203, 0.4601687902, -0.2491922366, 0.8630185014, 3.713711424),
                  numbers(0.04742215, 0.04584153, 0.05483813, 0.05267359, 0.05605435, 0.4003715)},
        Reference{"armax_offset_estimate", armax, armax_theta, true, Initial::estimate, 2.87823958302,
                  numbers(-1.463338877, 0.6715006567, 1.021501974, 0.4862071077, 0.7200577393, 1.551841785),
                  numbers(0.02382171, 0.02251413, 0.04346153, 0.05095283, 0.07878583, 0.2019501)},
        Reference{"bj_estimate", bj, bj_theta, false, Initial::estimate, 5.304544930849,
                  numbers(1.046605349, 0.7056092269, 0.7039676322, -0.9992829501, -1.451655299, 0.6450867489),
                  numbers(0.05157298, 0.07122741, 0.07936863, 0.01173596, 0.01542931, 0.01402012)},
        Reference{
            "bj_offset_rest", bj, bj_theta, true, Initial::rest, 14.47261754693,
            numbers(0.6736330225, 0.4037022813, 0.8112855844, -1.00121376, -1.531913721, 0.7397992247, 19.86895416),
            numbers(0.0740175, 0.0921406, 0.06556495, 0.009430251, 0.02422151, 0.02252046, 0.2693549)},
        Reference{
            "bj_offset_estimate", bj, bj_theta, true, Initial::estimate, 2.66680194022,
            numbers(0.9023125204, 0.541619416, 0.6441789027, -0.6703838087, -1.500743432, 0.706464024, 7.817373745),
            numbers(0.0422764, 0.05549405, 0.09265681, 0.09024938, 0.009802746, 0.008733105, 0.3563601)}),
    [](const auto& about) { return std::string(about.param.name); });

// The criterion once more, in complex numbers: from the sum's own minimum over the free response, continued
// analytically (transposed, not conjugated), to the parameters' imaginary steps.
VectorXcd ratio(const VectorXcd& P, const VectorXcd& Q, const VectorXcd& x) {
  VectorXcd y = VectorXcd::Zero(x.size());
  for (Index k = 0; k < x.size(); ++k) {
    for (Index i = 0; i < P.size() && i <= k; ++i) y[k] += P[i] * x[k - i];
    for (Index i = 1; i < Q.size() && i <= k; ++i) y[k] -= Q[i] * y[k - i];
  }
  return y;
}

Complex least_sum(const PolynomialModel& shape, const VectorXcd& theta, const Experiment& e) {
  const Orders o = shape.orders();
  Index at = 0;
  const auto take = [&](Index count, Index zeros, Complex head) {
    VectorXcd P = VectorXcd::Zero(zeros + 1 + count);
    P[zeros] = head;
    P.tail(count) = theta.segment(at, count);
    at += count;
    return P;
  };
  const Index samples = e.samples();
  const VectorXcd one = VectorXcd::Ones(1), A = take(o.na, 0, 1);
  std::vector<VectorXcd> B;
  for (std::size_t i = 0; i < o.nb.size(); ++i) {
    VectorXcd b = take(o.nb[i], 0, 0);  // b1 at delay 1
    VectorXcd shifted = VectorXcd::Zero(b.size() + o.delay[i]);
    for (Index j = 1; j < b.size(); ++j) shifted[j + o.delay[i]] = b[j];
    B.push_back(shifted);
  }
  const VectorXcd C = take(o.nc, 0, 1), D = take(o.nd, 0, 1);
  VectorXcd s = e.y.col(0).cast<Complex>();
  const Complex offset = shape.has_offset ? theta[theta.size() - 1] : 0;
  if (shape.initial == Initial::rest) s.array() -= offset / A.sum();
  s = ratio(A, one, s);
  if (shape.initial == Initial::estimate) s.array() -= offset;
  std::vector<VectorXcd> F;
  for (std::size_t i = 0; i < o.nb.size(); ++i) {
    F.push_back(take(o.nf[i], 0, 1));
    s -= ratio(B[i], F[i], e.u.col(static_cast<Index>(i)).cast<Complex>());
  }
  if (shape.initial == Initial::rest) {
    const VectorXcd v = ratio(D, C, s);
    return (v.transpose() * v).value();
  }
  const Index begin = first_determined(shape), count = values_of_the_past(shape, samples) - begin;
  s.head(begin).setZero();
  VectorXcd h = VectorXcd::Unit(samples, begin);
  for (const VectorXcd& f : F) h = ratio(one, f, h);
  VectorXcd v = ratio(D, C, s);
  h = ratio(D, C, h);
  if (count == 0) return (v.transpose() * v).value();
  MatrixXcd E = MatrixXcd::Zero(samples, count);
  for (Index j = 0; j < count; ++j) E.col(j).tail(samples - j) = h.head(samples - j);
  v -= E * MatrixXcd(E.transpose() * E).fullPivLu().solve(VectorXcd(E.transpose() * v));
  return (v.transpose() * v).value();
}

class GradientWithPast : public ::testing::TestWithParam<Orders> {};

TEST_P(GradientWithPast, IsThatOfAComplexStep) {
  const Orders& orders = GetParam();
  MatrixXd u(60, static_cast<Index>(orders.nb.size()));
  for (Index i = 0; i < u.cols(); ++i) u.col(i) = white_noise(60, 1, 5 + static_cast<std::uint64_t>(i));
  const DataSet data = make_data_set(u, 3 + white_noise(60, 1, 9).array(), 1);
  for (const Initial initial : {Initial::rest, Initial::estimate}) {
    for (const bool offset : {false, true}) {
      PolynomialModel m = make_polynomial_model(orders, data, 0);
      m.has_offset = offset;
      m.initial = initial;
      const VectorXd theta = white_noise(m.parameters().size(), 0.3, 17);
      m.set_parameters(theta);
      MatrixXd J;
      const VectorXd v = prediction_errors(m, data, &J);
      const VectorXcd at = theta.cast<Complex>();
      EXPECT_NEAR(v.squaredNorm(), least_sum(m, at, data.experiments[0]).real(), 1e-11 * v.squaredNorm());
      const VectorXd gradient = 2 * J.transpose() * v;
      for (Index j = 0; j < theta.size(); ++j) {
        VectorXcd moved = at;
        moved[j] += Complex(0, 1e-30);
        EXPECT_NEAR(gradient[j], least_sum(m, moved, data.experiments[0]).imag() / 1e-30,
                    1e-11 * (1 + v.norm() * J.col(j).norm()));
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Structures, GradientWithPast,
    ::testing::Values(Orders{.na = 2, .nc = 2, .nb = {2}, .nf = {0}, .delay = {1}},
                      Orders{.nb = {2}, .nf = {3}, .delay = {0}},
                      Orders{.nc = 1, .nd = 2, .nb = {2}, .nf = {2}, .delay = {2}},
                      Orders{.na = 1, .nc = 1, .nd = 1, .nb = {2, 1}, .nf = {1, 2}, .delay = {-1, 1}}),
    [](const auto& about) { return fmt::format("Number{}", about.index); });

// Records cut out of a running process say all about it, however short they are.
TEST(Offset, AndPastAreFoundExactlyWithoutNoise) {
  const Orders two{.nb = {2, 1}, .nf = {2, 1}, .delay = {0, 3}};
  const VectorXd two_theta = numbers(1, 0.5, 2, -1.5, 0.7, -0.9);
  for (const auto& [orders, theta] : {std::pair(oe, oe_theta), {two, two_theta}, {armax, armax_theta}}) {
    DataSet data = running(orders, theta, 60, 1, 0);
    data.experiments.push_back(running(orders, theta, 45, 77, 0).experiments[0]);
    const PolynomialModel m = fit_linear(data, orders, {.offset = true});
    EXPECT_EQ(m.initial, Initial::estimate);
    const Index known = orders.nc > 0 ? theta.size() - orders.nc : theta.size();  // without noise C is any
    EXPECT_LT((m.parameters().head(known) - theta.head(known)).cwiseAbs().maxCoeff(), 1e-7) << m.structure;
    EXPECT_NEAR(m.level(), 7, 1e-6);
    for (const VectorXd& v : residuals(m, data)) EXPECT_LT(v.cwiseAbs().maxCoeff(), 1e-6);
  }
  const Orders arx{.na = 2, .nb = {2}};
  const DataSet data = running(oe, oe_theta, 30, 1, 0);
  for (const PolynomialModel& m :
       {fit_linear(data, arx, {.offset = true}), fit_instrumental(data, arx, {.offset = true}),
        fit_filtered(data, arx, {.offset = true})}) {
    EXPECT_NEAR(m.level(), 7, 1e-7) << m.fit.method;
    EXPECT_NEAR(m.gain(0), 1.5 / 0.2, 1e-7);
    EXPECT_LT((simulate(m, data, Start::estimated)[0] - data.all_y()).cwiseAbs().maxCoeff(), 1e-8);
  }
}

// Without noise the passes of filtered least squares, too, find what is behind a record that begins at its level.
TEST(Offset, OfAProcessAtRestIsItsLevel) {
  const VectorXd u = white_noise(80, 1, 3);
  const VectorXd y = 5 + filter(numbers(0, 1, 0.5), numbers(1, -1.5, 0.7), u).array();
  const DataSet data = make_data_set(u, y, 1);
  const PolynomialModel filtered = fit_filtered(data, {.na = 2, .nb = {2}}, {.offset = true, .initial = Initial::rest});
  EXPECT_NEAR(filtered.offset, 5, 1e-8);
  EXPECT_LT((filtered.parameters().head(4) - oe_theta).norm(), 1e-8);
  // From rest at the level, an ARMAX model leaves nothing either.
  const PolynomialModel m = fit_linear(data, {.na = 2, .nc = 1, .nb = {2}, .nf = {0}, .delay = {0}},
                                       {.offset = true, .initial = Initial::rest});
  EXPECT_NEAR(m.level(), 5, 1e-7);
  EXPECT_LT(m.fit.reached, 1e-14);
}

// An extra column: the slope and the constant of a straight line, and their textbook deviations.
TEST(Offset, OfAFirModelIsTheConstantOfARegression) {
  const VectorXd u = numbers(1, 2, 3, 4, 5), y = numbers(2.1, 2.9, 4.2, 4.8, 6.1);
  const PolynomialModel m = fit_linear(make_data_set(u, y, 1), {.nb = {1}, .nf = {0}, .delay = {-1}}, {.offset = true});
  // sum (u - 3)^2 = 10, sum (u - 3)(y - 4.02) = 9.9; residuals 0.06, -0.13, 0.18, -0.21, 0.1.
  EXPECT_NEAR(m.B[0][0], 0.99, 1e-14);
  EXPECT_NEAR(m.offset, 4.02 - 0.99 * 3, 1e-13);
  const double s2 = (0.06 * 0.06 + 0.13 * 0.13 + 0.18 * 0.18 + 0.21 * 0.21 + 0.1 * 0.1) / 3;
  EXPECT_NEAR(m.covariance(0, 0), s2 / 10, 1e-14);
  EXPECT_NEAR(m.covariance(1, 1), s2 * (1.0 / 5 + 9.0 / 10), 1e-14);
  EXPECT_NEAR(m.covariance(0, 1), -s2 * 3 / 10, 1e-14);
  EXPECT_EQ(m.parameter_names(), (std::vector<std::string>{"b1", "offset"}));
  // A ridge shrinks the slope and leaves the line through the means.
  const PolynomialModel ridge =
      fit_linear(make_data_set(u, y, 1), {.nb = {1}, .nf = {0}, .delay = {-1}}, {.offset = true, .ridge = 10});
  EXPECT_NEAR(ridge.B[0][0], 9.9 / 20, 1e-13);
  EXPECT_NEAR(ridge.offset, 4.02 - 3 * 9.9 / 20, 1e-12);
}

// Over 400 noises the parameters scatter by what their covariance says: the mean of (theta - truth)'P^-1(theta - truth)
// is the number of parameters, with the deviation sqrt(2 p/400).
void expect_honest(const std::function<PolynomialModel(std::uint64_t)>& fit, const VectorXd& truth, const char* what) {
  double sum = 0;
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    const PolynomialModel m = fit(seed);
    const VectorXd error = m.parameters().head(truth.size()) - truth;
    sum += error.dot(m.covariance.topLeftCorner(truth.size(), truth.size()).ldlt().solve(error));
  }
  const auto p = static_cast<double>(truth.size());
  EXPECT_NEAR(sum / 400, p, 5 * std::sqrt(2 * p / 400)) << what;
}

TEST(CovarianceOfLinearModels, OfOffsetsIsWhatChanceMakes) {
  const auto data = [](const Orders& o, const VectorXd& t, std::uint64_t seed) {
    return running(o, t, 400, 1000 + 100 * seed, 0.6, true);
  };
  VectorXd oe_all(5);
  oe_all << oe_theta, 7;
  expect_honest([&](std::uint64_t s) { return fit_linear(data(oe, oe_theta, s), oe, {.offset = true}); }, oe_all, "OE");
  VectorXd armax_all(6);
  armax_all << armax_theta, 7 * 0.2;
  expect_honest([&](std::uint64_t s) { return fit_linear(data(armax, armax_theta, s), armax, {.offset = true}); },
                armax_all, "ARMAX");
}

// Filtered least squares is no maximum of likelihood. With this much noise the covariance of the last least squares,
// and that of an OE model, would be too small: 7.6 and 5.9 instead of 5.
TEST(CovarianceOfLinearModels, OfFilteredLeastSquaresIsWhatChanceMakes) {
  const auto noisy = [](const Orders& o, const VectorXd& t, std::uint64_t seed) {
    return running(o, t, 500, 1000 + 100 * seed, 10, true);
  };
  VectorXd truth(5);
  truth << oe_theta, 7;
  expect_honest(
      [&](std::uint64_t s) { return fit_filtered(noisy(oe, oe_theta, s), {.na = 2, .nb = {2}}, {.offset = true}); },
      truth, "one input");
  // Two inputs share F: b of both and F once have a regular covariance, and the second F is the first one.
  const Orders two{.nb = {2, 1}, .nf = {2, 2}, .delay = {0, 0}};
  const VectorXd two_theta = numbers(1, 0.5, -0.6, -1.5, 0.7, -1.5, 0.7);
  const VectorXd once = two_theta.head(5);
  expect_honest(
      [&](std::uint64_t s) {
        return fit_filtered(noisy(two, two_theta, s), {.na = 2, .nb = {2, 1}}, {.offset = true});
      },
      once, "two inputs");
  const PolynomialModel shared = fit_filtered(noisy(two, two_theta, 1), {.na = 2, .nb = {2, 1}}, {.offset = true});
  EXPECT_EQ(shared.covariance.block(3, 3, 2, 2), shared.covariance.block(5, 5, 2, 2));
  EXPECT_EQ(shared.covariance.block(3, 3, 2, 2), shared.covariance.block(3, 5, 2, 2));
}

TEST(Offset, ComesBackFromTheFileAndRunsInEachForm) {
  const DataSet data = running(bj, bj_theta, 120);
  const PolynomialModel m = fit_linear(data, bj, {.remove_means = true, .offset = true});
  const std::string text = to_yaml("linear_model", to_item(m));
  const PolynomialModel back = polynomial_model_of(read_model_file(text, "m.yaml"));
  EXPECT_EQ(to_yaml("linear_model", to_item(back)), text);
  EXPECT_EQ(back.parameters(), m.parameters());
  EXPECT_EQ(residuals(back, data)[0], residuals(m, data)[0]);
  EXPECT_NEAR(m.level(), m.y0 + m.offset, 1e-12);
  // Means are not the level: something is left to estimate.
  EXPECT_GT(std::fabs(m.offset), 1e-6);
  for (const Start start : {Start::zero, Start::estimated}) {
    const StateStart same = start == Start::zero ? StateStart::zero : StateStart::estimated;
    EXPECT_LT((simulate(m, data, start)[0] - simulate(to_state_space(m), data, same)[0]).cwiseAbs().maxCoeff(), 1e-9);
  }
  // One step ahead the measured output is the prediction and its error; far ahead nothing of the noise is known.
  EXPECT_LT((one_step(m, data)[0] + residuals(m, data)[0] - data.all_y()).norm(), 1e-10);
  EXPECT_LT((k_step(m, data, 120, Initial::rest)[0] - simulate(m, data, Start::zero)[0]).norm(), 1e-9);
}

// A record begins while the input has stood at 2 for long, through a delay of 12 samples: a run that is estimated from
// the first 5 outputs goes on as the process does, although what the delay holds is not in them.
TEST(Simulation, TakesInputsBeforeTheRecordAsHeld) {
  VectorXd u = VectorXd::Constant(80, 2);
  u.tail(60).setConstant(-1);
  const VectorXd all = filter((VectorXd(15) << VectorXd::Zero(13), 1, 0.5).finished(), numbers(1, -1.5, 0.7),
                              (VectorXd(380) << VectorXd::Constant(300, 2), u).finished());
  const DataSet data = make_data_set(u, all.tail(80), 1);
  PolynomialModel m = make_polynomial_model({.nb = {2}, .nf = {2}, .delay = {12}}, data, 0);
  m.set_parameters(oe_theta);
  EXPECT_LT((simulate(m, data, Start::estimated, 5)[0] - data.all_y()).cwiseAbs().maxCoeff(), 1e-9);
}

// A constant makes a ramp of what integrates: A = 1 - q^-1, y(k) = y(k-1) + 0.5 u(k-1) + 0.25.
TEST(Offset, OfAnIntegratorIsARamp) {
  const DataSet data = make_data_set(lcg(3, 30), MatrixXd::Constant(30, 1, 4), 1);
  PolynomialModel m = make_polynomial_model({.na = 1, .nb = {1}, .nf = {0}, .delay = {0}}, data, 0);
  m.has_offset = true;
  m.set_parameters(numbers(-1, 0.5, 0.25));
  EXPECT_TRUE(m.integrates());
  const VectorXd y = simulate(m, data)[0];
  double expected = 4;
  for (Index k = 1; k < 30; ++k) {
    expected += 0.5 * data.all_u()(k - 1, 0) + 0.25;
    EXPECT_NEAR(y[k], expected, 1e-13);
  }
  EXPECT_LT((simulate(to_state_space(m), data, StateStart::zero)[0].array() + 4 - y.array()).matrix().norm(), 1e-12);
}

TEST(Offset, LeavesTheSubspaceMethodUnbiased) {
  const DataSet data = running(oe, oe_theta, 150, 1, 0);
  const StateSpaceModel m = fit_subspace(data, {.order = 2, .offset = true});
  EXPECT_NEAR(m.y0[0], 7, 1e-8);
  // Its Markov parameters are the impulse response.
  const VectorXd h = impulse_response(numbers(0, 1, 0.5), numbers(1, -1.5, 0.7), 20);
  VectorXd state = m.B;
  EXPECT_NEAR(m.D(0, 0), h[0], 1e-8);
  for (Index k = 1; k < 20; ++k, state = m.A * state) EXPECT_NEAR((m.C * state).value(), h[k], 1e-8);
}

// In a table of orders the constant is one more parameter; the true structure explains all.
TEST(Offset, CountsInTablesOfOrders) {
  const DataSet data = running(oe, oe_theta, 100, 1, 0);
  const ArxTable table =
      arx_table(data, {.na_most = 2, .nb_most = 2, .delay_least = 0, .delay_most = 0}, {.offset = true});
  ASSERT_EQ(table.candidates.size(), 4U);
  EXPECT_EQ(table.candidates[3].parameters, 5);
  EXPECT_LT(table.candidates[3].sse, 1e-20);
  EXPECT_LT(table.candidates[3].simulated, 1e-9);
  const PolynomialModel one = fit_linear(part(data, 1, 100), {.na = 1, .nb = {1}}, {.offset = true});
  EXPECT_NEAR(table.candidates[0].sse, one.fit.reached * static_cast<double>(one.fit.samples), 1e-10);
  const std::vector<DelayCandidate> delays = delay_table(data, 2, 0, 1, {.offset = true});
  EXPECT_LT(delays[0].rmse, 1e-6);
  EXPECT_EQ(information_test(data, 4, 0, {.offset = true}).order, 2);
}

TEST(Offset, IsAskedForWhereItIsMissing) {
  const DataSet data = running(oe, oe_theta, 200);
  const PolynomialModel from_rest = fit_linear(data, oe);
  DataSet about_zero = data;
  about_zero.experiments[0].u.array() -= 2;
  bool start = false, constant = false;
  for (const std::string& warning : from_rest.fit.warnings) {
    start = start || warning.find(
                         "as when the record does not begin at rest: estimate its past with initial = "
                         "\"estimate\", and with offset = true where the level is not known") != std::string::npos;
  }
  for (const std::string& warning : fit_linear(about_zero, {.nb = {3}, .nf = {0}, .delay = {0}}).fit.warnings) {
    constant = constant || (warning.starts_with("the prediction errors have the mean ") &&
                            warning.ends_with(": estimate a constant, 'offset', or remove the means"));
  }
  EXPECT_TRUE(start);
  EXPECT_TRUE(constant);
  EXPECT_EQ(fit_linear(data, oe, {.offset = true}).fit.warnings, std::vector<std::string>{});
}

std::string message(const std::function<void()>& action) {
  try {
    action();
  } catch (const IdentifyError& e) {
    return e.what();
  }
  return "no error";
}

TEST(Offset, SaysWhatIsWrong) {
  const DataSet data = running(bj, bj_theta, 12);
  EXPECT_EQ(message([&] { fit_linear(data, bj, {.offset = true}); }), "no error");
  EXPECT_EQ(message([&] { fit_linear(part(data, 0, 9), bj, {.offset = true}); }),
            "9 parameters, of which 2 are of the past before the records, cannot be estimated from 9 samples");
  PolynomialModel integrator = make_polynomial_model({.na = 1, .nb = {0}, .nf = {0}, .delay = {0}}, data, 0);
  integrator.has_offset = true;
  integrator.set_parameters(numbers(-1, 0.5));
  EXPECT_EQ(message([&] { to_state_space(integrator); }),
            "the constant drives an integrator, and no input of the model could make up for it");
  std::string text = to_yaml("linear_model", to_item(fit_linear(data, oe, {.offset = true})));
  text.replace(text.find("initial: estimate"), 17, "initial: guess");
  EXPECT_NE(
      message([&] { polynomial_model_of(read_model_file(text, "m.yaml")); }).find("'initial' is rest or estimate"),
      std::string::npos);
}

}  // namespace
}  // namespace plantloop::identify
