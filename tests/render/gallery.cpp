// Writes the test figures as files to look at: render_gallery FOLDER [FORMAT [NAME...]]. Prints the faults lint finds.
// FORMAT may name a theme: png@dark.
// With the format `hash` it writes nothing and prints a number for the pixels of each figure.

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fstream>

#include "render/image.h"
#include "render/layout.h"
#include "render/scene/dump.h"
#include "render/scene/lint.h"
#include "tests/render/figures.h"

int main(int argc, char** argv) {
  using namespace plantloop;
  if (argc < 2) return 2;
  const std::string folder = argv[1], wish = argc > 2 ? argv[2] : "png";
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
    std::ofstream(folder + "/" + name + "." + format, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    fmt::print("{:18} layout {:6.1f} ms, {} {:6.1f} ms, {} bytes\n", name, laid_out - start, format, drawn - laid_out,
               bytes.size());
    for (const std::string& fault : lint(scene)) fmt::print("    {}\n", fault);
  }
}
