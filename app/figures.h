// Figures of a diagram: what its `figures:` section asks for, filled with what a run recorded.

#pragma once

#include <string>
#include <string_view>

#include "engine/run/diagram.h"
#include "render/figure.h"

namespace plantloop {

// Continuous signals are lines, sampled ones stairs at their own hits. What the declaration leaves out: a signal's
// label is its name, x is time, a panel's label is the name and unit of its only signal, or the unit that all of them
// share. A signal that was not recorded has no curve.
Figure make_figure(const FigureDecl& declared, const DiagramRun& run, const Model& model);

// One column of a run as a curve over time, of its own kind: line or stairs.
Series series_of(const Recording& recording, std::size_t column, SeriesLook look = {});

// "speed [m/s]"; the name alone without unit.
std::string label_of(const RecordedColumn& column);

// The styles of a curve, as diagrams and scripts name them: solid dashed dotted dashdot none points line_points steps.
// Changes the look, and the kind of the series where `steps` asks for it; false for other texts.
bool apply_style(std::string_view style, SeriesLook& look, Series::Kind& kind);

}  // namespace plantloop
