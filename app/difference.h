// Pictures of what differs: of an expectation that is not met, of two results, of two pictures.

#pragma once

#include <string>
#include <vector>

#include "engine/run/compare.h"
#include "engine/run/diagram.h"
#include "render/figure.h"
#include "render/image.h"

namespace plantloop::app {

// The signal of an expectation with what was wanted of it; no panel when nothing was recorded that could be drawn.
Figure figure_of(const Verdict& verdict, const DiagramRun& run, const Model& model);

// One signal of two results, and their difference with what is allowed.
struct ComparedSignal {
  std::string name;
  SampledSignal found, wanted;
  Tolerance tolerance;
  Deviation deviation;
};
Figure figure_of(const std::vector<ComparedSignal>& signals, const std::string& found, const std::string& wanted);

// The second picture, pale, with the pixels that differ in red; both of one size.
Image difference_of(const Image& found, const Image& wanted);

}  // namespace plantloop::app
