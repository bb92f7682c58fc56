// The dual active-set method.
//
// H = L L', J = L^-T Q, and J' N = [R; 0] for the normals N of the active constraints. A step towards a violated
// constraint goes along z = J2 J2' n in x and along r = R^-1 J1' n in the multipliers; it is as long as all multipliers
// stay positive.

#include "control/quadratic_program.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace plantloop {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double rounding = 1e-13;

double dot(const double* a, const double* b, int n) {
  double sum = 0;
  for (int i = 0; i < n; ++i) sum += a[i] * b[i];
  return sum;
}

}  // namespace

QuadraticProgram::QuadraticProgram(int variables, int constraints, Room& room) : size_(variables) {
  const auto n = static_cast<std::size_t>(variables), m = static_cast<std::size_t>(constraints);
  H = room.take(n * n);
  g = room.take(n);
  A = room.take(m * n);
  b = room.take(m);
  x = room.take(n);
  multiplier = room.take(m);
  J_ = room.take(n * n);
  R_ = room.take(n * n);
  d_ = room.take(n);
  z_ = room.take(n);
  r_ = room.take(n);
  u_ = room.take(n + 1);
  active_ = room.take(n + 1);
  scale_ = room.take(m);
}

// J = L^-T; false when H is not positive definite. R's room holds L meanwhile.
bool QuadraticProgram::factor(int n) {
  double* const L = R_;
  double greatest = 0;
  for (int i = 0; i < n; ++i) greatest = std::max(greatest, H[i * n + i]);
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j <= i; ++j) {
      const double rest = H[i * n + j] - dot(L + i * n, L + j * n, j);
      if (i != j) {
        L[i * n + j] = rest / L[j * n + j];
      } else if (rest > rounding * greatest) {
        L[i * n + i] = std::sqrt(rest);
      } else {
        return false;
      }
    }
  }
  std::fill_n(J_, n * n, 0.0);
  for (int column = 0; column < n; ++column) {  // of L^-1, which is a row of J
    for (int i = column; i < n; ++i) {
      double sum = i == column ? 1.0 : 0.0;
      for (int k = column; k < i; ++k) sum -= L[i * n + k] * J_[column * n + k];
      J_[column * n + i] = sum / L[i * n + i];
    }
  }
  return true;
}

int QuadraticProgram::most_violated(int n, int m, double* excess) const {
  int worst = -1;
  double most = 0;
  for (int i = 0; i < m; ++i) {
    const double value = dot(A + i * n, x, n), over = b[i] - value;
    const double unsure = rounding * (std::abs(b[i]) + std::abs(value) + scale_[i]);
    if (over <= 10 * unsure || over <= most * scale_[i]) continue;
    bool is_active = false;
    for (int k = 0; k < count_; ++k) is_active = is_active || static_cast<int>(active_[k]) == i;
    if (is_active) continue;
    most = over / scale_[i];
    *excess = over;
    worst = i;
  }
  return worst;
}

// d = J'n, z = J2 d2, r = R^-1 d1.
void QuadraticProgram::direction(int n, const double* normal) {
  std::fill_n(d_, n, 0.0);
  for (int i = 0; i < n; ++i) {
    if (normal[i] == 0) continue;
    for (int k = 0; k < n; ++k) d_[k] += J_[i * n + k] * normal[i];
  }
  for (int i = 0; i < n; ++i) z_[i] = dot(J_ + i * n + count_, d_ + count_, n - count_);
  for (int i = count_ - 1; i >= 0; --i) {
    double sum = d_[i];
    for (int k = i + 1; k < count_; ++k) sum -= R_[i * size_ + k] * r_[k];
    r_[i] = sum / R_[i * size_ + i];
  }
}

// Rotates J so that only d[count] is left of d2; false when the new normal depends on the active ones.
bool QuadraticProgram::take_in(int n, int constraint) {
  for (int k = n - 1; k > count_; --k) {
    const double length = std::hypot(d_[k - 1], d_[k]);
    if (length == 0) continue;
    const double c = d_[k - 1] / length, s = d_[k] / length;
    d_[k - 1] = length;
    d_[k] = 0;
    for (int i = 0; i < n; ++i) {
      double& a = J_[i * n + k - 1];
      double& e = J_[i * n + k];
      const double turned = c * a + s * e;
      e = c * e - s * a;
      a = turned;
    }
  }
  double greatest = 0;
  for (int k = 0; k < count_; ++k) greatest = std::max(greatest, std::abs(d_[k]));
  if (std::abs(d_[count_]) <= rounding * greatest) return false;
  for (int k = 0; k <= count_; ++k) R_[k * size_ + count_] = d_[k];
  active_[count_] = constraint;
  ++count_;
  return true;
}

void QuadraticProgram::drop(int n, int place) {
  for (int k = place; k + 1 < count_; ++k) {
    active_[k] = active_[k + 1];
    u_[k] = u_[k + 1];
    for (int i = 0; i < count_; ++i) R_[i * size_ + k] = R_[i * size_ + k + 1];
  }
  u_[count_ - 1] = u_[count_];  // that of the one that comes in
  --count_;
  for (int k = place; k < count_; ++k) {
    const double p = R_[k * size_ + k], q = R_[(k + 1) * size_ + k];
    const double length = std::hypot(p, q);
    if (length == 0) continue;
    const double c = p / length, s = q / length;
    for (int j = k; j < count_; ++j) {
      double& a = R_[k * size_ + j];
      double& e = R_[(k + 1) * size_ + j];
      const double turned = c * a + s * e;
      e = c * e - s * a;
      a = turned;
    }
    for (int i = 0; i < n; ++i) {
      double& a = J_[i * n + k];
      double& e = J_[i * n + k + 1];
      const double turned = c * a + s * e;
      e = c * e - s * a;
      a = turned;
    }
  }
}

QuadraticProgram::Outcome QuadraticProgram::solve(int n, int m) {
  count_ = 0;
  std::fill_n(multiplier, m, 0.0);
  if (!factor(n)) return Outcome::not_convex;
  for (int i = 0; i < m; ++i) scale_[i] = std::max(std::sqrt(dot(A + i * n, A + i * n, n)), 1e-300);
  // x = -J J' g.
  for (int k = 0; k < n; ++k) {
    d_[k] = 0;
    for (int i = 0; i < n; ++i) d_[k] += J_[i * n + k] * g[i];
  }
  for (int i = 0; i < n; ++i) x[i] = -dot(J_ + i * n, d_, n);

  int budget = 50 * (n + m);  // far more than any but a degenerate problem takes
  double excess = 0;
  for (int p = most_violated(n, m, &excess); p >= 0; p = most_violated(n, m, &excess)) {
    const double* const normal = A + p * n;
    u_[count_] = 0;
    for (bool whole = false; !whole;) {
      if (--budget < 0) return Outcome::stopped;
      direction(n, normal);
      double longest = infinity;
      int blocking = -1;
      for (int k = 0; k < count_; ++k) {
        if (r_[k] > 0 && u_[k] < longest * r_[k]) {
          longest = u_[k] / r_[k];
          blocking = k;
        }
      }
      const double along = dot(z_, normal, n), all = dot(d_, d_, n);
      const double full = count_ < n && along > rounding * all ? excess / along : infinity;
      const double t = std::min(longest, full);
      if (t == infinity) return Outcome::infeasible;
      for (int k = 0; k < count_; ++k) u_[k] -= t * r_[k];
      u_[count_] += t;
      if (full < infinity) {
        for (int i = 0; i < n; ++i) x[i] += t * z_[i];
        excess = b[p] - dot(normal, x, n);
      }
      whole = full <= longest;
      if (whole) {
        if (!take_in(n, p)) return Outcome::stopped;
      } else {
        drop(n, blocking);
      }
    }
  }
  for (int k = 0; k < count_; ++k) multiplier[static_cast<int>(active_[k])] = u_[k];
  return Outcome::solved;
}

}  // namespace plantloop
