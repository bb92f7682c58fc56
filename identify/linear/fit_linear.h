// Fits of linear models with polynomials: FIR, ARX, ARMAX, OE, Box-Jenkins.

#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "identify/linear/polynomial_model.h"

namespace plantloop::identify {

struct LinearOptions {
  std::string output;         // name; "" when there is only one
  bool remove_means = false;  // fit deviations from the means of the data, which become the operating point
  bool offset = false;        // estimate a constant with the parameters
  // The past before the records, in searches and in filtered least squares; FIR and ARX take rows with a whole past
  // either way. Unless given: at rest, and estimated where a constant is.
  std::optional<Initial> initial;
  double ridge = 0;      // of FIR and ARX: adds ridge |theta|^2 to the sum of squares, without the constant
  int iterations = 200;  // of a search, at most
};

// `orders` gives nb, nf and delay either for each input or once for all of them.
//
// FIR and ARX (nc = nd = nf = 0): least squares over the rows with a whole past; rows with missing values are left out.
// Covariance s2 (Psi'Psi)^-1 with s2 = e'e/(rows - p), (2.21) of the book.
//
// All others: the prediction error method. v = (D/C) (A y - sum q^-d B/F u - offset), all samples; minimises sum v^2
// by Levenberg-Marquardt with the exact gradient (prediction_error.h)
// from several starts (least squares, least squares with filtered signals, noise from a long ARX model); roots of C and
// F that leave the unit circle are mirrored. Covariance s2 (J'J)^-1, s2 = v'v/(samples - p), where the values of an
// estimated past count as parameters and are eliminated from J. (L. Ljung, System Identification, 2nd ed., 1999.)
//
// Raises IdentifyError: too few samples, negative orders, missing values in a search.
PolynomialModel fit_linear(const DataSet& data, const Orders& orders, const LinearOptions& options = {},
                           const FitControl& control = {});

// The criterion of the prediction error method at the model's parameters and with its `initial`: v of all experiments
// below each other, and its derivative by the parameters. For tests and for other searches.
Eigen::VectorXd prediction_errors(const PolynomialModel& model, const DataSet& data, Eigen::MatrixXd* jacobian);

// Iteratively filtered least squares (K. Steiglitz and L. McBride 1965): ARX estimates of u and y filtered by 1/A of
// the pass before, until no parameter changes by more than 1e-10, at most `passes`; unstable roots of A are mirrored.
// The result is an OE model: A becomes F, which all inputs share. The fixed point solves sum phi e = 0 with
// phi = [-y/F, u/F], e = y - B/F u; with white e its covariance is s2 (P'P)^-1 (phi'phi) (P'P)^-1, where P is phi
// without noise, [-w/F, u/F], w = B/F u (P. Stoica and T. Soderstrom 1981). It is never less than that of fit_linear.
PolynomialModel fit_filtered(const DataSet& data, const Orders& orders, const LinearOptions& options = {},
                             int passes = 30);

// Instrumental variables (T. Soderstrom and P. Stoica 1983; the four steps of L. Ljung 1999, section 15.3): ARX whose
// instruments are outputs simulated by the estimate before, then the same with signals filtered by an AR model of its
// residuals. Consistent with coloured noise, where least squares is biased.
PolynomialModel fit_instrumental(const DataSet& data, const Orders& orders, const LinearOptions& options = {});

// nb, nf and delay for each input, output found, orders refused that make no sense; what all fits begin with.
struct LinearTask {
  DataSet data;  // about the operating point
  Orders orders;
  std::size_t output = 0;
  Eigen::VectorXd u0;
  double y0 = 0;
  bool offset = false;
  Initial initial = Initial::rest;
  int parameters() const { return orders.parameters() + (offset ? 1 : 0); }
  std::string hash;  // of the data as given
};
LinearTask prepare(const DataSet& data, Orders orders, const LinearOptions& options);

}  // namespace plantloop::identify
