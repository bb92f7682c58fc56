// Model files into ports and kernels.

#include "learned/map_block.h"

#include <fmt/format.h>

namespace plantloop {

void MapKernel::evaluate(const KernelCall& call) const {
  map_->evaluate(call.in, call.out, call.scratch);
  if (with_variance_) map_->variance(call.in, call.out + map_->outputs(), call.scratch);
}

bool MapKernel::derivative(const KernelCall& call, double* jacobian) const {
  map_->derivative(call.in, jacobian, call.scratch);
  if (with_variance_) map_->variance_derivative(call.in, jacobian + map_->outputs() * map_->inputs(), call.scratch);
  return true;
}

Shape shape_of(int elements) { return elements == 1 ? Shape::scalar() : Shape::vector(elements); }

Array array_of(const std::vector<Value>& values, int first, int count) {
  Array array(shape_of(count));
  for (int i = 0; i < count; ++i) array[i] = values[static_cast<std::size_t>(first + i)];
  return array;
}

Shape square_of(int rows) { return rows == 1 ? Shape::scalar() : Shape::matrix(rows, rows); }

Array square_array(const std::vector<Value>& values, int first, int rows) {
  Array square(square_of(rows));
  for (int i = 0; i < rows * rows; ++i) square[i] = values[static_cast<std::size_t>(first + i)];
  return square;
}

Array diagonal_of(const Array& square) {
  Array diagonal(shape_of(square.rows()));
  for (int i = 0; i < square.rows(); ++i) diagonal[i] = square[i * (square.rows() + 1)];
  return diagonal;
}

Array diagonal_matrix(const Array& diagonal) {
  Array square(square_of(diagonal.size()), 0.0);
  for (int i = 0; i < diagonal.size(); ++i) square[i * (diagonal.size() + 1)] = diagonal[i];
  return square;
}

std::shared_ptr<const identify::LoadedModel> model_of(const Text& file) {
  const std::string path = file.value();
  if (path.empty()) return nullptr;
  auto model = identify::load_model(path);
  return model->error.empty() && model->map ? model : nullptr;
}

bool report_model(Checking& checking, const Text& file, std::string_view type) {
  const std::string path = file.value();
  if (path.empty()) return false;  // reported where the file is named
  const auto model = identify::load_model(path);
  if (!model->error.empty()) {
    checking.problem(file, model->error);
    return false;
  }
  if (model->linear) {
    checking.problem(file, fmt::format("'{}' holds a linear model; the block linear_model runs it", path));
    return false;
  }
  if (model->neural) {
    checking.problem(file,
                     fmt::format("'{}' holds a neural state-space model; the block neural_state_space runs it", path));
    return false;
  }
  if (type.empty() || model->map->type() == type) return true;
  checking.problem(
      file, fmt::format("'{}' holds a model of type '{}'; a block of that type runs it", path, model->map->type()));
  return false;
}

void MapBlock::sizes(Sizing& sizing) const {
  const auto loaded = model_of(model);
  if (!loaded) return;
  sizing.expect(x, shape_of(loaded->map->inputs()));
  sizing.set(y, shape_of(loaded->map->outputs()));
}

void MapBlock::outputs(Now now, Out out) const {
  const auto loaded = model_of(model);
  if (!loaded) return;
  const Array in = now[x].spread(shape_of(loaded->map->inputs()));
  std::vector<Value> values;
  for (int i = 0; i < in.size(); ++i) values.push_back(in[i]);
  out[y] = array_of(now.kernel(std::make_shared<MapKernel>(loaded->map, false), values), 0, loaded->map->outputs());
}

}  // namespace plantloop
