// Delay equations by the method of steps, to rounding: collocation on short pieces whose nodes fall on those of one
// delay before, so nothing is interpolated on the way.

#pragma once

#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

namespace plantloop {

class PiecewisePolynomial {
 public:
  static constexpr int n = 12;  // nodes of a piece
  explicit PiecewisePolynomial(double piece) : piece_(piece) {}

  // Chebyshev and Lobatto's points in [0, 1].
  static double node(int i) {
    const double swing = std::sin(std::numbers::pi * i / (2.0 * (n - 1)));
    return swing * swing;
  }
  // Weights of the integral from 0 to node(i) of what goes through values at the nodes, by Gauss-Legendre's five-point
  // rule on sixteen parts (exact for polynomials of this degree on each).
  static const std::array<std::array<double, n>, n>& integrals() {
    static const auto table = [] {
      std::array<std::array<double, n>, n> w{};
      const double x[5] = {0, 0.5384693101056831, -0.5384693101056831, 0.9061798459386640, -0.9061798459386640};
      const double g[5] = {0.5688888888888889, 0.4786286704993665, 0.4786286704993665, 0.2369268850561891,
                           0.2369268850561891};
      constexpr int parts = 16;
      for (int i = 1; i < n; ++i) {
        for (int part = 0; part < parts; ++part) {
          const double h = node(i) / parts;
          for (int q = 0; q < 5; ++q) {
            const double at = h * (part + 0.5 + 0.5 * x[q]);
            for (int j = 0; j < n; ++j)
              w[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)] += h / 2 * g[q] * lagrange(j, at);
          }
        }
      }
      return w;
    }();
    return table;
  }
  void add(const std::array<double, n>& values) { pieces_.push_back(values); }
  const std::array<double, n>& operator[](std::size_t piece) const { return pieces_[piece]; }
  std::size_t size() const { return pieces_.size(); }
  double operator()(double t) const {
    const auto k = std::min(static_cast<std::size_t>(std::fmax(0.0, t / piece_)), pieces_.size() - 1);
    const double at = t / piece_ - static_cast<double>(k);
    double sum = 0;
    for (int j = 0; j < n; ++j) sum += pieces_[k][static_cast<std::size_t>(j)] * lagrange(j, at);
    return sum;
  }

 private:
  static double lagrange(int j, double at) {
    double product = 1;
    for (int k = 0; k < n; ++k) {
      if (k != j) product *= (at - node(k)) / (node(j) - node(k));
    }
    return product;
  }
  double piece_;
  std::vector<std::array<double, n>> pieces_;
};

// x' = f(t, x, x(t - pieces[0] h), x(t - pieces[1] h), ...), x = past before 0; `h` is the length of a piece.
inline PiecewisePolynomial solve_by_steps(
    const std::function<double(double t, double x, const std::vector<double>& late)>& f, double past,
    const std::vector<std::size_t>& pieces, double h, double stop) {
  constexpr int n = PiecewisePolynomial::n;
  PiecewisePolynomial solution(h);
  const auto& integrals = PiecewisePolynomial::integrals();
  double start = past;
  std::vector<double> late(pieces.size());
  for (std::size_t k = 0; static_cast<double>(k) * h < stop; ++k) {
    std::array<double, n> x, f_at;
    x.fill(start);
    for (int sweep = 0; sweep < 60; ++sweep) {  // Picard: the piece is short, so it contracts
      for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t d = 0; d < pieces.size(); ++d) late[d] = k < pieces[d] ? past : solution[k - pieces[d]][i];
        f_at[i] = f((static_cast<double>(k) + PiecewisePolynomial::node(static_cast<int>(i))) * h, x[i], late);
      }
      for (std::size_t i = 0; i < n; ++i) {
        double sum = 0;
        for (std::size_t j = 0; j < n; ++j) sum += integrals[i][j] * f_at[j];
        x[i] = start + h * sum;
      }
    }
    solution.add(x);
    start = x[n - 1];
  }
  return solution;
}

inline PiecewisePolynomial method_of_steps(const std::function<double(double, double, double)>& f, double past,
                                           double delay, double stop) {
  constexpr std::size_t parts = 8;
  return solve_by_steps([&](double t, double x, const std::vector<double>& late) { return f(t, x, late[0]); }, past,
                        {parts}, delay / parts, stop);
}

// Of two delays that are multiples of a tenth.
inline PiecewisePolynomial method_of_steps_of_two(const std::function<double(double, double, double)>& f, double past,
                                                  double delay, double second, double stop) {
  return solve_by_steps(
      [&](double, double x, const std::vector<double>& late) { return f(x, late[0], late[1]); }, past,
      {static_cast<std::size_t>(std::lround(10 * delay)), static_cast<std::size_t>(std::lround(10 * second))}, 0.1,
      stop);
}

}  // namespace plantloop
