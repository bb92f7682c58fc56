// A network as a model: scaling, and the model file.

#include <algorithm>
#include <memory>

#include "identify/error.h"
#include "identify/mlp/network.h"

namespace plantloop::identify {

using Eigen::Index;

Mlp::Mlp(Network network, Scaling x, Scaling y) : network_(std::move(network)), x_(std::move(x)), y_(std::move(y)) {
  if (x_.size() != network_.inputs() || y_.size() != network_.outputs())
    fail("a network with {} inputs and {} outputs needs as many scalings, there are {} and {}", network_.inputs(),
         network_.outputs(), x_.size(), y_.size());
}

int Mlp::scratch_size() const {
  return static_cast<int>(network_.scratch_size() + network_.inputs() + network_.outputs());
}

void Mlp::evaluate(const double* x, double* y, double* scratch) const {
  double* z = scratch + network_.scratch_size();
  for (Index i = 0; i < network_.inputs(); ++i) z[i] = (x[i] - x_.offset[i]) / x_.scale[i];
  network_.evaluate(z, y, scratch);
  for (Index o = 0; o < network_.outputs(); ++o) y[o] = y_.offset[o] + y_.scale[o] * y[o];
}

void Mlp::derivative(const double* x, double* jacobian, double* scratch) const {
  const Index n = network_.inputs();
  double* z = scratch + network_.scratch_size();
  for (Index i = 0; i < n; ++i) z[i] = (x[i] - x_.offset[i]) / x_.scale[i];
  network_.differentiate(z, z + n, nullptr, jacobian, scratch);
  for (Index o = 0; o < network_.outputs(); ++o) {
    for (Index i = 0; i < n; ++i) jacobian[o * n + i] *= y_.scale[o] / x_.scale[i];
  }
}

void Mlp::write(Item& item) const {
  write_scaling(item, "x_scaling", x_);
  write_scaling(item, "y_scaling", y_);
  Item layers = Item::list();
  for (const Layer& layer : network_.layers)
    layers.add(Item().set("activation", name_of(layer.activation)).set("weights", layer.w));
  item.set("layers", std::move(layers));
  if (network_.direct.size() > 0) item.set("direct", network_.direct);
}

std::shared_ptr<const Approximator> read_mlp(const Item& item) {
  Network network;
  for (const Item& entry : item.items("layers")) {
    entry.only({"activation", "weights"});
    Layer layer;
    const std::string name = entry.text("activation");
    const std::vector<std::string> known = activation_names();
    if (std::find(known.begin(), known.end(), name) == known.end())
      entry.at("activation")
          .wrong(fmt::format("there is no activation '{}'; there are {}", name, fmt::join(known, ", ")));
    layer.activation = find_activation(name);
    const Index columns = network.layers.empty() ? -1 : network.layers.back().neurons() + 1;
    layer.w = entry.matrix("weights", -1, columns);
    if (layer.w.rows() < 1 || layer.w.cols() < 2)
      entry.at("weights").wrong("a layer needs at least one row, each with a weight for every input and a bias");
    if (!layer.w.allFinite()) entry.at("weights").wrong("weights must be finite");
    network.layers.push_back(std::move(layer));
  }
  if (network.layers.empty()) item.at("layers").wrong("a network needs at least one layer");
  if (item.has("direct")) {
    network.direct = item.matrix("direct", network.outputs(), network.inputs());
    if (!network.direct.allFinite()) item.at("direct").wrong("weights must be finite");
    if (network.layers.back().activation != Activation::linear)
      item.at("direct").wrong("direct connections need a last layer with the activation linear");
  }
  Scaling x = read_scaling(item, "x_scaling", network.inputs());
  Scaling y = read_scaling(item, "y_scaling", network.outputs());
  return std::make_shared<Mlp>(std::move(network), std::move(x), std::move(y));
}

}  // namespace plantloop::identify
