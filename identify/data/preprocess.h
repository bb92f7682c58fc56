// What is done to data before a fit, and undone after it: trends, scales, filters, other sampling times, gaps.

#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "identify/data/data_set.h"

namespace plantloop::identify {

// Offset and slope of each channel, removed as offset + slope * (k - first row).
struct Trend {
  Eigen::VectorXd u_offset, u_slope, y_offset, y_slope;
};
enum class TrendKind {
  mean,  // one mean for each channel over all experiments: an operating point, which other data can be related to
  line,  // a straight line by least squares for each channel and experiment
};
// One trend for each experiment. Missing values do not count.
std::vector<Trend> fit_trends(const DataSet& data, TrendKind kind);
// With trends of as many experiments, or with one trend for all.
DataSet remove(const DataSet& data, const std::vector<Trend>& trends);
DataSet restore(const DataSet& data, const std::vector<Trend>& trends);

// Scales of the channels, taken from the data of identification and applied to all others.
struct Normalisation {
  enum class Kind { mean_and_deviation, least_and_greatest };
  Kind kind = Kind::mean_and_deviation;
  // A value x becomes (x - offset)/scale: mean 0 and standard deviation 1 (with 1/N), or the range 0 to 1. Of a
  // constant channel the scale is 1.
  Eigen::VectorXd u_offset, u_scale, y_offset, y_scale;
  std::vector<std::string> constant;  // names of channels that do not vary

  DataSet apply(const DataSet& data) const;
  DataSet undo(const DataSet& data) const;
  // Predictions (samples x outputs) and their variances back in units.
  Eigen::MatrixXd outputs(const Eigen::MatrixXd& normalised) const;
  Eigen::MatrixXd variances(const Eigen::MatrixXd& normalised) const;
};
Normalisation fit_normalisation(const DataSet& data,
                                Normalisation::Kind kind = Normalisation::Kind::mean_and_deviation);

// Every channel filtered by B/A from rest. Inputs and outputs alike, so that the relation between them stays.
DataSet filter(const DataSet& data, const Eigen::VectorXd& B, const Eigen::VectorXd& A);

// The sampling time becomes Ts down/up. Every channel is low-passed without phase by a Kaiser window of 60 dB that cuts
// at the lower of both Nyquist frequencies (10 zero crossings to each side); at its ends a record continues with its
// first and last values. up and down are 1 to 1000. With down > up frequencies above the new Nyquist frequency are
// lost.
DataSet resample(const DataSet& data, int up, int down);

enum class Fill { line, hold };
// Gaps of at most `longest` samples filled with a straight line between their ends, or with the value before; longer
// ones and gaps at an end stay. longest = 0: all lengths.
DataSet fill_missing(const DataSet& data, Fill fill, Eigen::Index longest = 0);

// The same data in pieces, each an experiment of `lag` samples to begin with and `length` samples after them; the last
// one of each experiment takes what is left over. Pieces whose first outputs are missing are left out.
DataSet in_pieces(const DataSet& data, Eigen::Index length, Eigen::Index lag);

}  // namespace plantloop::identify
