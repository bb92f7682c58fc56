// Figures of a diagram: what its `figures:` section asks for, filled with what a run recorded.

#pragma once

#include <string>
#include <string_view>

#include "engine/run/diagram.h"
#include "render/figure.h"

namespace plantloop {

// Continuous signals are lines, sampled ones stairs at their own hits. What the declaration leaves out: a signal's
// label is its name, x is time, a panel's label is the name and unit of its only signal, or the unit that all of them
// share. A signal that was not recorded has no curve. A plot is given a signal's values at its hits, when all its
// signals have one rate, else in all rows; of a vector, for a list of numbers, the elements at the end. Throws
// RenderError with the place in the diagram when a plot cannot be drawn.
Figure make_figure(const FigureDecl& declared, const DiagramRun& run, const Model& model);

// The plot types as words of panels, for reading diagrams.
const PlotWords& plot_words();

// One column of a run as a curve over time, of its own kind: line or stairs.
Series series_of(const Recording& recording, std::size_t column, SeriesLook look = {});

// "speed [m/s]"; the name alone without unit.
std::string label_of(const RecordedColumn& column);

}  // namespace plantloop
