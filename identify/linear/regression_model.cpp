// NARX models that are linear in their parameters: least squares, predictions, files.

#include "identify/linear/regression_model.h"

#include "identify/data/matching.h"
#include "identify/data/undetermined.h"
#include "identify/error.h"
#include "identify/linear/least_squares.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Names and sampling time fit; the data as the regressors see them.
DataSet seen(const RegressionModel& m, const DataSet& data) {
  check_signals(m.inputs, m.outputs, m.Ts, data);
  return m.normalised ? m.normalisation.apply(data) : data;
}

Predictor predictor(const RegressionModel& m) {
  return [&m](const VectorXd& x) { return VectorXd(m.theta.transpose() * x); };
}

Outputs in_units(const RegressionModel& m, Outputs y) {
  if (!m.normalised) return y;
  for (MatrixXd& each : y) each = m.normalisation.outputs(each);
  return y;
}

Item channel_items(const std::vector<Channel>& channels, const VectorXd& offset, const VectorXd& scale) {
  Item list = Item::list();
  for (std::size_t i = 0; i < channels.size(); ++i) {
    Item item;
    item.set("name", channels[i].name);
    if (!channels[i].unit.empty()) item.set("unit", channels[i].unit);
    if (offset.size() > 0) {
      item.set("offset", offset[static_cast<Index>(i)]).set("scale", scale[static_cast<Index>(i)]);
    }
    list.add(std::move(item));
  }
  return list;
}

void read_channels(const Item& item, std::string_view key, bool normalised, std::vector<Channel>& channels,
                   VectorXd& offset, VectorXd& scale) {
  const std::vector<Item>& items = item.items(key);
  offset = VectorXd::Zero(static_cast<Index>(items.size()));
  scale = VectorXd::Ones(offset.size());
  for (std::size_t i = 0; i < items.size(); ++i) {
    items[i].only({"name", "unit", "offset", "scale"});
    channels.push_back({items[i].text("name"), items[i].has("unit") ? items[i].text("unit") : ""});
    if (!normalised) continue;
    offset[static_cast<Index>(i)] = items[i].number("offset");
    scale[static_cast<Index>(i)] = items[i].number("scale");
  }
}

}  // namespace

RegressionModel fit_regression(const DataSet& data, const RegressorSet& set, const RegressionOptions& options,
                               const FitControl& control) {
  check(data);
  RegressionModel m;
  m.regressors = set;
  m.inputs = data.inputs;
  m.outputs = data.outputs;
  m.Ts = data.Ts;
  m.normalised = options.normalise;
  if (m.normalised) m.normalisation = fit_normalisation(data);
  const Regression r = make_regression(seen(m, data), set);
  const Index outputs = r.Y.cols();
  m.theta.resize(set.size(), outputs);
  m.variance.resize(outputs);
  for (Index i = 0; i < outputs; ++i) {
    control.step(static_cast<double>(i) / static_cast<double>(outputs));
    const LeastSquares fit = least_squares(r.X, r.Y.col(i), {.ridge = options.ridge});
    m.theta.col(i) = fit.theta;
    m.variance[i] = fit.s2;
    m.covariance.push_back(fit.covariance);
    m.fit.tried.push_back(outputs == 1
                              ? fit.account()
                              : fmt::format("{}: {}", data.outputs[static_cast<std::size_t>(i)].name, fit.account()));
    m.fit.reached += fit.sse / static_cast<double>(r.X.rows() * outputs);
    if (i == 0) m.fit.warnings = fit.warnings;
  }
  m.fit.method = options.ridge > 0 ? "least squares with ridge" : "least squares";
  m.fit.samples = r.X.rows();
  m.fit.parameters = m.theta.size();
  m.fit.stopped = "solved directly";
  m.fit.data = hash(data);
  if (options.ridge > 0) m.fit.options.push_back(fmt::format("ridge {}", options.ridge));
  if (options.normalise) m.fit.options.emplace_back("normalise");
  if (r.left_out > 0)
    m.fit.warnings.push_back(fmt::format("{} rows that touch missing values are left out", r.left_out));
  for (std::string& warning : undetermined(data)) m.fit.warnings.push_back(std::move(warning));
  return m;
}

Outputs one_step(const RegressionModel& m, const DataSet& data) {
  return in_units(m, one_step(m.regressors, seen(m, data), predictor(m)));
}
Outputs k_step(const RegressionModel& m, const DataSet& data, int steps) {
  return in_units(m, k_step(m.regressors, seen(m, data), predictor(m), steps));
}
Outputs free_run(const RegressionModel& m, const DataSet& data) {
  return in_units(m, free_run(m.regressors, seen(m, data), predictor(m)));
}

Item to_item(const RegressionModel& m) {
  std::vector<std::string> terms;
  for (const Regressor& r : m.regressors.list) terms.push_back(to_text(r, m.regressors));
  Item covariance = Item::list();
  for (const MatrixXd& P : m.covariance) covariance.add(Item().set("P", P));
  const Normalisation& n = m.normalisation;
  Item item;
  item.set("Ts", m.Ts)
      .set("normalised", m.normalised)
      .set("inputs", channel_items(m.inputs, m.normalised ? n.u_offset : VectorXd(), n.u_scale))
      .set("outputs", channel_items(m.outputs, m.normalised ? n.y_offset : VectorXd(), n.y_scale))
      .set("regressors", terms)
      .set("theta", m.theta)
      .set("variance", m.variance)
      .set("covariance", covariance)
      .set("fit", to_item(m.fit));
  return item;
}

RegressionModel regression_model_of(const Item& item) {
  item.only({"plantloop_model", "type", "data", "Ts", "normalised", "inputs", "outputs", "regressors", "theta",
             "variance", "covariance", "fit"});
  RegressionModel m;
  m.Ts = item.number("Ts");
  m.normalised = item.flag("normalised");
  Normalisation& n = m.normalisation;
  read_channels(item, "inputs", m.normalised, m.inputs, n.u_offset, n.u_scale);
  read_channels(item, "outputs", m.normalised, m.outputs, n.y_offset, n.y_scale);
  DataSet channels;
  channels.inputs = m.inputs;
  channels.outputs = m.outputs;
  m.regressors = parse_regressors(fmt::format("{}", fmt::join(item.texts("regressors"), ", ")), channels);
  const auto outputs = static_cast<Index>(m.outputs.size());
  m.theta = item.matrix("theta", m.regressors.size(), outputs);
  m.variance = item.vector("variance", outputs);
  for (const Item& P : item.items("covariance")) {
    m.covariance.push_back(P.matrix("P", m.regressors.size(), m.regressors.size()));
  }
  m.fit = fit_report_of(item.at("fit"));
  return m;
}

}  // namespace plantloop::identify
