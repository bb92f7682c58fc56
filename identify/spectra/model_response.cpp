// Frequency responses of models.

#include <Eigen/LU>
#include <cmath>
#include <complex>
#include <numbers>

#include "identify/error.h"
#include "identify/spectra/spectra.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;
using Eigen::VectorXcd;
using Eigen::VectorXd;
using Complex = std::complex<double>;

// P(z^-1) at zi = z^-1 by Horner's rule.
Complex value(const VectorXd& P, Complex zi) {
  Complex sum = 0;
  for (Index i = P.size() - 1; i >= 0; --i) sum = sum * zi + P[i];
  return sum;
}

}  // namespace

VectorXd FrequencyResponse::phase() const {
  VectorXd angle(G.size());
  double before = 0;
  for (Index i = 0; i < G.size(); ++i) {
    double a = std::arg(G[i]);
    if (i > 0) a += 2 * std::numbers::pi * std::round((before - a) / (2 * std::numbers::pi));
    angle[i] = before = a;
  }
  return angle;
}

VectorXd frequencies(double from, double Ts, Index count) {
  const double to = std::numbers::pi / Ts;
  if (!(from > 0 && from < to) || count < 2) {
    fail("at least two frequencies run from above 0 to pi/Ts = {:.6g} rad/s; asked for {} from {}", to, count, from);
  }
  VectorXd w(count);
  for (Index i = 0; i < count; ++i) {
    w[i] = i + 1 == count ? to : from * std::pow(to / from, static_cast<double>(i) / static_cast<double>(count - 1));
  }
  return w;
}

FrequencyResponse frequency_response(const PolynomialModel& m, const VectorXd& w, std::size_t input) {
  if (input >= m.B.size()) fail("the model has {} inputs, there is no input {}", m.B.size(), input + 1);
  const Orders o = m.orders();
  Index b_at = o.na;
  for (std::size_t i = 0; i < input; ++i) b_at += o.nb[i];
  Index f_at = o.na + o.nc + o.nd;
  for (const int nb : o.nb) f_at += nb;
  for (std::size_t i = 0; i < input; ++i) f_at += o.nf[i];
  FrequencyResponse r{w, VectorXcd(w.size()), VectorXd(w.size()), VectorXd(w.size())};
  const VectorXd numerator = m.numerator(input);
  for (Index k = 0; k < w.size(); ++k) {
    const Complex zi = std::polar(1.0, -w[k] * m.Ts);
    const Complex A = value(m.A, zi);
    const Complex F = value(m.F[input], zi);
    const Complex G = value(numerator, zi) / (A * F);
    r.G[k] = G;
    // d log G by the parameters: real part for the magnitude, imaginary part for the phase.
    VectorXcd dlog = VectorXcd::Zero(m.covariance.rows());
    for (Index i = 1; i <= o.na; ++i) dlog[i - 1] = -std::pow(zi, i) / A;
    for (Index i = 1; i <= m.B[input].size(); ++i) {
      dlog[b_at + i - 1] = std::pow(zi, i + m.delay[input]) / (A * F) / G;
    }
    for (Index i = 1; i < m.F[input].size(); ++i) dlog[f_at + i - 1] = -std::pow(zi, i) / F;
    const VectorXd re = dlog.real();
    const VectorXd im = dlog.imag();
    r.deviation[k] = std::abs(G) * std::sqrt(std::max(0.0, re.dot(m.covariance * re)));
    r.phase_deviation[k] = std::sqrt(std::max(0.0, im.dot(m.covariance * im)));
  }
  return r;
}

FrequencyResponse frequency_response(const StateSpaceModel& m, const VectorXd& w, std::size_t input,
                                     std::size_t output) {
  const auto i = static_cast<Index>(input);
  const auto o = static_cast<Index>(output);
  if (i >= m.B.cols() || o >= m.C.rows()) {
    fail("the model has {} inputs and {} outputs, there is no input {} with output {}", m.B.cols(), m.C.rows(), i + 1,
         o + 1);
  }
  FrequencyResponse r{w, VectorXcd(w.size()), {}, {}};
  for (Index k = 0; k < w.size(); ++k) {
    const Complex z = std::polar(1.0, w[k] * m.Ts);
    const Eigen::MatrixXcd pencil = z * Eigen::MatrixXcd::Identity(m.order(), m.order()) - m.A.cast<Complex>();
    const VectorXcd x = pencil.partialPivLu().solve(m.B.col(i).cast<Complex>());
    r.G[k] = (m.C.row(o).cast<Complex>() * x)(0) + m.D(o, i);
  }
  return r;
}

}  // namespace plantloop::identify
