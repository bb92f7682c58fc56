// A diagram's figures as files.

#pragma once

#include <string>
#include <vector>

#include "engine/run/diagram.h"
#include "render/figure.h"

namespace plantloop::app {

// "png,svg" -> {"png", "svg"}
std::vector<std::string> split_formats(const std::string& text);
// Writes <figure name>.<format> of every figure of the model into the folder, which is made if need be. "" when all are
// written, else what went wrong.
std::string write_figures(const Model& model, const DiagramRun& run, const std::string& folder,
                          const std::vector<std::string>& formats);

// Draws one figure into a file in the format of its ending; its folder is made if need be. "" when it is written.
std::string write_figure(const Figure& figure, const std::string& path);

}  // namespace plantloop::app
