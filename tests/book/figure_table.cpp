// Rows of a table in Markdown.

#include "tests/book/figure_table.h"

#include <algorithm>
#include <fstream>
#include <regex>
#include <stdexcept>

namespace plantloop::testing_book {
namespace {

constexpr const char* page = "docs/book.md";

std::vector<std::string> lines() {
  std::ifstream file(page);
  if (!file) throw std::runtime_error(std::string(page) + " cannot be read");
  std::vector<std::string> all;
  for (std::string line; std::getline(file, line);) all.push_back(line);
  return all;
}

std::vector<std::string> matches(const std::string& text, const std::regex& pattern) {
  std::vector<std::string> found;
  for (std::sregex_iterator at(text.begin(), text.end(), pattern), end; at != end; ++at) found.push_back((*at)[1]);
  return found;
}

const std::regex number("([1-7]\\.[0-9]+)"), code("`([^`]+)`");

// The cells of the rows below a heading of the table.
std::vector<std::vector<std::string>> cells_of(const std::string& heading) {
  std::vector<std::vector<std::string>> rows;
  bool inside = false;
  for (const std::string& line : lines()) {
    if (line.rfind("| figure", 0) == 0) inside = line.rfind(heading, 0) == 0;
    if (!inside || line.rfind("| ", 0) != 0 || line.rfind("| figure", 0) == 0 || line.rfind("| ---", 0) == 0) continue;
    std::vector<std::string> cells;
    for (std::size_t at = 1; at < line.size();) {
      const std::size_t end = line.find('|', at);
      if (end == std::string::npos) break;
      cells.push_back(line.substr(at, end - at));
      at = end + 1;
    }
    rows.push_back(std::move(cells));
  }
  return rows;
}

}  // namespace

std::vector<FigureRow> figure_table() {
  std::vector<FigureRow> rows;
  for (const std::vector<std::string>& cells : cells_of("| figure |")) {
    if (cells.size() != 5) throw std::runtime_error("a row of docs/book.md has not five cells");
    const std::vector<std::string> file = matches(cells[3], code);
    rows.push_back(
        {matches(cells[0], number), matches(cells[2], code), file.empty() ? "" : file[0], matches(cells[4], code)});
  }
  return rows;
}

std::vector<std::string> missing_figures() {
  std::vector<std::string> all;
  for (const std::vector<std::string>& cells : cells_of("| figures |")) {
    const std::vector<std::string> some = matches(cells[0], number);
    all.insert(all.end(), some.begin(), some.end());
  }
  return all;
}

std::vector<std::string> figures_of(const std::string& script) {
  std::vector<std::string> files;
  for (const FigureRow& row : figure_table()) {
    if (std::find(row.makers.begin(), row.makers.end(), script) != row.makers.end() && !row.file.empty())
      files.push_back(row.file);
  }
  return files;
}

}  // namespace plantloop::testing_book
