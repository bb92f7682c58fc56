// The words of figures: what can be said of a figure, its panels, axes, curves, lines, bands, remarks and insets.
//
// Diagrams (`figures:`), scripts (`pl.figure{...}`), the schema and the declarations for editors are all read off these
// tables. Plot types are words of panels, too, but only render knows them: they are passed in as PlotWords.

#pragma once

#include <limits>
#include <string>
#include <string_view>
#include <vector>

namespace plantloop {

struct FigureWords;

struct FigureWord {
  enum class Kind {
    text,
    texts,    // a list of texts
    number,   // an expression over parameters
    numbers,  // `count` of them
    limits,   // [lower, upper], each may be `auto`
    flag,
    choice,
    color,    // a name, or #RRGGBB
    signal,   // an expression over signals
    signals,  // one or a list of them, each alone or with how its curve looks (`parts`)
    column,   // numbers, a signal's values over time, or the elements of a vector at the end of the run
    grid,     // rows of numbers, or a vector's elements over time
    axis,     // its label, or all of it (`parts`)
    list,     // of mappings (`parts`)
    plot,     // a mapping (`parts`) or a list of them
  };
  std::string_view name;
  Kind kind = Kind::text;
  std::string_view doc;
  std::vector<std::string_view> choices{};  // of a choice; of what is needed: the words that may stand in its place
  const FigureWords* parts = nullptr;
  std::size_t count = 0;
  double least = -std::numeric_limits<double>::infinity();  // of numbers that are written as such
  double most = std::numeric_limits<double>::infinity();
  bool whole = false;
  bool needed = false;
};

// What may be said of one thing. `what` names it in findings: "a panel".
struct FigureWords {
  std::string_view what;
  std::vector<FigureWord> words;
  const FigureWord* find(std::string_view name) const;
  std::vector<std::string> names() const;
};

// One for each plot type; they must outlive the models read with them.
using PlotWords = std::vector<FigureWord>;
const PlotWords& no_plots();

const FigureWords& axis_words();
const FigureWords& line_words();
const FigureWords& band_words();
const FigureWords& remark_words();
// How a curve looks; `curve_words` says which signal it shows, too.
const FigureWords& look_words();
const FigureWords& curve_words();
// What figures and panels have in common in diagrams and in scripts.
const FigureWords& picture_words();
const FigureWords& frame_words();
const FigureWords& inset_frame_words();
// In diagrams: with the signals shown.
const FigureWords& figure_words();
const FigureWords& panel_words();
const FigureWords& inset_words();

}  // namespace plantloop
