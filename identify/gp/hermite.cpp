// Recursions from degree to degree.

#include "identify/gp/hermite.h"

#include <cmath>
#include <map>

namespace plantloop::identify {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

MultiIndices::MultiIndices(int variables, Index most) {
  std::vector<std::vector<int>> all{std::vector<int>(static_cast<std::size_t>(variables), 0)};
  begin_ = {0, 1};
  const auto wanted = [&] { return degrees_ == 0 ? 1 + static_cast<int>(most_factors) : degrees_; };
  // Each index of the next degree once: more of its last variable, or of a later one.
  for (int degree = 1; degrees_ == 0 || degree <= wanted(); ++degree) {
    for (Index i = begin(degree - 1); i < end(degree - 1); ++i) {
      std::size_t last = 0;
      for (std::size_t v = 0; v < all[static_cast<std::size_t>(i)].size(); ++v) {
        if (all[static_cast<std::size_t>(i)][v] > 0) last = v;
      }
      for (std::size_t v = last; v < static_cast<std::size_t>(variables); ++v) {
        std::vector<int> one = all[static_cast<std::size_t>(i)];
        ++one[v];
        all.push_back(std::move(one));
      }
    }
    begin_.push_back(static_cast<Index>(all.size()));
    // The next degree would be too many: what stands beyond serves the factors.
    const bool full = degree > 1 && static_cast<Index>(all.size()) - 1 > most;
    if (degrees_ == 0 && full) degrees_ = degree - 1 + static_cast<int>(most_factors);
  }
  degrees_ -= static_cast<int>(most_factors);
  const auto count = static_cast<Index>(all.size());
  std::map<std::vector<int>, int> place;
  for (Index i = 0; i < count; ++i) place[all[static_cast<std::size_t>(i)]] = static_cast<int>(i);
  power_.resize(variables, count);
  up_.resize(variables, count);
  down_.resize(variables, count);
  for (Index i = 0; i < count; ++i) {
    for (int v = 0; v < variables; ++v) {
      std::vector<int> one = all[static_cast<std::size_t>(i)];
      int& power = one[static_cast<std::size_t>(v)];
      power_(v, i) = power;
      const auto at = [&](int step) {
        power += step;
        const auto found = place.find(one);
        power -= step;
        return found == place.end() ? -1 : found->second;
      };
      up_(v, i) = at(1);
      down_(v, i) = at(-1);
    }
  }
}

HermiteSeries::HermiteSeries(const KernelMoments& moments, const MultiIndices& indices)
    : moments_(moments), indices_(indices) {
  const Index n = moments.q.size(), count = indices.end(indices.degrees() + static_cast<int>(most_factors));
  for (const TermMoments& part : moments.parts) {
    Term term{part.pull.transpose() * moments.root, moments.root.transpose() * part.bend * moments.root, {}, {}};
    term.level.assign(part.slope.size() + 1, MatrixXd(n, count));
    term.done.assign(part.slope.size() + 1, -1);
    terms_.push_back(std::move(term));
  }
}

// Fills one more degree of a level; the level before it is known one degree further.
void HermiteSeries::advance(Term& term, const TermMoments& part, std::size_t level, int degree) const {
  MatrixXd& c = term.level[level];
  const int r = indices_.variables();
  for (Index k = indices_.begin(degree); k < indices_.end(degree); ++k) {
    if (level == 0 && degree == 0) {
      c.col(k) = part.base;
    } else if (level == 0) {
      int d = 0;
      while (indices_.power(k, d) == 0) ++d;
      const Index before = indices_.down(k, d);
      c.col(k) = term.p.col(d).cwiseProduct(c.col(before));
      for (int e = 0; e < r; ++e) {
        if (const Index two = indices_.down(before, e); two >= 0)
          c.col(k) -= term.Q(d, e) * std::sqrt(indices_.power(before, e)) * c.col(two);
      }
      c.col(k) /= std::sqrt(indices_.power(k, d));
    } else {
      const MatrixXd& of = term.level[level - 1];
      const MatrixXd slope = part.slope[level - 1].transpose() * moments_.root;  // N x r
      c.col(k) = part.value[level - 1].cwiseProduct(of.col(k));
      for (int d = 0; d < r; ++d) {
        VectorXd beside = std::sqrt(indices_.power(k, d) + 1) * of.col(indices_.up(k, d));
        if (const Index less = indices_.down(k, d); less >= 0) beside += std::sqrt(indices_.power(k, d)) * of.col(less);
        c.col(k) += slope.col(d).cwiseProduct(beside);
      }
    }
  }
  term.done[level] = degree;
}

MatrixXd HermiteSeries::next() {
  ++degree_;
  const Index first = indices_.begin(degree_), columns = indices_.end(degree_) - first;
  MatrixXd sum = MatrixXd::Zero(moments_.q.size(), columns);
  for (std::size_t t = 0; t < terms_.size(); ++t) {
    Term& term = terms_[t];
    const std::size_t factors = term.level.size() - 1;
    for (std::size_t level = 0; level <= factors; ++level) {
      const int to = degree_ + static_cast<int>(factors - level);
      while (term.done[level] < to) advance(term, moments_.parts[t], level, term.done[level] + 1);
    }
    sum += term.level.back().middleCols(first, columns);
  }
  return sum;
}

}  // namespace plantloop::identify
