// Learned maps as blocks: the model file gives the sizes of the ports, and a kernel runs the map.

#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "engine/block.h"
#include "engine/program/kernel.h"
#include "identify/narx/load.h"

namespace plantloop {

// Evaluates a map; outputs y, and behind them the variances when wanted. The numbers are those of the library, bit for
// bit, and the derivative is exact.
class MapKernel final : public Kernel {
 public:
  MapKernel(std::shared_ptr<const identify::Approximator> map, bool with_variance)
      : map_(std::move(map)), with_variance_(with_variance) {}
  std::string name() const override { return "learned map"; }
  bool is_same(const Kernel& other) const override {
    const auto* const map = dynamic_cast<const MapKernel*>(&other);
    return map && map->map_ == map_ && map->with_variance_ == with_variance_;
  }
  int outputs() const override { return (with_variance_ ? 2 : 1) * map_->outputs(); }
  int scratch_size() const override { return map_->scratch_size(); }
  void evaluate(const KernelCall& call) const override;
  bool derivative(const KernelCall& call, double* jacobian) const override;

 private:
  std::shared_ptr<const identify::Approximator> map_;
  bool with_variance_;
};

// A scalar for one element, else a vector.
Shape shape_of(int elements);
// The elements as an Array of that shape.
Array array_of(const std::vector<Value>& values, int first, int count);
// The same for n x n values row by row: a scalar for one, else a matrix; its diagonal, and the matrix of a diagonal.
Shape square_of(int rows);
Array square_array(const std::vector<Value>& values, int first, int rows);
Array diagonal_of(const Array& square);
Array diagonal_matrix(const Array& diagonal);
// The model of the file, or null when it cannot be used (reported by report_model).
std::shared_ptr<const identify::LoadedModel> model_of(const Text& file);
// Says why the model of a file cannot be used; `type`: what it has to be, "" for any. True when it can.
bool report_model(Checking& checking, const Text& file, std::string_view type);

// A static map y = f(x), of one type of model file.
struct MapBlock : Block {
  explicit MapBlock(std::string_view type_) : type(type_) {}
  std::string_view type;

  Text model{this, "model", {.doc = "the model file, as identification writes it", .file = true}};
  Input x{this, "x", {.doc = "what the model was made for, in its order and units", .size = any_size}};
  Output y{this, "y", {.doc = "the outputs of the model", .size = any_size}};

  void check(Checking& checking) const override { report_model(checking, model, type); }
  void sizes(Sizing& sizing) const override;
  void outputs(Now now, Out out) const override;
};

}  // namespace plantloop
