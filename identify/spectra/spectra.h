// Frequency responses and spectra: of models with their uncertainty, and of data by Fourier and spectral analysis.

#pragma once

#include <Eigen/Core>
#include <string>

#include "identify/data/data_set.h"
#include "identify/linear/polynomial_model.h"
#include "identify/linear/state_space.h"

namespace plantloop::identify {

// G at the frequencies w (rad/s).
struct FrequencyResponse {
  Eigen::VectorXd w;
  Eigen::VectorXcd G;
  Eigen::VectorXd deviation;        // standard deviation of |G|; empty when it is not known
  Eigen::VectorXd phase_deviation;  // of the phase, rad
  Eigen::VectorXd magnitude() const { return G.cwiseAbs(); }
  Eigen::VectorXd phase() const;  // rad, continued without jumps of 2 pi
};

// `count` frequencies with equal ratios from `from` to the Nyquist frequency pi/Ts (both included).
Eigen::VectorXd frequencies(double from, double Ts, Eigen::Index count);

// G_i(e^{j w Ts}) and its deviation from the parameters' covariance to first order: var |G| = g'Pg with g the gradient
// of |G| by the parameters.
FrequencyResponse frequency_response(const PolynomialModel& model, const Eigen::VectorXd& w, std::size_t input = 0);
FrequencyResponse frequency_response(const StateSpaceModel& model, const Eigen::VectorXd& w, std::size_t input = 0,
                                     std::size_t output = 0);

// The empirical transfer function estimate Y(w)/U(w): discrete Fourier transforms of the signals without their means at
// w = 2 pi k/(N Ts), k = 1 ... N/2. With several experiments of one length sum Y conj(U)/sum |U|^2.
FrequencyResponse fourier_analysis(const DataSet& data, std::size_t input = 0, std::size_t output = 0);

// Weights of correlations at x = tau/lags, |x| <= 1.
enum class LagWindow {
  hamming,   // 0.54 + 0.46 cos(pi x)
  hann,      // 0.5 + 0.5 cos(pi x)
  bartlett,  // 1 - |x|
  parzen,    // 1 - 6 x^2 + 6 |x|^3 for |x| < 1/2, 2 (1 - |x|)^3 beyond
};
LagWindow find_lag_window(const std::string& name);  // raises IdentifyError
double weight_of(LagWindow window, double x);

// Spectral analysis (Blackman-Tukey): R_yu(tau) = 1/N sum y(k+tau) u(k), R_uu, R_yy of the signals without their means,
// tau = -lags ... lags, weighted by the window, G = Phi_yu/Phi_uu. The deviation is that of L. Ljung 1999, (6.55):
// var G = sum weights^2/N Phi_v/Phi_uu; infinite where the window makes Phi_uu negative.
//
// The transforms of Hamming's and Hann's windows have negative side lobes, so that beside strong frequencies power
// spectra fall below 0 and coherences leave 0 ... 1. Those of Bartlett's and Parzen's have none (Ljung, section 6.4).
// So with the former, coherence, noise and power spectra are made with the Parzen window that smooths as much (of equal
// sum of squared weights), with the latter everything with the same.
struct SpectralAnalysis {
  FrequencyResponse response;
  Eigen::VectorXd coherence;      // |Phi_yu|^2/(Phi_uu Phi_yy), 0 to 1; 0 where a signal has no power
  Eigen::VectorXd noise;          // Phi_v = Phi_yy - |Phi_yu|^2/Phi_uu, at least 0
  Eigen::VectorXd input, output;  // Phi_uu, Phi_yy, at least 0
};
SpectralAnalysis spectral_analysis(const DataSet& data, int lags, const Eigen::VectorXd& w, std::size_t input = 0,
                                   std::size_t output = 0, LagWindow window = LagWindow::hamming);

// The discrete Fourier transform X_k = sum x(n) e^{-2 pi j k n/N} of k = 0 ... N-1.
Eigen::VectorXcd fourier_transform(const Eigen::VectorXd& x);
// |X_k|^2/N at w = 2 pi k/(N Ts), k = 0 ... N/2: the periodogram of a signal.
struct Spectrum {
  Eigen::VectorXd w, power;
};
Spectrum periodogram(const Eigen::VectorXd& x, double Ts);

}  // namespace plantloop::identify
