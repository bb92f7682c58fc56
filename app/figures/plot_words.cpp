// The plot types as words of diagrams, read off their declarations.

#include <list>

#include "app/figures.h"
#include "render/plots/plot.h"

namespace plantloop {
namespace {

FigureWord::Kind kind_of(PlotInput::Kind kind) {
  switch (kind) {
    case PlotInput::Kind::column:
      return FigureWord::Kind::column;
    case PlotInput::Kind::grid:
      return FigureWord::Kind::grid;
    case PlotInput::Kind::number:
      return FigureWord::Kind::number;
    case PlotInput::Kind::flag:
      return FigureWord::Kind::flag;
    case PlotInput::Kind::choice:
      return FigureWord::Kind::choice;
    case PlotInput::Kind::texts:
      return FigureWord::Kind::texts;
    case PlotInput::Kind::text:
      break;
  }
  return FigureWord::Kind::text;
}

FigureWords words_of(const Plot& plot) {
  FigureWords words{plot.name(), {}};
  for (const PlotInput& input : plot.inputs()) {
    words.words.push_back({.name = input.name,
                           .kind = kind_of(input.kind),
                           .doc = input.doc,
                           .choices = {input.choices.begin(), input.choices.end()},
                           .needed = input.need == Need::needed || !input.instead.empty()});
    if (!input.instead.empty()) words.words.back().choices = input.instead;
  }
  words.words.insert(words.words.end(), look_words().words.begin(), look_words().words.end());
  words.words.push_back({"right", FigureWord::Kind::flag, "on the right axis"});
  return words;
}

}  // namespace

const PlotWords& plot_words() {
  static std::list<FigureWords> parts;
  static const PlotWords words = [] {
    PlotWords made;
    for (const Plot* plot : plots()) {
      parts.push_back(words_of(*plot));
      made.push_back(
          {.name = plot->name(), .kind = FigureWord::Kind::plot, .doc = plot->summary(), .parts = &parts.back()});
    }
    return made;
  }();
  return words;
}

}  // namespace plantloop
