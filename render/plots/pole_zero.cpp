// Poles and zeros in the complex plane.

#include "render/plots/plane.h"

namespace plantloop {
namespace {

struct PoleZero : Plot {
  System data{this, Need::needed};
  Flag sampled{this, "sampled", "polynomials in z: the border of stability is the unit circle"};

  PoleZero() : Plot("poles as crosses and zeros as rings, with lines of equal damping and frequency") {}

  void draw(Canvas& canvas, const Given& given) const override {
    const Transfer system = data.system(given);
    std::vector<Complex> all = roots(system.den);
    const std::vector<Complex> zeros = roots(system.num), poles = all;
    all.insert(all.end(), zeros.begin(), zeros.end());
    const bool first = canvas.panel().series.empty();
    set_plane(canvas, all, given[sampled]);
    if (first) draw_plane(canvas.panel(), all, given[sampled]);
    SeriesLook look = given.look;
    look.marker = Marker::cross;
    if (look.size == 0) look.size = 5;
    const std::string name = look.label;
    look.label = name.empty() ? "poles" : name + ", poles";
    canvas.add(points(poles, look), given);
    look.marker = Marker::ring;
    look.same_color = true;
    look.label = name.empty() ? "zeros" : name + ", zeros";
    if (!zeros.empty()) canvas.add(points(zeros, look), given);
  }

  Figure example() const override {
    Figure figure{.title = "Poles and zeros of a flexible drive"};
    use(figure, 0, {{"num", std::vector<double>{1, 0.6, 9}}, {"den", std::vector<double>{1, 4.2, 23.8, 50, 104, 100}}});
    return figure;
  }

 private:
  static Series points(const std::vector<Complex>& at, const SeriesLook& look) {
    std::vector<double> x, y;
    for (const Complex p : at) {
      x.push_back(p.real());
      y.push_back(p.imag());
    }
    return marker_series(x, y, look);
  }
};

}  // namespace

PLANTLOOP_PLOT(pole_zero, PoleZero)

}  // namespace plantloop
