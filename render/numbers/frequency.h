// Transfer functions as plots need them: frequency response, margins, roots.

#pragma once

#include <complex>
#include <optional>
#include <vector>

namespace plantloop {

using Polynomial = std::vector<double>;  // descending powers
using Complex = std::complex<double>;

// num(s) / den(s) exp(-s delay).
struct Transfer {
  Polynomial num, den;
  double delay = 0;  // s

  Complex at(Complex s) const;
};

// The roots, by real part and then by imaginary part, ascending. Leading zeros count for nothing; empty for a
// polynomial of degree 0 or with coefficients that are not finite. By the eigenvalues of the companion matrix.
std::vector<Complex> roots(const Polynomial& polynomial);

// A frequency response: from 0 rad/s upwards, phase without jumps.
struct Response {
  std::vector<double> w;  // rad/s, ascending
  std::vector<Complex> value;
  std::vector<double> gain, phase;  // dB, degrees
};

// At so many frequencies, evenly on the logarithm; denser near poles and zeros close to the imaginary axis. Without
// ends from a decade below the slowest pole or zero to a decade above the fastest. The phase starts at the branch that
// its integrators and the sign of its gain at rest say: -90 degrees for each integrator.
Response respond(const Transfer& system, std::optional<double> from, std::optional<double> to);
// Of measured values; frequencies that are not positive and values that are not finite are left out.
Response respond(const std::vector<double>& w, const std::vector<double>& real, const std::vector<double>& imaginary);

struct Margins {
  std::optional<double> gain_crossover;   // rad/s where the gain falls through 0 dB (the last such)
  std::optional<double> phase_margin;     // degrees there
  std::optional<double> phase_crossover;  // rad/s where the phase falls through -180 degrees (the first such)
  std::optional<double> gain_margin;      // dB there
};
Margins margins(const Response& response);

}  // namespace plantloop
