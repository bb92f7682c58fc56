// Sums of products of lagged signals, with their derivatives.

#include "identify/narx/regression_narx.h"

#include <algorithm>
#include <map>
#include <utility>

namespace plantloop::identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

double power(double base, int exponent) {
  double result = base;
  for (int i = 1; i < exponent; ++i) result *= base;
  return result;
}

struct Place {
  Index signal;  // among the map's inputs
  int power;
};

// y = offset + scale theta' [products of z^power],  z = (x - offset)/scale: in the order in which RegressionModel
// computes it, so that the numbers are the same.
class ProductMap final : public Approximator {
 public:
  ProductMap(RegressionModel model, std::vector<std::vector<Place>> products, VectorXd offset, VectorXd scale)
      : model_(std::move(model)),
        products_(std::move(products)),
        offset_(std::move(offset)),
        scale_(std::move(scale)),
        y_offset_(VectorXd::Zero(model_.theta.cols())),
        y_scale_(VectorXd::Ones(model_.theta.cols())) {
    if (!model_.normalised) return;
    y_offset_ = model_.normalisation.y_offset;
    y_scale_ = model_.normalisation.y_scale;
  }

  std::string type() const override { return "regression_model"; }
  int inputs() const override { return static_cast<int>(offset_.size()); }
  int outputs() const override { return static_cast<int>(model_.theta.cols()); }
  int scratch_size() const override { return inputs() + static_cast<int>(products_.size()); }

  void evaluate(const double* x, double* y, double* scratch) const override {
    normalise(x, scratch);
    const auto terms = VectorXd::Map(scratch + inputs(), static_cast<Index>(products_.size()));
    for (std::size_t j = 0; j < products_.size(); ++j) {
      double product = 1;
      for (const Place& p : products_[j]) product *= power(scratch[p.signal], p.power);
      scratch[inputs() + static_cast<Index>(j)] = product;
    }
    const VectorXd result = model_.theta.transpose() * terms;
    for (Index o = 0; o < result.size(); ++o) y[o] = result[o] * y_scale_[o] + y_offset_[o];
  }

  void derivative(const double* x, double* jacobian, double* scratch) const override {
    normalise(x, scratch);
    std::fill(jacobian, jacobian + inputs() * outputs(), 0.0);
    for (std::size_t j = 0; j < products_.size(); ++j) {
      for (const Place& by : products_[j]) {
        double slope = by.power * (by.power > 1 ? power(scratch[by.signal], by.power - 1) : 1) / scale_[by.signal];
        for (const Place& p : products_[j]) {
          if (&p != &by) slope *= power(scratch[p.signal], p.power);
        }
        for (Index o = 0; o < outputs(); ++o)
          jacobian[o * inputs() + by.signal] += model_.theta(static_cast<Index>(j), o) * slope * y_scale_[o];
      }
    }
  }

  bool is_affine() const override {
    return std::all_of(products_.begin(), products_.end(), [](const std::vector<Place>& product) {
      return product.empty() || (product.size() == 1 && product.front().power == 1);
    });
  }

  // What the file of the regression model holds.
  void write(Item& item) const override { item.set("model", to_item(model_)); }

 private:
  void normalise(const double* x, double* z) const {
    for (Index i = 0; i < offset_.size(); ++i) z[i] = (x[i] - offset_[i]) * (1 / scale_[i]);
  }
  RegressionModel model_;
  std::vector<std::vector<Place>> products_;
  VectorXd offset_, scale_, y_offset_, y_scale_;
};

}  // namespace

NarxModel to_narx(const RegressionModel& model) {
  RegressorSet signals{model.regressors.inputs, model.regressors.outputs, {}, 0};
  std::map<Factor, Index> places;
  std::vector<std::vector<Place>> products;
  std::vector<double> offset, scale;
  const Normalisation& n = model.normalisation;
  for (const Regressor& term : model.regressors.list) {
    std::vector<Place>& product = products.emplace_back();
    for (const Factor& factor : term.factors) {
      Factor single = factor;
      single.power = 1;
      const auto [entry, is_new] = places.emplace(single, static_cast<Index>(signals.list.size()));
      product.push_back({entry->second, factor.power});
      if (!is_new) continue;
      signals.list.push_back({{single}});
      offset.push_back(!model.normalised ? 0 : (single.of_output ? n.y_offset : n.u_offset)[single.channel]);
      scale.push_back(!model.normalised ? 1 : (single.of_output ? n.y_scale : n.u_scale)[single.channel]);
    }
  }
  const auto count = static_cast<Index>(offset.size());
  NarxModel narx;
  narx.map = std::make_shared<ProductMap>(model, std::move(products), VectorXd::Map(offset.data(), count),
                                          VectorXd::Map(scale.data(), count));
  narx.regressors = std::move(signals);
  narx.channels.Ts = model.Ts;
  narx.channels.inputs = model.inputs;
  narx.channels.outputs = model.outputs;
  narx.fit = model.fit;
  return narx;
}

}  // namespace plantloop::identify
