// What a careful engineer says about data before a fit.

#pragma once

#include <string>
#include <vector>

#include "identify/data/data_set.h"

namespace plantloop::identify {

// One line for each finding, in the order: size, gaps, signals that do not vary, limits and coarse steps of a signal,
// offset, outliers, drift, excitation, delay, sampling, feedback. Never empty: the first line says what the data are. A
// finding is a hint with its reason, not a verdict.
std::vector<std::string> advice(const DataSet& data);

// Delays (samples) at which each input first acts on an output, from an impulse response of `length` terms by least
// squares: the first term beyond 3.5 standard deviations. -1 where none is so large that it stands out of all terms,
// once in a thousand times by chance.
std::vector<int> impulse_delays(const DataSet& data, std::size_t output, int length);

// The number of parameters that a signal can determine: the rank of the covariance of windows of `highest`
// successive samples about their mean, singular values below 1e-6 of the greatest counting as nothing.
int excitation_order(const DataSet& data, std::size_t input, int highest);

}  // namespace plantloop::identify
