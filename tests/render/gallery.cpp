// Writes the test figures as files to look at: render_gallery FOLDER [FORMAT [NAME...]]. Prints the faults lint finds.
// FORMAT may name a theme: png@dark.
// With the format `page` it writes all in every theme, each theme by a thread of its own, and an index.html.
// With the format `hash` it writes nothing and prints a number for the pixels of each figure.

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <thread>

#include "render/image.h"
#include "render/layout.h"
#include "render/scene/dump.h"
#include "render/scene/lint.h"
#include "render/theme.h"
#include "tests/render/figures.h"

namespace {

using namespace plantloop;

void write(const std::string& path, const std::vector<std::uint8_t>& bytes) {
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

// Every figure in every theme, side by side.
int write_page(const std::string& folder) {
  const std::vector<NamedFigure> figures = test_figures();
  const std::vector<std::string> themes = theme_names();
  std::vector<int> faults(themes.size());
  std::vector<std::thread> threads;
  for (std::size_t i = 0; i < themes.size(); ++i)
    threads.emplace_back([&, i] {
      for (const auto& [name, figure] : figures) {
        Figure themed = figure;
        themed.theme = themes[i];
        const Scene scene = layout(themed);
        faults[i] += static_cast<int>(lint(scene).size());
        write(folder + "/" + name + "." + themes[i] + ".png", to_png(scene));
      }
    });
  for (std::thread& thread : threads) thread.join();
  std::ofstream page(folder + "/index.html");
  page << "<!doctype html><meta charset=\"utf-8\"><title>Gallery</title><style>img{width:32%}</style>\n";
  for (const auto& [name, figure] : figures) {
    page << "<h2>" << name << "</h2>\n";
    for (const std::string& theme : themes) page << "<img src=\"" << name << '.' << theme << ".png\">\n";
  }
  int sum = 0;
  for (const int n : faults) sum += n;
  fmt::print("{} figures in {} themes, {} faults: {}/index.html\n", figures.size(), themes.size(), sum, folder);
  return sum == 0 ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) return 2;
  const std::string folder = argv[1], wish = argc > 2 ? argv[2] : "png";
  if (wish == "page") return write_page(folder);
  const std::string format = wish.substr(0, wish.find('@'));
  const std::string theme = format.size() < wish.size() ? wish.substr(format.size() + 1) : "";
  const auto now = [] {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now().time_since_epoch()).count();
  };
  for (auto& [name, figure] : test_figures()) {
    const std::string wanted = name;
    if (!theme.empty()) figure.theme = theme;
    if (argc > 3 && std::none_of(argv + 3, argv + argc, [&](const char* n) { return wanted == n; })) continue;
    if (format == "hash") {
      const Image image = rasterise(layout(figure));
      fmt::print("{} {:016x}\n", name, fnv1a(image.rgb.data(), image.rgb.size()));
      continue;
    }
    const double start = now();
    const Scene scene = layout(figure);
    const double laid_out = now();
    const auto bytes = picture(scene, format);
    const double drawn = now();
    write(folder + "/" + name + "." + format, bytes);
    fmt::print("{:18} layout {:6.1f} ms, {} {:6.1f} ms, {} bytes\n", name, laid_out - start, format, drawn - laid_out,
               bytes.size());
    for (const std::string& fault : lint(scene)) fmt::print("    {}\n", fault);
  }
}
