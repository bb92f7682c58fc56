// Measured signals: inputs u and outputs y of one process, sampled evenly, in one or more experiments.

#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace plantloop::identify {

// A signal's name, and its unit as the file or the script wrote it ("" when nothing was said).
struct Channel {
  std::string name;
  std::string unit;
  friend bool operator==(const Channel&, const Channel&) = default;
};

// Signals that were recorded without a break: row k is the sample at start + k Ts. NaN is a missing value.
struct Experiment {
  std::string name;
  double start = 0;   // s, of the first row
  Eigen::MatrixXd u;  // samples x inputs
  Eigen::MatrixXd y;  // samples x outputs
  Eigen::Index samples() const { return y.rows(); }
};

// Lags never reach from one experiment into the next.
struct DataSet {
  double Ts = 1;  // s, the sampling time of all experiments
  std::vector<Channel> inputs, outputs;
  std::vector<Experiment> experiments;

  Eigen::Index samples() const;  // of all experiments together
  Eigen::Index missing() const;  // values that are NaN
  // The experiments below each other: samples() x inputs, samples() x outputs.
  Eigen::MatrixXd all_u() const;
  Eigen::MatrixXd all_y() const;
};

// Names (each once), sizes and sampling time fit, there are an output and a sample; the greatest value of a channel is
// 0 or from 1e-150 to 1e150. Raises IdentifyError. Every function that takes a DataSet from outside calls it.
void check(const DataSet& data);
// Raises IdentifyError with the place of the first missing value; `method` needs all of them.
void refuse_missing(const DataSet& data, std::string_view method);

// One experiment from columns. `u` may have no column (a time series).
DataSet make_data_set(Eigen::MatrixXd u, Eigen::MatrixXd y, double Ts, std::vector<Channel> inputs = {},
                      std::vector<Channel> outputs = {});

// Rows [from, until) of each experiment, counted from 0; `until` beyond the end is the end. An experiment of which
// nothing is left is left out.
DataSet part(const DataSet& data, Eigen::Index from, Eigen::Index until);
// The first `fraction` (0 to 1) of each experiment, and what follows it.
std::pair<DataSet, DataSet> split(const DataSet& data, double fraction);
// The experiments with the given numbers (from 0), in that order.
DataSet choose(const DataSet& data, const std::vector<std::size_t>& experiments);
// The experiments of both; channels and sampling times must agree.
DataSet join(const DataSet& first, const DataSet& second);

// 16 hexadecimal digits that change with any bit of the data, names, units or the sampling time (FNV-1a, 64 bit).
std::string hash(const DataSet& data);

}  // namespace plantloop::identify
