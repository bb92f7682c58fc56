// Linear models with polynomials in the delay operator: parameters, predictions.

#include "identify/linear/polynomial_model.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "identify/data/matching.h"
#include "identify/error.h"
#include "identify/linear/filter.h"
#include "identify/linear/prediction_error.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

VectorXd monic(int order) { return VectorXd::Unit(order + 1, 0); }

// Input i of an experiment, about the operating point.
VectorXd input(const PolynomialModel& m, const Experiment& e, std::size_t i) {
  return e.u.col(static_cast<Index>(i)).array() - m.u0[static_cast<Index>(i)];
}

VectorXd innovations(const PolynomialModel& m, const Experiment& e, std::size_t output, Initial initial) {
  Experiment about = e;
  about.u.rowwise() -= m.u0.transpose();
  about.y.col(static_cast<Index>(output)).array() -= m.y0;
  return errors_of(m, about, output, initial, nullptr);
}

}  // namespace

int Orders::parameters() const {
  return na + nc + nd + std::accumulate(nb.begin(), nb.end(), 0) + std::accumulate(nf.begin(), nf.end(), 0);
}

int Orders::longest_lag() const {
  int most = na;
  for (std::size_t i = 0; i < nb.size(); ++i) most = std::max(most, nb[i] + delay[i]);
  return most;
}

Orders PolynomialModel::orders() const {
  Orders o{
      static_cast<int>(A.size()) - 1, static_cast<int>(C.size()) - 1, static_cast<int>(D.size()) - 1, {}, {}, delay};
  for (const VectorXd& b : B) o.nb.push_back(static_cast<int>(b.size()));
  for (const VectorXd& f : F) o.nf.push_back(static_cast<int>(f.size()) - 1);
  return o;
}

PolynomialModel make_polynomial_model(const Orders& orders, const DataSet& data, std::size_t output) {
  PolynomialModel m;
  m.inputs = data.inputs;
  m.output = data.outputs.at(output);
  m.Ts = data.Ts;
  m.A = monic(orders.na);
  m.C = monic(orders.nc);
  m.D = monic(orders.nd);
  for (const int nb : orders.nb) m.B.emplace_back(VectorXd::Zero(nb));
  for (const int nf : orders.nf) m.F.push_back(monic(nf));
  m.delay = orders.delay;
  m.u0 = VectorXd::Zero(static_cast<Index>(data.inputs.size()));
  m.covariance = Eigen::MatrixXd::Zero(orders.parameters(), orders.parameters());
  return m;
}

VectorXd PolynomialModel::parameters() const {
  VectorXd theta(orders().parameters() + (has_offset ? 1 : 0));
  Index at = 0;
  const auto put = [&](const auto& part) {
    theta.segment(at, part.size()) = part;
    at += part.size();
  };
  put(A.tail(A.size() - 1));
  for (const VectorXd& b : B) put(b);
  put(C.tail(C.size() - 1));
  put(D.tail(D.size() - 1));
  for (const VectorXd& f : F) put(f.tail(f.size() - 1));
  if (has_offset) theta[at] = offset;
  return theta;
}

void PolynomialModel::set_parameters(const VectorXd& theta) {
  Index at = 0;
  const auto take = [&](VectorXd& polynomial, Index skip) {
    const Index size = polynomial.size() - skip;
    polynomial.tail(size) = theta.segment(at, size);
    at += size;
  };
  take(A, 1);
  for (VectorXd& b : B) take(b, 0);
  take(C, 1);
  take(D, 1);
  for (VectorXd& f : F) take(f, 1);
  if (has_offset) offset = theta[at];
}

std::vector<std::string> PolynomialModel::parameter_names() const {
  std::vector<std::string> names;
  const auto put = [&](char letter, Index count, const std::string& ending) {
    for (Index i = 1; i <= count; ++i) names.push_back(fmt::format("{}{}{}", letter, i, ending));
  };
  const auto ending = [&](std::size_t i) { return B.size() > 1 ? fmt::format(".{}", i + 1) : std::string(); };
  put('a', A.size() - 1, "");
  for (std::size_t i = 0; i < B.size(); ++i) put('b', B[i].size(), ending(i));
  put('c', C.size() - 1, "");
  put('d', D.size() - 1, "");
  for (std::size_t i = 0; i < F.size(); ++i) put('f', F[i].size() - 1, ending(i));
  if (has_offset) names.emplace_back("offset");
  return names;
}

VectorXd PolynomialModel::numerator(std::size_t i) const {
  VectorXd full = VectorXd::Zero(B[i].size() + delay[i] + 1);
  full.tail(B[i].size()) = B[i];
  return full;
}

PolynomialModel::Common PolynomialModel::common() const {
  Common c;
  c.denominator = A;
  for (std::size_t i = 0; i < B.size(); ++i) {
    c.denominator = multiply(c.denominator, F[i]);
    VectorXd numerator = this->numerator(i);
    for (std::size_t j = 0; j < F.size(); ++j) {
      if (j != i) numerator = multiply(numerator, F[j]);
    }
    c.numerators.push_back(std::move(numerator));
  }
  return c;
}

bool PolynomialModel::is_stable() const { return identify::is_stable(common().denominator); }

double PolynomialModel::gain(std::size_t i) const { return B[i].sum() / (A.sum() * F[i].sum()); }

bool PolynomialModel::integrates() const { return !(std::fabs(A.sum()) > 1e-12 * A.lpNorm<1>()); }

double PolynomialModel::level() const { return has_offset && !integrates() ? y0 + offset / A.sum() : y0; }

std::size_t match(const PolynomialModel& model, const DataSet& data) {
  return check_signals(model.inputs, model.output, model.Ts, data);
}

namespace {

// What the past before the first sample adds to `from_rest`: responses to impulses at the first samples, as many as the
// order, span it.
VectorXd of_the_past(const VectorXd& denominator, const VectorXd& measured, const VectorXd& from_rest, Index samples) {
  const Index order = denominator.size() - 1, all = from_rest.size();
  const VectorXd h = impulse_response(monic(0), denominator, all);
  const Index most = std::min(std::max(samples, order), all);
  Eigen::MatrixXd rows(most, order);
  VectorXd rest(most);
  Index count = 0;
  for (Index k = 0; k < most; ++k) {
    if (std::isnan(measured[k])) continue;
    for (Index j = 0; j < order; ++j) rows(count, j) = k >= j ? h[k - j] : 0;
    rest[count++] = measured[k] - from_rest[k];
  }
  VectorXd past = VectorXd::Zero(all);
  if (count == 0 || order == 0 || !rows.topRows(count).allFinite()) return past;
  const VectorXd c = rows.topRows(count).completeOrthogonalDecomposition().solve(rest.head(count));
  for (Index j = 0; j < std::min(order, all); ++j) past.tail(all - j) += c[j] * h.head(all - j);
  return past;
}

}  // namespace

Series simulate(const PolynomialModel& model, const DataSet& data, Start start, Index samples) {
  const std::size_t output = match(model, data);
  const PolynomialModel::Common c = model.common();
  Index first = c.denominator.size() - 1;
  for (const VectorXd& n : c.numerators) first = std::max(first, n.size() - 1);
  check_free_run(data, start == Start::measured ? first : 0, {output});
  const double level = model.level();
  // Where no level belongs to the constant it drives A y.
  double drift = 0;
  if (model.has_offset && model.integrates()) {
    drift = model.offset;
    for (const VectorXd& f : model.F) drift *= f.sum();
  }
  Series result;
  for (const Experiment& e : data.experiments) {
    VectorXd y = VectorXd::Constant(e.samples(), drift);
    for (std::size_t i = 0; i < c.numerators.size(); ++i) {
      const VectorXd& numerator = c.numerators[i];
      const VectorXd u = input(model, e, i);
      y += filter(numerator, monic(0), u);
      if (start != Start::estimated || u.size() == 0) continue;
      // An input whose delay reaches before the record is taken to have been what it is at first.
      for (Index early = 0; early < std::min(numerator.size() - 1, y.size()); ++early) {
        y[early] += numerator.tail(numerator.size() - 1 - early).sum() * u[0];
      }
    }
    Index k = 0;
    if (start == Start::measured) {
      for (; k < std::min(first, e.samples()); ++k) y[k] = e.y(k, static_cast<Index>(output)) - level;
    }
    for (; k < e.samples(); ++k) {
      for (Index i = 1; i < std::min(c.denominator.size(), k + 1); ++i) y[k] -= c.denominator[i] * y[k - i];
    }
    if (start == Start::estimated)
      y += of_the_past(c.denominator, e.y.col(static_cast<Index>(output)).array() - level, VectorXd(y), samples);
    result.push_back(y.array() + level);
  }
  return result;
}

Series k_step(const PolynomialModel& model, const DataSet& data, int steps, std::optional<Initial> initial) {
  const std::size_t output = match(model, data);
  if (steps < 1) fail("a prediction looks at least one step ahead, not {}", steps);
  // y(k | k-h) = y(k) - sum_{i<h} h_i v(k-i) with the impulse response h of the noise model C/(A D).
  const VectorXd h = impulse_response(model.C, multiply(model.A, model.D), steps);
  Series result;
  for (const Experiment& e : data.experiments) {
    const VectorXd v = innovations(model, e, output, initial.value_or(model.initial));
    result.push_back(e.y.col(static_cast<Index>(output)) - filter(h, monic(0), v));
  }
  return result;
}

Series one_step(const PolynomialModel& model, const DataSet& data, std::optional<Initial> initial) {
  return k_step(model, data, 1, initial);
}

Series residuals(const PolynomialModel& model, const DataSet& data, std::optional<Initial> initial) {
  const std::size_t output = match(model, data);
  Series result;
  const Initial begin = initial.value_or(model.initial);
  for (const Experiment& e : data.experiments) result.push_back(innovations(model, e, output, begin));
  return result;
}

}  // namespace plantloop::identify
