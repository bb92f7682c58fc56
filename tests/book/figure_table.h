// docs/book.md: which figure of the book is made by what.

#pragma once

#include <string>
#include <vector>

namespace plantloop::testing_book {

struct FigureRow {
  std::vector<std::string> figures;  // "5.21", "5.22"; none: a figure beside those of the book
  std::vector<std::string> makers;   // scripts and diagrams, from the root
  std::string file;                  // without ending; "": a diagram's own figures
  std::vector<std::string> tests;
};
// The first table of the page. The working directory is the root.
std::vector<FigureRow> figure_table();
// The figures of the second one, those without a counterpart.
std::vector<std::string> missing_figures();
// The files that a script writes.
std::vector<std::string> figures_of(const std::string& script);

}  // namespace plantloop::testing_book
