// From what is said of a figure, in a diagram or in a script, to the figure: one function for each table of words.

#pragma once

#include <functional>
#include <optional>

#include "engine/diagram/model.h"
#include "render/figure.h"

namespace plantloop {

// The value of an expression over parameters; nothing for null.
using NumberOf = std::function<std::optional<double>(const ExpressionPtr&)>;
// Of numbers that stand there as such.
std::optional<double> plain_number(const ExpressionPtr& expression);

void set_figure(Figure& figure, const FigureBlock& says, const NumberOf& number);
void set_axis(Axis& axis, const FigureBlock& says, const NumberOf& number);
// What a panel or an inset says apart from its curves, plots and insets. `shared`: the x axis that an own one begins
// as, when there is something to say about it.
void set_panel(Panel& panel, const FigureBlock& says, const Axis& shared, const NumberOf& number);

// `kind` becomes stairs where the style is `steps`.
SeriesLook look_of(const FigureBlock& says, Series::Kind& kind, const NumberOf& number);
ReferenceLine line_of(const FigureBlock& says, const NumberOf& number);
ReferenceBand band_of(const FigureBlock& says, const NumberOf& number);
Callout remark_of(const FigureBlock& says, const NumberOf& number);

}  // namespace plantloop
