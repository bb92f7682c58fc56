// The structure of a layered network.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "render/error.h"
#include "render/plots/example.h"
#include "render/plots/plot.h"

namespace plantloop {
namespace {

struct Network : Plot {
  Column layers{this, "layers", "neurons of each layer, the inputs first"};
  Column weights{this, "weights",
                 "of all connections, layer by layer, for each neuron those from the layer before; 0 is a pruned one",
                 Need::optional};
  Texts inputs{this, "inputs", "names of the inputs"};
  Texts outputs{this, "outputs", "names of the outputs"};

  Network() : Plot("neurons and weights of a network: wide is strong, the colour the sign, dotted is pruned") {}

  void draw(Canvas& canvas, const Given& given) const override {
    std::vector<std::size_t> sizes;
    double most_neurons = 1, total = 0;
    for (const double n : given[layers]) {
      if (!(n >= 1 && n <= 500) || n != std::floor(n))
        throw RenderError("'layers' must be whole numbers from 1 to 500");
      sizes.push_back(static_cast<std::size_t>(n));
      most_neurons = std::max(most_neurons, n);
    }
    for (std::size_t i = 0; i + 1 < sizes.size(); ++i) total += static_cast<double>(sizes[i] * sizes[i + 1]);
    const std::vector<double>& w = given[weights];
    if (!w.empty() && static_cast<double>(w.size()) != total)
      throw RenderError(fmt::format("these layers have {:g} connections and weights has {}", total, w.size()));
    Panel& panel = canvas.panel();
    panel.bare = true;
    canvas.own_x().limits = {-0.35, static_cast<double>(std::max<std::size_t>(sizes.size(), 2)) - 0.65};
    panel.y.limits = {-0.7, most_neurons - 0.3};
    const auto height = [&](std::size_t layer, std::size_t neuron) {
      return (most_neurons - static_cast<double>(sizes[layer])) / 2 + static_cast<double>(sizes[layer] - 1 - neuron);
    };
    connections(panel, sizes, w, height);
    for (std::size_t i = 0; i < sizes.size(); ++i) {
      std::vector<double> xs(sizes[i], static_cast<double>(i)), ys;
      for (std::size_t k = 0; k < sizes[i]; ++k) ys.push_back(height(i, k));
      const double size = std::clamp(150 / most_neurons, 3.0, 11.0);
      canvas.add(marker_series(xs, ys, {.marker = Marker::dot, .ink = Ink::text, .size = size}), given);
    }
    names(panel, given[inputs], sizes, 0, height);
    if (!sizes.empty()) names(panel, given[outputs], sizes, sizes.size() - 1, height);
  }

  Figure example() const override {
    Figure figure{.title = "A network of 7 neurons after pruning"};
    example::Noise noise{17};
    std::vector<double> w;
    for (int i = 0; i < 4 * 6 + 6; ++i) {
      const double v = noise();
      w.push_back(std::abs(v) < 0.45 ? 0 : v);
    }
    use(figure, 0,
        {{"layers", std::vector<double>{4, 6, 1}},
         {"weights", w},
         {"inputs", std::vector<std::string>{"y(k−1)", "y(k−2)", "u(k−1)", "u(k−2)"}},
         {"outputs", std::vector<std::string>{"ŷ(k)"}}});
    return figure;
  }

 private:
  // Five widths for each sign, and the pruned ones.
  template <typename Height>
  static void connections(Panel& panel, const std::vector<std::size_t>& sizes, const std::vector<double>& w,
                          Height height) {
    constexpr int widths = 5;
    double most = 0;
    for (const double v : w)
      if (std::isfinite(v)) most = std::max(most, std::abs(v));
    struct Lines {
      std::vector<double> x, y;
    };
    std::array<Lines, 2 * widths + 1> groups;
    std::size_t next = 0;
    for (std::size_t i = 0; i + 1 < sizes.size(); ++i)
      for (std::size_t to = 0; to < sizes[i + 1]; ++to)
        for (std::size_t from = 0; from < sizes[i]; ++from) {
          const double v = w.empty() ? 1 : w[next++];
          std::size_t group = 2 * widths;
          if (std::isfinite(v) && v != 0) {
            const double part = w.empty() ? 0.4 : std::abs(v) / most;
            const int width = std::clamp(static_cast<int>(part * widths), 0, widths - 1);
            group = static_cast<std::size_t>(v > 0 ? width : widths + width);
          }
          groups[group].x.insert(groups[group].x.end(),
                                 {static_cast<double>(i), static_cast<double>(i) + 1, std::nan("")});
          groups[group].y.insert(groups[group].y.end(), {height(i, from), height(i + 1, to), std::nan("")});
        }
    panel.line(groups[2 * widths].x, groups[2 * widths].y,
               {.label = groups[2 * widths].x.empty() ? "" : "pruned",
                .style = LineStyle::dotted,
                .width = 0.8,
                .ink = Ink::text,
                .opacity = 0.75});
    for (const bool positive : {true, false}) {
      std::size_t strongest = widths;
      for (std::size_t k = 0; k < widths; ++k)
        if (!groups[positive ? k : widths + k].x.empty()) strongest = k;
      for (std::size_t k = 0; k < widths; ++k) {
        Lines& g = groups[positive ? k : widths + k];
        const bool named = k == strongest && !w.empty();
        panel.line(std::move(g.x), std::move(g.y),
                   {.label = named ? (positive ? "positive" : "negative") : "",
                    .width = 0.5 + 0.55 * static_cast<double>(k),
                    .same_color = k > 0,
                    .opacity = 0.85});
      }
    }
  }

  template <typename Height>
  static void names(Panel& panel, const std::vector<std::string>& all, const std::vector<std::size_t>& sizes,
                    std::size_t layer, Height height) {
    for (std::size_t k = 0; !sizes.empty() && k < std::min(all.size(), sizes[layer]); ++k)
      panel.callouts.push_back({.x = static_cast<double>(layer) + (layer == 0 ? -0.17 : 0.17),
                                .y = height(layer, k),
                                .label = all[k],
                                .marker = Marker::none,
                                .quiet = true});
  }
};

}  // namespace

PLANTLOOP_PLOT(network, Network)

}  // namespace plantloop
