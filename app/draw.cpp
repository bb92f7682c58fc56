// Every figure is laid out once and drawn in each format.

#include "app/draw.h"

#include <fmt/format.h>

#include <filesystem>
#include <sstream>
#include <system_error>

#include "app/figures.h"
#include "engine/base/files.h"
#include "render/error.h"
#include "render/image.h"
#include "render/layout.h"

namespace plantloop::app {

std::vector<std::string> split_formats(const std::string& text) {
  std::vector<std::string> formats;
  std::istringstream stream(text);
  for (std::string format; std::getline(stream, format, ',');) formats.push_back(format);
  return formats;
}

std::string write_figures(const Model& model, const DiagramRun& run, const std::string& folder,
                          const std::vector<std::string>& formats) {
  if (model.figures.empty()) return fmt::format("{} has no figures: section, so there is nothing to draw", model.path);
  std::error_code failed;
  std::filesystem::create_directories(folder, failed);
  if (failed) return fmt::format("cannot make the folder '{}': {}", folder, failed.message());
  for (const FigureDecl& declared : model.figures) {
    const Scene scene = layout(make_figure(declared, run, model));
    for (const std::string& format : formats) {
      const std::string path = fmt::format("{}/{}.{}", folder, declared.name, format);
      std::vector<std::uint8_t> bytes;
      try {
        bytes = picture(scene, format);
      } catch (const RenderError& e) {
        return fmt::format("cannot draw '{}': {}", path, e.what());
      }
      if (const std::string error = write_file(path, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
          !error.empty())
        return fmt::format("cannot write '{}': {}", path, error);
    }
  }
  return {};
}

}  // namespace plantloop::app
