// Whether data have what a model asks for: its signals, its sampling time, and for a free run its inputs without gaps.

#pragma once

#include <string>
#include <vector>

#include "identify/data/data_set.h"

namespace plantloop::identify {

// Each raises IdentifyError with the names or numbers of both sides. Names must be the same and in the same order.
void check_names(const std::vector<std::string>& inputs, const std::vector<std::string>& outputs, const DataSet& data);
// The same for all kinds of models, and check(data). Sampling times may differ by 0.1 %, which rounded times cause.
void check_signals(const std::vector<Channel>& inputs, const std::vector<Channel>& outputs, double Ts,
                   const DataSet& data);
// Of a model of one of the data's outputs; gives its number.
std::size_t check_signals(const std::vector<Channel>& inputs, const Channel& output, double Ts, const DataSet& data);

// Raises IdentifyError with the place of the first missing input, or of a missing value among the outputs `outputs` of
// the first `first` samples, which a free run begins with. Samples are counted from 1.
void check_free_run(const DataSet& data, Eigen::Index first, const std::vector<std::size_t>& outputs);
// All outputs.
void check_free_run(const DataSet& data, Eigen::Index first = 0);
// Whether check_free_run() would pass.
bool can_run_free(const DataSet& data, Eigen::Index first, const std::vector<std::size_t>& outputs);

}  // namespace plantloop::identify
