// One step of an explicit method in as few passes over the state as its table allows, and its dense output.

#include "engine/solve/stages.h"

#include <cassert>

#include "engine/solve/passes.h"

namespace plantloop {
namespace {

std::size_t size_of(OdeSystem& system) { return static_cast<std::size_t>(system.size()); }

}  // namespace

Stages::Stages(OdeSystem& system, const Tableau& tableau)
    : system_(system),
      tableau_(tableau),
      n_(size_of(system)),
      stage_count_(static_cast<std::int64_t>(tableau.stages())),
      state_(system.state()),
      low_storage_(tableau.low_storage()),
      room_(n_ * (tableau.stages() + 1)),
      x0_(n_),
      x1_(n_),
      accumulated_(n_),
      d1_(n_),
      d2_(n_),
      d3_(n_),
      d4_(tableau.bubble.empty() ? 0 : n_) {
  assert(tableau.stages() + 1 <= most_terms);
  for (std::size_t i = 0; i < tableau.stages(); ++i) {
    const bool last = i + 1 == tableau.stages();
    table_.push_back({tableau.b[i], last ? 0 : tableau.a[i].back(), i == 0 ? 0 : tableau.c[i - 1]});
  }
  for (std::size_t i = 0; i <= tableau.stages(); ++i) k_.push_back(room_.data() + i * n_);
}

const double* Stages::derivatives(double t) {
  ++statistics.evaluations;
  return system_.derivatives(t);
}

void Stages::by_method(double t, double t_end, double h) {
  const double* const first = has_start_ ? k_.front() : derivatives(t);
  if (!low_storage_) copy(state_, x0_.data());
  try {
    if (low_storage_) {
      low_storage(t, t_end, h, first);
    } else {
      general(t, t_end, h, first);
    }
  } catch (...) {
    revert();
    throw;
  }
}

// One pass per stage: it adds the derivative to the sum of the result and writes the state of the next stage.
void Stages::low_storage(double t, double t_end, double h, const double* first) {
  double* const __restrict x = state_;
  double* const __restrict x0 = x0_.data();
  double* const __restrict sum = accumulated_.data();
  const Stage* const table = table_.data();
  const std::size_t stages = table_.size();
  const double to_result = h * table[0].b;
  if (stages == 1) {
    for_each_state(n_, [=](std::size_t i) {
      x0[i] = x[i];
      x[i] = x[i] + to_result * first[i];
    });
    return;
  }
  const double to_second = h * table[0].next;
  for_each_state(n_, [=](std::size_t i) {
    const double before = x[i];
    x0[i] = before;
    sum[i] = before + to_result * first[i];
    x[i] = before + to_second * first[i];
  });
  for (std::size_t stage = 1; stage < stages; ++stage) {
    const double c = table[stage].c;
    const double* const k = derivatives(c == 1 ? t_end : t + c * h);
    const double b = h * table[stage].b;
    if (stage + 1 == stages) {
      for_each_state(n_, [=](std::size_t i) { x[i] = sum[i] + b * k[i]; });
      return;
    }
    const double a = h * table[stage].next;
    for_each_state(n_, [=](std::size_t i) {
      sum[i] += b * k[i];
      x[i] = x0[i] + a * k[i];
    });
  }
}

// Any table: each pass keeps the fresh derivative and combines it with those before. `first` is k_1, kept or fresh.
void Stages::general(double t, double t_end, double h, const double* first) {
  double* const x = state_;
  const double* const x0 = x0_.data();
  const std::size_t stages = tableau_.stages();
  const double* fresh = first;
  for (std::size_t stage = 0; stage < stages; ++stage) {
    const std::vector<double>& row = stage + 1 == stages ? tableau_.b : tableau_.a[stage];
    Terms terms;
    for (std::size_t j = 0; j < stage; ++j) {
      if (row[j] != 0) terms.add(k_[j], h * row[j]);
    }
    terms.add(fresh, h * row[stage]);
    double* const keep = k_[stage];
    with_terms(terms, [=, this](auto sum) {
      if (fresh == keep) {
        for_each_state(n_, [=](std::size_t i) { x[i] = sum(i, x0[i]); });
      } else {
        for_each_state(n_, [=](std::size_t i) {
          keep[i] = fresh[i];
          x[i] = sum(i, x0[i]);
        });
      }
    });
    if (stage + 1 < stages) fresh = derivatives(tableau_.c[stage] == 1 ? t_end : t + tableau_.c[stage] * h);
  }
  has_start_ = has_stages_ = true;
}

void Stages::prepare(double t) {
  std::copy_n(state_, n_, x0_.data());
  if (has_start_) return;
  std::copy_n(derivatives(t), n_, k_.front());
  has_start_ = true;
}

void Stages::attempt(double t, double t_end, double h) {
  general(t, t_end, h, k_.front());
  std::copy_n(derivatives(t_end), n_, k_.back());
  has_end_ = true;
}

void Stages::revert() {
  std::copy_n(x0_.data(), n_, state_);
  has_end_ = has_stages_ = false;
}

Terms Stages::error_terms(double h) const {
  Terms terms;
  for (std::size_t j = 0; j < tableau_.error.size(); ++j) {
    if (tableau_.error[j] != 0) terms.add(k_[j], h * tableau_.error[j]);
  }
  return terms;
}

// Hairer, Norsett, Wanner II.6: x0 + s (d1 + (1 - s) (d2 + s (d3 + (1 - s) d4))), s = (t - t0) / h.
void Stages::make_dense() {
  double* const x = state_;
  if (!has_after_) {
    std::copy_n(x, n_, x1_.data());
    has_after_ = true;
    if (!has_end_) {
      std::copy_n(derivatives(t1_), n_, k_.back());
      has_end_ = true;
    }
  }
  const bool needs_stages = !tableau_.bubble.empty();
  if (!has_start_ || (needs_stages && !has_stages_)) {
    std::copy_n(x0_.data(), n_, x);
    if (!has_start_) std::copy_n(derivatives(t0_), n_, k_.front());
    has_start_ = true;
    if (needs_stages) general(t0_, t1_, h_, k_.front());
    std::copy_n(x1_.data(), n_, x);
  }
  const double* const x0 = x0_.data();
  const double* const x1 = x1_.data();
  const double* const first = k_.front();
  const double* const last = k_.back();
  double* const d1 = d1_.data();
  double* const d2 = d2_.data();
  double* const d3 = d3_.data();
  const double h = h_;
  for_each_state(n_, [=](std::size_t i) {
    const double difference = x1[i] - x0[i];
    const double bend = h * first[i] - difference;
    d1[i] = difference;
    d2[i] = bend;
    d3[i] = difference - h * last[i] - bend;
  });
  if (needs_stages) {
    Terms terms;
    for (std::size_t j = 0; j < tableau_.bubble.size(); ++j) {
      if (tableau_.bubble[j] != 0) terms.add(k_[j], h * tableau_.bubble[j]);
    }
    double* const d4 = d4_.data();
    with_terms(terms, [=, this](auto sum) { for_each_state(n_, [=](std::size_t i) { d4[i] = sum(i, 0.0); }); });
  }
  dense_ = true;
}

void Stages::interpolate(double t, double* out) {
  if (!dense_) make_dense();
  if (t == t0_ || t == t1_) {
    std::copy_n(t == t1_ ? x1_.data() : x0_.data(), n_, out);
    return;
  }
  const double s = (t - t0_) / h_;
  const double r = 1 - s;
  const double* const x0 = x0_.data();
  const double* const d1 = d1_.data();
  const double* const d2 = d2_.data();
  const double* const d3 = d3_.data();
  if (d4_.empty()) {
    for_each_state(n_, [=](std::size_t i) { out[i] = x0[i] + s * (d1[i] + r * (d2[i] + s * d3[i])); });
    return;
  }
  const double* const d4 = d4_.data();
  for_each_state(n_, [=](std::size_t i) { out[i] = x0[i] + s * (d1[i] + r * (d2[i] + s * (d3[i] + r * d4[i]))); });
}

}  // namespace plantloop
