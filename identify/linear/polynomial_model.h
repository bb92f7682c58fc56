// Linear models of one output with polynomials in the delay operator:
//
//   A y(k) = sum_i q^-d_i (B_i/F_i) u_i(k) + offset + (C/D) v(k),   v white noise
//
// A = 1 + a1 q^-1 + ..., C, D, F likewise; B = b1 q^-1 + b2 q^-2 + ..., so that with d = 0 the input acts one sample
// later. A delay of -1 means that it acts at once. FIR: A = C = D = F = 1; ARX: C = D = F = 1; ARMAX: D = F = 1; OE: A
// = C = D = 1; BJ (Box-Jenkins): A = 1.

#pragma once

#include <Eigen/Core>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "identify/data/data_set.h"
#include "identify/fit_report.h"

namespace plantloop::identify {

struct Orders {
  int na = 0, nc = 0, nd = 0;
  std::vector<int> nb, nf, delay;  // one for each input

  int parameters() const;
  int longest_lag() const;  // max(na, nb + d)
};

// The past before the first sample of a record, which nobody has measured.
enum class Initial {
  rest,      // at rest: inputs at u0, the output at the level that belongs to them, no noise
  estimate,  // of the process, the one that makes the prediction errors of the experiment least; see prediction_error.h
};

struct PolynomialModel {
  std::string structure;  // "FIR", "ARX", "ARMAX", "OE", "BJ", "general"
  std::vector<Channel> inputs;
  Channel output;
  double Ts = 1;                      // s
  Eigen::VectorXd A, C, D;            // with their leading 1
  std::vector<Eigen::VectorXd> B, F;  // for each input; B without its zero at delay 0: {b1, b2, ...}
  std::vector<int> delay;
  Eigen::VectorXd u0;  // operating point: the model is of u - u0 and y - y0
  double y0 = 0;
  bool has_offset = false;  // whether the constant is a parameter
  double offset = 0;
  Initial initial = Initial::rest;  // of the fit, and of predictions unless told otherwise
  double variance = 0;              // of v
  Eigen::MatrixXd covariance;       // of parameters(), in their order
  FitReport fit;

  Orders orders() const;
  // a1.. ana, b of each input, c, d, f of each input, the offset.
  Eigen::VectorXd parameters() const;
  void set_parameters(const Eigen::VectorXd& theta);
  std::vector<std::string> parameter_names() const;  // "a1", "b1" or "b1.2" (input 2), ...
  // q^-d B with its zeros: coefficients from delay 0 on.
  Eigen::VectorXd numerator(std::size_t input) const;
  // G_i = q^-d B_i/(A F_i) as numerators over one denominator for all inputs.
  struct Common {
    std::vector<Eigen::VectorXd> numerators;
    Eigen::VectorXd denominator;
  };
  Common common() const;
  bool is_stable() const;                // A F
  double gain(std::size_t input) const;  // at rest
  // A(1) = 0 but for rounding: a constant then makes a ramp, and no level belongs to it.
  bool integrates() const;
  // The output at rest with the inputs at u0: y0 + offset/A(1); y0 when A integrates.
  double level() const;
};

// A model with these orders and all parameters 0.
PolynomialModel make_polynomial_model(const Orders& orders, const DataSet& data, std::size_t output);

// Where a simulation starts.
enum class Start {
  zero,      // from rest at the operating point, at the level of the offset
  measured,  // the first samples (as many as the longest lag) are the measured ones
  // From the past that fits the first measured samples best, in least squares, the inputs held before the record. It is
  // the better start of models that are not driven by measured outputs, as noise in a few samples may hide a slow
  // state.
  estimated,
};

// For each experiment one column vector in units of the output.
using Series = std::vector<Eigen::VectorXd>;

// Free run: the outputs are the model's own. Needs no missing inputs.
// `samples`: how many measured ones of each experiment an estimated start may use; fewer than the order are raised to
// it.
Series simulate(const PolynomialModel& model, const DataSet& data, Start start = Start::measured,
                Eigen::Index samples = std::numeric_limits<Eigen::Index>::max());
// y(k) predicted from outputs up to k-1 and inputs up to k. `initial`: the model's own unless given.
Series one_step(const PolynomialModel& model, const DataSet& data, std::optional<Initial> initial = {});
// y(k) predicted from outputs up to k - steps and inputs up to k.
Series k_step(const PolynomialModel& model, const DataSet& data, int steps, std::optional<Initial> initial = {});
// y - one_step.
Series residuals(const PolynomialModel& model, const DataSet& data, std::optional<Initial> initial = {});

// The column of the data that is the model's output; raises IdentifyError when names or sampling time do not fit.
std::size_t match(const PolynomialModel& model, const DataSet& data);

Item to_item(const PolynomialModel& model);
PolynomialModel polynomial_model_of(const Item& item);

}  // namespace plantloop::identify
