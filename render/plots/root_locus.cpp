// Where the closed loop's poles go as the gain grows.

#include <limits>

#include "render/plots/plane.h"

namespace plantloop {
namespace {

struct RootLocus : Plot {
  System data{this, Need::needed};
  Real gain{this, "gain", 1, "the gain at which the closed loop's poles are marked; 0: none"};
  Flag sampled{this, "sampled", "polynomials in z: the border of stability is the unit circle"};

  RootLocus() : Plot("the roots of den + k num for gains k from 0 to infinity") {}

  void draw(Canvas& canvas, const Given& given) const override {
    const Transfer system = data.system(given);
    const std::vector<Complex> poles = roots(system.den), zeros = roots(system.num);
    // The scale of the gain: that which moves the poles about as far as they are from zero.
    double size = 0;
    for (const Complex p : poles) size = std::max(size, std::abs(p));
    for (const Complex z : zeros) size = std::max(size, std::abs(z));
    if (!(size > 0)) size = 1;
    const double k0 =
        std::abs(value(system.den, 0.7 * size)) / std::max(std::abs(value(system.num, 0.7 * size)), 1e-300);
    std::vector<std::vector<Complex>> branches;
    if (std::isfinite(k0) && k0 > 0) branches = follow(system, poles, k0, size);
    std::vector<Complex> seen = poles;
    seen.insert(seen.end(), zeros.begin(), zeros.end());
    // The view follows the branches that run away as far again as the poles and zeros lie.
    for (const auto& branch : branches)
      for (const Complex p : branch)
        if (std::abs(p) < 2.2 * size) seen.push_back(p);
    const bool first = canvas.panel().series.empty();
    set_plane(canvas, seen, given[sampled]);
    if (first) draw_plane(canvas.panel(), seen, given[sampled]);
    std::vector<double> x, y;
    for (const auto& branch : branches) {
      for (const Complex p : branch) {
        x.push_back(p.real());
        y.push_back(p.imag());
      }
      x.push_back(std::numeric_limits<double>::quiet_NaN());
      y.push_back(std::numeric_limits<double>::quiet_NaN());
    }
    canvas.add(line_series(x, y, given.look), given);
    SeriesLook look = given.look;
    look.same_color = true;
    if (look.size == 0) look.size = 5;
    mark(canvas, given, poles, look, Marker::cross, "open-loop poles");
    mark(canvas, given, zeros, look, Marker::ring, "zeros");
    if (given[gain] != 0 && std::isfinite(given[gain]))
      mark(canvas, given, roots(closed(system, given[gain])), look, Marker::square,
           "closed loop, k = " + short_number(given[gain]));
  }

  Figure example() const override {
    Figure figure{.title = "Root locus, L(s) = k (s+3) / (s (s+1) (s^2+4s+8))"};
    use(figure, 0, {{"num", std::vector<double>{1, 3}}, {"den", std::vector<double>{1, 5, 12, 8, 0}}, {"gain", 2.0}});
    return figure;
  }

 private:
  static double value(const Polynomial& p, double at) {
    double sum = 0;
    for (const double c : p) sum = sum * at + std::abs(c);
    return sum;
  }

  static Polynomial closed(const Transfer& system, double k) {
    Polynomial sum = system.den;
    if (system.num.size() > sum.size()) sum.insert(sum.begin(), system.num.size() - sum.size(), 0.0);
    const std::size_t shift = sum.size() - system.num.size();
    for (std::size_t i = 0; i < system.num.size(); ++i) sum[shift + i] += k * system.num[i];
    return sum;
  }

  // From gain to gain each branch goes on to the root nearest to it. Where roots move far, as at the points where
  // branches meet, the step is halved.
  static std::vector<std::vector<Complex>> follow(const Transfer& system, const std::vector<Complex>& poles, double k0,
                                                  double size) {
    std::vector<std::vector<Complex>> branches;
    for (const Complex p : poles) branches.push_back({p});
    double exponent = -6, step = 0.01;
    while (exponent < 4) {
      std::vector<std::size_t> order;
      const std::vector<Complex> next = roots(closed(system, k0 * std::pow(10.0, exponent + step)));
      const double moved = pair_up(branches, next, order);
      if (moved > 0.01 * size && step > 2e-5 && moved < 3 * size) {
        step /= 2;
        continue;
      }
      for (std::size_t b = 0; b < order.size(); ++b) branches[b].push_back(next[order[b]]);
      exponent += step;
      step = std::min(2 * step, 0.02);
      if (branches.empty() || branches[0].size() > 20000) break;
    }
    return branches;
  }

  // The root that each branch goes on to, the nearest pair of all first; gives the longest way. Nothing when there are
  // not as many roots as branches.
  static double pair_up(const std::vector<std::vector<Complex>>& branches, const std::vector<Complex>& next,
                        std::vector<std::size_t>& order) {
    if (next.size() != branches.size()) return 0;
    order.assign(branches.size(), next.size());
    std::vector<bool> taken(next.size());
    double longest = 0;
    for (std::size_t step = 0; step < branches.size(); ++step) {
      std::size_t branch = 0, root = 0;
      double least = std::numeric_limits<double>::infinity();
      for (std::size_t b = 0; b < branches.size(); ++b)
        for (std::size_t r = 0; order[b] == next.size() && r < next.size(); ++r)
          if (const double d = std::abs(next[r] - branches[b].back()); !taken[r] && d < least)
            least = d, branch = b, root = r;
      if (!std::isfinite(least)) {
        order.clear();
        return 0;
      }
      order[branch] = root;
      taken[root] = true;
      longest = std::max(longest, least);
    }
    return longest;
  }

  static void mark(Canvas& canvas, const Given& given, const std::vector<Complex>& at, SeriesLook look, Marker marker,
                   const std::string& label) {
    if (at.empty()) return;
    std::vector<double> x, y;
    for (const Complex p : at) {
      x.push_back(p.real());
      y.push_back(p.imag());
    }
    look.marker = marker;
    look.label = label;
    canvas.add(marker_series(x, y, look), given);
  }
};

}  // namespace

PLANTLOOP_PLOT(root_locus, RootLocus)

}  // namespace plantloop
