// Continuous diagrams by their Jacobians; sampled ones by following the map of one whole period, hit by hit.

#include "engine/analysis/linearise.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "engine/analysis/linear_program.h"
#include "engine/analysis/trim_point.h"

namespace plantloop {

namespace {

// Rows of states, discrete states and held values in terms of all of them and the inputs.
class PeriodMap {
 public:
  PeriodMap(LinearProgram& program, const DenseMatrix& flow)
      : program_(program), size_(program.size()), n_(size_.states + size_.discretes + size_.held) {
    const DenseMatrix a = flow.block(0, 0, size_.states, size_.columns());
    // d/dt [x; d; h; u] with all but x at rest.
    flow_ = DenseMatrix(n_ + size_.probes, n_ + size_.probes);
    for (std::size_t i = 0; i < size_.states; ++i) {
      for (std::size_t j = 0; j < size_.states; ++j) flow_(i, j) = a(i, j);
      for (std::size_t j = 0; j < size_.held; ++j)
        flow_(i, size_.states + size_.discretes + j) = a(i, size_.first_held() + j);
      for (std::size_t j = 0; j < size_.probes; ++j) flow_(i, n_ + j) = a(i, size_.first_probe() + j);
    }
  }

  // [x; d; h; u] after a hit of a set of rates.
  DenseMatrix hit(std::size_t set, std::size_t watches, DenseMatrix* outputs) {
    const Program& p = *program_.program;
    const Mask bits = program_.pattern.sets[set];
    const DenseMatrix entries = program_.evaluate(p.linear.hits[set], size_.held + size_.discretes + watches);
    DenseMatrix m = DenseMatrix::identity(n_ + size_.probes);
    const std::size_t first_held = size_.states + size_.discretes;
    for (std::size_t h = 0; h < size_.held; ++h) {
      if ((p.linear.held_masks[h] & bits) != 0) put(entries, h, m, first_held + h);
    }
    for (std::size_t d = 0; d < size_.discretes; ++d) {
      if ((rate_bit(p.discrete_rates[d]) & bits) != 0) put(entries, size_.held + d, m, size_.states + d);
    }
    if (outputs != nullptr) {
      *outputs = DenseMatrix(watches, n_ + size_.probes);
      for (std::size_t w = 0; w < watches; ++w) put(entries, size_.held + size_.discretes + w, *outputs, w);
    }
    return m;
  }

  DenseMatrix flow_for(double time) const { return exponential(flow_, time); }
  std::size_t size() const { return n_; }

 private:
  // A row in the columns of the program, in the order of the map.
  void put(const DenseMatrix& entries, std::size_t from, DenseMatrix& m, std::size_t row) const {
    for (std::size_t j = 0; j < m.columns; ++j) m(row, j) = 0;
    for (std::size_t j = 0; j < size_.states + size_.discretes; ++j) m(row, j) = entries(from, j);
    for (std::size_t j = 0; j < size_.held; ++j)
      m(row, size_.states + size_.discretes + j) = entries(from, size_.first_held() + j);
    for (std::size_t j = 0; j < size_.probes; ++j) m(row, n_ + j) = entries(from, size_.first_probe() + j);
  }

  LinearProgram& program_;
  Sensitivity size_;
  std::size_t n_;
  DenseMatrix flow_;
};

void name_and_value(LinearProgram& p, LinearModel& model) {
  const Program& program = *p.program;
  model.states = program.state_names;
  model.x.assign(p.frame->states(), p.frame->states() + program.state_names.size());
  for (const RecordedProbe& probe : p.probes) model.inputs.push_back(probe.name);
  model.outputs = p.outputs;
  p.evaluate_outputs();
  for (std::size_t i = 0; i < p.outputs.size(); ++i) model.y.push_back(p.output(i));
  model.time = p.frame->arena[program.time];
  model.without_derivative = program.linear.missing;
}

void linearise_flow(LinearProgram& p, LinearModel& model) {
  const Sensitivity size = p.size();
  const std::size_t n = size.states, m = size.probes, outputs = p.outputs.size();
  const DenseMatrix flow = p.evaluate(p.program->linear.flow, n + p.program->watch_list.roots.size());
  model.A = flow.block(0, 0, n, n);
  model.B = flow.block(0, size.first_probe(), n, m);
  model.C = flow.block(n, 0, outputs, n);
  model.D = flow.block(n, size.first_probe(), outputs, m);
}

// States that nothing later depends on, as held values that the first hit computes anew, are left out.
void leave_out_idle(LinearModel& model, std::size_t first) {
  for (bool again = true; again;) {
    again = false;
    for (std::size_t k = model.states.size(); k-- > first;) {
      bool matters = false;
      for (std::size_t i = 0; i < model.A.rows; ++i) matters = matters || (i != k && model.A(i, k) != 0);
      for (std::size_t i = 0; i < model.C.rows; ++i) matters = matters || model.C(i, k) != 0;
      // What only carries itself on, never set by anything, is a constant.
      if (matters) continue;
      const auto without_row = [k](const DenseMatrix& m, bool column_too) {
        DenseMatrix out(m.rows - 1, column_too ? m.columns - 1 : m.columns);
        for (std::size_t i = 0; i < out.rows; ++i) {
          for (std::size_t j = 0; j < out.columns; ++j)
            out(i, j) = m(i < k ? i : i + 1, column_too && j >= k ? j + 1 : j);
        }
        return out;
      };
      DenseMatrix c(model.C.rows, model.C.columns - 1);
      for (std::size_t i = 0; i < c.rows; ++i) {
        for (std::size_t j = 0; j < c.columns; ++j) c(i, j) = model.C(i, j < k ? j : j + 1);
      }
      model.A = without_row(model.A, true);
      model.B = without_row(model.B, false);
      model.C = c;
      model.states.erase(model.states.begin() + static_cast<std::ptrdiff_t>(k));
      model.x.erase(model.x.begin() + static_cast<std::ptrdiff_t>(k));
      again = true;
    }
  }
}

void linearise_period(LinearProgram& p, LinearModel& model) {
  const Sensitivity size = p.size();
  const std::size_t watches = p.program->watch_list.roots.size();
  PeriodMap map(p, p.evaluate(p.program->linear.flow, size.states + watches));
  std::map<std::pair<std::size_t, double>, DenseMatrix> pieces;  // hit and flow of equal kind and length
  DenseMatrix outputs, whole;
  for (std::size_t i = 0; i < p.pattern.set_at.size(); ++i) {
    const std::size_t set = p.pattern.set_at[i];
    const double time = p.pattern.after[i];
    auto piece = pieces.find({set, time});
    if (piece == pieces.end() || i == 0) {
      const DenseMatrix hit = map.hit(set, watches, i == 0 ? &outputs : nullptr);
      piece = pieces.insert_or_assign({set, time}, product(map.flow_for(time), hit)).first;
    }
    whole = i == 0 ? piece->second : product(piece->second, whole);
  }
  const std::size_t n = map.size(), m = size.probes, shown = p.outputs.size();
  model.period = p.pattern.period;
  model.A = whole.block(0, 0, n, n);
  model.B = whole.block(0, n, n, m);
  model.C = outputs.block(0, 0, shown, n);
  model.D = outputs.block(0, n, shown, m);
  for (std::size_t d = 0; d < size.discretes; ++d) {
    model.states.push_back(p.program->discrete_names[d]);
    model.x.push_back(p.frame->arena[p.program->discretes[d]]);
  }
  for (std::size_t h = 0; h < size.held; ++h) {
    model.states.push_back("held " + p.program->linear.held_names[h]);
    model.x.push_back(std::nan(""));
  }
  leave_out_idle(model, size.states + size.discretes);
}

}  // namespace

std::optional<LinearModel> linearise(const std::shared_ptr<const Model>& model, const LineariseRequest& request,
                                     Report& report) {
  const auto p = make_linear_program(model, request.set, request.inputs, request.open, request.outputs, report);
  if (!p) return std::nullopt;
  p->go_to(request.at);
  if (request.trim) {
    const Trim rest = go_to_rest(*p, TrimPoint{});
    if (!rest.converged) {
      report.error({}, "no rest was found to linearise at: {}", rest.why);
      return std::nullopt;
    }
  }
  LinearModel result;
  name_and_value(*p, result);
  if (p->pattern.period > 0 && !request.hold) {
    linearise_period(*p, result);
  } else {
    linearise_flow(*p, result);
  }
  for (const std::string& block : result.without_derivative) {
    report.warning({}, "the derivative of block '{}' is not known: what passes through it is not in the linear model",
                   block);
  }
  const auto check = [&](const DenseMatrix& m) {
    for (const double v : m.values) {
      if (!std::isfinite(v)) return false;
    }
    return true;
  };
  if (!check(result.A) || !check(result.B) || !check(result.C) || !check(result.D))
    report.warning({}, "the linear model has entries that are not finite: the point lies on an edge of a function");
  return result;
}

}  // namespace plantloop
