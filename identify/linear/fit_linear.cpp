// Fits of linear models: what all begin with, and least squares.

#include "identify/linear/fit_linear.h"

#include <algorithm>
#include <cmath>

#include "identify/error.h"
#include "identify/linear/arx.h"
#include "identify/linear/least_squares.h"
#include "identify/linear/search.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

constexpr int highest = 10'000;

void for_each_input(std::vector<int>& list, std::size_t inputs, int fallback, std::string_view name) {
  if (list.empty()) list.assign(inputs, fallback);
  if (list.size() == 1) list.assign(inputs, list[0]);
  if (list.size() != inputs)
    fail("'{}' is one number, or one for each of {} inputs; there are {}", name, inputs, list.size());
}

void check_order(int order, int least, std::string_view name) {
  if (order < least || order > highest) fail("'{}' must lie between {} and {}, it is {}", name, least, highest, order);
}

std::size_t find_output(const DataSet& data, const std::string& name) {
  if (name.empty() && data.outputs.size() == 1) return 0;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < data.outputs.size(); ++i) {
    if (data.outputs[i].name == name) return i;
    names.push_back(data.outputs[i].name);
  }
  if (name.empty())
    fail("the data have {} outputs ({}): say which one the model is of", names.size(), fmt::join(names, ", "));
  fail("the data have no output '{}'; there are: {}", name, fmt::join(names, ", "));
}

// Means over the samples that are there.
double mean(const DataSet& data, MatrixXd Experiment::*member, Index column) {
  double sum = 0;
  double count = 0;
  for (const Experiment& e : data.experiments) {
    for (const double v : (e.*member).col(column)) {
      if (std::isnan(v)) continue;
      sum += v;
      count += 1;
    }
  }
  return count > 0 ? sum / count : 0;
}

}  // namespace

LinearTask prepare(const DataSet& data, Orders orders, const LinearOptions& options) {
  check(data);
  LinearTask task;
  task.output = find_output(data, options.output);
  const std::size_t inputs = data.inputs.size();
  for_each_input(orders.nb, inputs, 1, "nb");
  for_each_input(orders.nf, inputs, 0, "nf");
  for_each_input(orders.delay, inputs, 0, "delay");
  check_order(orders.na, 0, "na");
  check_order(orders.nc, 0, "nc");
  check_order(orders.nd, 0, "nd");
  for (const int n : orders.nb) check_order(n, 0, "nb");
  for (const int n : orders.nf) check_order(n, 0, "nf");
  for (const int d : orders.delay) check_order(d, -1, "delay");
  if (options.iterations < 0) fail("the number of iterations is {}; it must be 0 or more", options.iterations);
  if (!(options.ridge >= 0)) fail("the ridge is {:g}; it must be 0 or greater", options.ridge);
  if (orders.parameters() == 0) fail("the model has no parameters: all orders are 0");
  task.orders = std::move(orders);
  task.offset = options.offset;
  task.initial = options.initial.value_or(options.offset ? Initial::estimate : Initial::rest);
  if (task.parameters() > data.samples()) {
    fail("{} parameters cannot be estimated from {} samples", task.parameters(), data.samples());
  }
  task.data = data;
  task.hash = hash(data);
  task.u0 = Eigen::VectorXd::Zero(static_cast<Index>(inputs));
  if (!options.remove_means) return task;
  for (Index i = 0; i < task.u0.size(); ++i) task.u0[i] = mean(data, &Experiment::u, i);
  const auto column = static_cast<Index>(task.output);
  task.y0 = mean(data, &Experiment::y, column);
  for (Experiment& e : task.data.experiments) {
    e.u.rowwise() -= task.u0.transpose();
    e.y.col(column).array() -= task.y0;
  }
  return task;
}

PolynomialModel fit_linear(const DataSet& data, const Orders& orders, const LinearOptions& options,
                           const FitControl& control) {
  const LinearTask task = prepare(data, orders, options);
  const bool searched = task.orders.nc + task.orders.nd > 0 ||
                        std::any_of(task.orders.nf.begin(), task.orders.nf.end(), [](int n) { return n > 0; });
  return searched ? search_linear(task, options, control) : fit_arx(task, options);
}

}  // namespace plantloop::identify
