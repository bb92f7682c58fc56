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

namespace {

std::string write_picture(const Scene& scene, const std::string& format, const std::string& path) {
  std::vector<std::uint8_t> bytes;
  try {
    bytes = picture(scene, format);
  } catch (const RenderError& e) {
    return fmt::format("cannot draw '{}': {}", path, e.what());
  }
  const std::string error = write_file(path, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  return error.empty() ? "" : fmt::format("cannot write '{}': {}", path, error);
}

}  // namespace

std::string write_figures(const Model& model, const DiagramRun& run, const std::string& folder,
                          const std::vector<std::string>& formats) {
  if (model.figures.empty()) return fmt::format("{} has no figures: section, so there is nothing to draw", model.path);
  for (const FigureDecl& declared : model.figures) {
    Scene scene;
    try {
      scene = layout(make_figure(declared, run, model));
    } catch (const RenderError& e) {
      return fmt::format("cannot draw figure '{}': {}", declared.name, e.what());
    }
    for (const std::string& format : formats) {
      std::string error = write_picture(scene, format, fmt::format("{}/{}.{}", folder, declared.name, format));
      if (!error.empty()) return error;
    }
  }
  return {};
}

std::string write_figure(const Figure& figure, const std::string& path) {
  const std::filesystem::path file(path);
  const std::string ending = file.extension().string();
  return write_picture(layout(figure), ending.empty() ? "png" : ending.substr(1), path);
}

}  // namespace plantloop::app
