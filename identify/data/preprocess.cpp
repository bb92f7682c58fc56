// What is done to data before a fit: trends, scales, filters, gaps.

#include "identify/data/preprocess.h"

#include <algorithm>
#include <cmath>

#include "identify/error.h"
#include "identify/linear/filter.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Mean of the values that are there; 0 when none is.
double mean_of(const MatrixXd& all, Index column) {
  double sum = 0;
  double count = 0;
  for (const double v : all.col(column)) {
    if (std::isnan(v)) continue;
    sum += v;
    count += 1;
  }
  return count > 0 ? sum / count : 0;
}

// Offset and slope over the row number.
std::pair<double, double> line_of(const VectorXd& x) {
  double count = 0, k_sum = 0, x_sum = 0;
  for (Index k = 0; k < x.size(); ++k) {
    if (std::isnan(x[k])) continue;
    count += 1;
    k_sum += static_cast<double>(k);
    x_sum += x[k];
  }
  if (count == 0) return {0, 0};
  const double k_mean = k_sum / count;
  const double x_mean = x_sum / count;
  double spread = 0, product = 0;
  for (Index k = 0; k < x.size(); ++k) {
    if (std::isnan(x[k])) continue;
    const double dk = static_cast<double>(k) - k_mean;
    spread += dk * dk;
    product += dk * (x[k] - x_mean);
  }
  const double slope = spread > 0 ? product / spread : 0;
  return {x_mean - slope * k_mean, slope};
}

void add_trend(MatrixXd& values, const VectorXd& offset, const VectorXd& slope, double sign) {
  for (Index k = 0; k < values.rows(); ++k) {
    values.row(k) += sign * (offset + static_cast<double>(k) * slope).transpose();
  }
}

DataSet with_trends(const DataSet& data, const std::vector<Trend>& trends, double sign) {
  if (trends.size() != 1 && trends.size() != data.experiments.size()) {
    fail("there are {} trends for {} experiments", trends.size(), data.experiments.size());
  }
  DataSet result = data;
  for (std::size_t i = 0; i < result.experiments.size(); ++i) {
    const Trend& t = trends[trends.size() == 1 ? 0 : i];
    add_trend(result.experiments[i].u, t.u_offset, t.u_slope, sign);
    add_trend(result.experiments[i].y, t.y_offset, t.y_slope, sign);
  }
  return result;
}

void scale_of(const MatrixXd& all, Index column, Normalisation::Kind kind, double& offset, double& scale) {
  double least = HUGE_VAL, most = -HUGE_VAL, squares = 0, count = 0;
  const double mean = mean_of(all, column);
  for (const double v : all.col(column)) {
    if (std::isnan(v)) continue;
    least = std::min(least, v);
    most = std::max(most, v);
    squares += (v - mean) * (v - mean);
    count += 1;
  }
  const bool by_range = kind == Normalisation::Kind::least_and_greatest;
  offset = by_range && count > 0 ? least : mean;
  scale = by_range ? most - least : std::sqrt(squares / count);
  // A spread of rounding errors is none. The mean of equal values may differ from them by rounding, their least cannot.
  if (count > 0 && !(most - least > 1e-14 * std::max(std::fabs(most), std::fabs(least)))) {
    scale = 0;
    offset = least;
  }
}

void normalise(const MatrixXd& all, const std::vector<Channel>& channels, Normalisation& n, VectorXd& offset,
               VectorXd& scale) {
  offset.resize(all.cols());
  scale.resize(all.cols());
  for (Index c = 0; c < all.cols(); ++c) {
    scale_of(all, c, n.kind, offset[c], scale[c]);
    if (scale[c] > 0) continue;
    scale[c] = 1;
    n.constant.push_back(channels[static_cast<std::size_t>(c)].name);
  }
}

MatrixXd scaled(const MatrixXd& x, const VectorXd& offset, const VectorXd& scale) {
  return (x.rowwise() - offset.transpose()) * scale.cwiseInverse().asDiagonal();
}
MatrixXd unscaled(const MatrixXd& x, const VectorXd& offset, const VectorXd& scale) {
  return (x * scale.asDiagonal()).rowwise() + offset.transpose();
}

template <typename Change>
DataSet changed(const DataSet& data, Change change) {
  check(data);
  DataSet result = data;
  for (Experiment& e : result.experiments) {
    for (MatrixXd* m : {&e.u, &e.y}) {
      for (Index c = 0; c < m->cols(); ++c) m->col(c) = change(VectorXd(m->col(c)));
    }
  }
  return result;
}

}  // namespace

std::vector<Trend> fit_trends(const DataSet& data, TrendKind kind) {
  check(data);
  std::vector<Trend> trends;
  const auto inputs = static_cast<Index>(data.inputs.size());
  const auto outputs = static_cast<Index>(data.outputs.size());
  const MatrixXd u = data.all_u();
  const MatrixXd y = data.all_y();
  for (const Experiment& e : data.experiments) {
    Trend t{VectorXd(inputs), VectorXd::Zero(inputs), VectorXd(outputs), VectorXd::Zero(outputs)};
    for (Index c = 0; c < inputs; ++c) {
      if (kind == TrendKind::mean) t.u_offset[c] = mean_of(u, c);
      if (kind == TrendKind::line) std::tie(t.u_offset[c], t.u_slope[c]) = line_of(e.u.col(c));
    }
    for (Index c = 0; c < outputs; ++c) {
      if (kind == TrendKind::mean) t.y_offset[c] = mean_of(y, c);
      if (kind == TrendKind::line) std::tie(t.y_offset[c], t.y_slope[c]) = line_of(e.y.col(c));
    }
    trends.push_back(std::move(t));
    if (kind == TrendKind::mean) break;  // one for all
  }
  return trends;
}

DataSet remove(const DataSet& data, const std::vector<Trend>& trends) { return with_trends(data, trends, -1); }
DataSet restore(const DataSet& data, const std::vector<Trend>& trends) { return with_trends(data, trends, 1); }

Normalisation fit_normalisation(const DataSet& data, Normalisation::Kind kind) {
  check(data);
  Normalisation n;
  n.kind = kind;
  normalise(data.all_u(), data.inputs, n, n.u_offset, n.u_scale);
  normalise(data.all_y(), data.outputs, n, n.y_offset, n.y_scale);
  return n;
}

DataSet Normalisation::apply(const DataSet& data) const {
  DataSet result = data;
  for (Experiment& e : result.experiments) {
    e.u = scaled(e.u, u_offset, u_scale);
    e.y = scaled(e.y, y_offset, y_scale);
  }
  return result;
}

DataSet Normalisation::undo(const DataSet& data) const {
  DataSet result = data;
  for (Experiment& e : result.experiments) {
    e.u = unscaled(e.u, u_offset, u_scale);
    e.y = unscaled(e.y, y_offset, y_scale);
  }
  return result;
}

MatrixXd Normalisation::outputs(const MatrixXd& normalised) const { return unscaled(normalised, y_offset, y_scale); }
MatrixXd Normalisation::variances(const MatrixXd& normalised) const {
  return normalised * y_scale.cwiseAbs2().asDiagonal();
}

DataSet filter(const DataSet& data, const VectorXd& B, const VectorXd& A) {
  refuse_missing(data, "a filter");
  if (A.size() == 0 || A[0] == 0 || B.size() == 0)
    fail("a filter B/A has a first coefficient of A that is not 0, and a B");
  return changed(data, [&](const VectorXd& x) { return filter(B, A, x); });
}

DataSet fill_missing(const DataSet& data, Fill fill, Index longest) {
  return changed(data, [&](VectorXd x) {
    for (Index k = 0; k < x.size();) {
      if (!std::isnan(x[k])) {
        ++k;
        continue;
      }
      Index end = k;
      while (end < x.size() && std::isnan(x[end])) ++end;
      const bool inside = k > 0 && (end < x.size() || fill == Fill::hold);
      if (inside && (longest == 0 || end - k <= longest)) {
        const double from = x[k - 1];
        const double step = fill == Fill::hold ? 0 : (x[end] - from) / static_cast<double>(end - k + 1);
        for (Index i = k; i < end; ++i) x[i] = from + step * static_cast<double>(i - k + 1);
      }
      k = end;
    }
    return x;
  });
}

DataSet in_pieces(const DataSet& data, Index length, Index lag) {
  DataSet pieces = data;
  pieces.experiments.clear();
  for (const Experiment& e : data.experiments) {
    const Index count = std::max<Index>(1, (e.samples() - lag) / length);
    for (Index i = 0; i < count; ++i) {
      const Index from = i * length, until = i + 1 == count ? e.samples() : from + length + lag;
      if (!e.y.middleRows(from, std::min(lag, until - from)).allFinite()) continue;
      Experiment piece = e;
      piece.u = e.u.middleRows(from, until - from);
      piece.y = e.y.middleRows(from, until - from);
      pieces.experiments.push_back(std::move(piece));
    }
  }
  return pieces;
}

}  // namespace plantloop::identify
