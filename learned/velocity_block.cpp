// Frozen matrices, weighed and recorded; what is 0 in all of them is left out.

#include "learned/velocity_block.h"

#include <fmt/format.h>

#include "engine/base/files.h"
#include "engine/block_delay.h"
#include "identify/error.h"
#include "identify/model_file/model_file.h"
#include "learned/map_block.h"

namespace plantloop {

using Eigen::MatrixXd;
using identify::VelocityFamily;
using identify::VelocityPoint;

namespace {

// An entry of the weighed matrix; known 0 when it is 0 at every point, and no sum when it is the same at all of them.
Value blended(const VelocityFamily& family, const std::vector<Value>& weights, MatrixXd VelocityPoint::*matrix, int i,
              int j) {
  const double first = (family.points.front().*matrix)(i, j);
  bool is_same = true;
  for (const VelocityPoint& point : family.points) is_same = is_same && (point.*matrix)(i, j) == first;
  if (is_same) return first;  // the weights sum to 1
  Value sum = 0;
  for (std::size_t k = 0; k < family.points.size(); ++k) sum = sum + weights[k] * (family.points[k].*matrix)(i, j);
  return sum;
}

Array spread(const Array& values, int count) {
  Array result(shape_of(count));
  for (int i = 0; i < count; ++i) result[i] = values[values.size() == 1 ? 0 : i];
  return result;
}

}  // namespace

std::shared_ptr<const VelocityFamily> VelocityBlock::family(std::string* error) const {
  const std::string path = model.value();
  if (path.empty()) return nullptr;  // reported where the file is named
  const FileResult file = read_file(path);
  std::string why = file.ok() ? "" : fmt::format("cannot read '{}': {}", path, file.error);
  if (file.ok()) {
    try {
      return std::make_shared<const VelocityFamily>(
          identify::velocity_family_of(identify::read_model_file(file.value, path)));
    } catch (const identify::IdentifyError& wrong) {
      why = wrong.what();
    }
  }
  if (error != nullptr) *error = why;
  return nullptr;
}

std::shared_ptr<const VelocityFamily> VelocityBlock::checked(Checking& checking) const {
  std::string error;
  auto f = family(&error);
  if (!f) {
    if (!error.empty()) checking.problem(model, error);
    return nullptr;
  }
  return f;
}

void VelocityBlock::set_sizes(Sizing& sizing, const Output& output, const Output& filtered) const {
  const auto f = family();
  if (!f) return;
  const auto fits = [&](const Table& table, std::size_t count, const char* each) {
    const Shape given = sizing.of(table);
    if (!given.is_known() || given.size() <= 1 || given.size() == static_cast<int>(count)) return;
    sizing.problem(table, fmt::format("expected one number or {}, one for each {}, got {}", count, each, given.size()));
  };
  fits(start, f->outputs.size(), "output");
  fits(rates_at_start, f->states.size(), "state");
  fits(input_at_start, f->inputs.size(), "input");
  sizing.expect(u, shape_of(static_cast<int>(f->inputs.size())));
  sizing.set(w, shape_of(static_cast<int>(f->states.size())));
  sizing.set(uf, shape_of(static_cast<int>(f->inputs.size())));
  sizing.set(integral, shape_of(static_cast<int>(f->outputs.size())));
  sizing.set(output, shape_of(static_cast<int>(f->outputs.size())));
  sizing.set(filtered, shape_of(static_cast<int>(f->inputs.size())));
}

void VelocityBlock::initial(Now now, Init init) const {
  const auto f = family();
  if (!f) return;
  const auto outputs = static_cast<int>(f->outputs.size());
  init[uf] = spread(now.given(input_at_start) ? now[input_at_start] : now[u], static_cast<int>(f->inputs.size()));
  init[w] = spread(now[rates_at_start], static_cast<int>(f->states.size()));
  if (now.given(start)) {
    init[integral] = spread(now[start], outputs);
  } else {
    Array first(shape_of(outputs));
    for (int i = 0; i < outputs; ++i) first[i] = f->points.front().y[i];
    init[integral] = first;
  }
}

void VelocityBlock::derivatives(Now now, Rates rate) const {
  const auto f = family();
  if (!f) return;
  const Weights mu = weights(now, *f);
  const int n = static_cast<int>(f->states.size()), drives = static_cast<int>(f->inputs.size());
  const bool is_sampled = f->Ts > 0;
  const Value pole = now.given(N) ? now[N][0] : Value(is_sampled ? 100 / f->Ts : 100);
  const Array speed = pole * (spread(now[u], drives) - now[uf]);
  const auto product = [&](MatrixXd VelocityPoint::*by_state, MatrixXd VelocityPoint::*by_input, int rows,
                           const Array& x) {
    Array result(shape_of(rows));
    for (int i = 0; i < rows; ++i) {
      Value sum = 0;
      for (int j = 0; j < n; ++j) sum = sum + blended(*f, mu.of_states, by_state, i, j) * x[j];
      for (int j = 0; j < drives; ++j) sum = sum + blended(*f, mu.of_inputs, by_input, i, j) * speed[j];
      result[i] = sum;
    }
    return result;
  };
  Array x = now[w];
  rate[uf] = speed;
  if (is_sampled) {
    // What the first sample changes comes as the inputs do: as a pulse of the filter, since a jump has no derivative.
    const Array pulse = pole * x;
    rate[w] = -1.0 * pulse;
    x = delayed_loop(now, shape_of(n), {.delay = f->Ts, .past = Value(0)},
                     [&](const Array& late) { return product(&VelocityPoint::A, &VelocityPoint::B, n, late) + pulse; });
  } else {
    rate[w] = product(&VelocityPoint::A, &VelocityPoint::B, n, x);
  }
  rate[integral] = product(&VelocityPoint::C, &VelocityPoint::D, static_cast<int>(f->outputs.size()), x);
}

}  // namespace plantloop
