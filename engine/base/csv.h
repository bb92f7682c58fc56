// Tables of numbers in CSV files: measured signals and baselines.

#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace plantloop {

struct CsvTable {
  std::vector<std::string> names;            // of the header; "1", "2", ... when the file has none
  std::vector<std::vector<double>> columns;  // all of one length
  std::vector<std::uint32_t> lines;          // of the file, from 1, of each row
  std::size_t rows() const { return columns.empty() ? 0 : columns.front().size(); }
  int find(std::string_view name) const;  // index of a column, or -1
};

// The table, or why there is none and where. `error` names what was found: "'1,5' is no number".
struct CsvResult {
  CsvTable table;
  std::string error;
  std::uint32_t line = 0, column = 0;  // of the error, from 1; 0: none
  bool ok() const { return error.empty(); }
};

// What an empty cell, `nan`, `NaN` or `NA` is: an error, or a missing value, read as NaN.
enum class MissingCells { refused, as_nan };

// Reads a whole file. Cells are separated by commas, semicolons or tabs (what the first line holds). Numbers have a
// decimal point or, where no comma separates, a decimal comma, all of them the same, and may stand in quotes; blank
// lines and lines that begin with '#' are skipped; the first line is a header unless all its cells are numbers, and a
// row of units may follow it: `u` above `V` is the name `u [V]`. Lines end with LF, CR LF or CR, and may have a
// separator too many at their end.
CsvResult read_csv(std::string_view text, MissingCells missing = MissingCells::refused);

}  // namespace plantloop
