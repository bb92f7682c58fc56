// Reading CSV: lines, cells, numbers, each complaint with its place.

#include "engine/base/csv.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <optional>
#include <utility>

#include "engine/base/numbers.h"
#include "engine/base/text.h"
#include "engine/base/units.h"

namespace plantloop {
namespace {

struct Cell {
  std::string text;
  std::size_t offset = 0;  // in the line, in bytes
};

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t' || text.back() == '\r')) text.remove_suffix(1);
  return text;
}

// Semicolon before tab before comma: a comma may be part of a name where one of the others separates.
char separator_of(std::string_view line) {
  for (const char candidate : {';', '\t'}) {
    if (line.find(candidate) != std::string_view::npos) return candidate;
  }
  return ',';
}

// The cells of a line; quoted ones without their quotes.
std::vector<Cell> split(std::string_view line, char separator) {
  std::vector<Cell> cells(1);
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (c == '"') {
      if (quoted && i + 1 < line.size() && line[i + 1] == '"') {
        cells.back().text += line[++i];
      } else {
        quoted = !quoted;
      }
    } else if (c == separator && !quoted) {
      cells.push_back({"", i + 1});
    } else {
      cells.back().text += c;
    }
  }
  for (Cell& cell : cells) cell.text = std::string(trimmed(cell.text));
  return cells;
}

// The line up to `offset` in characters, from 1.
std::uint32_t column_at(std::string_view line, std::size_t offset) {
  while (offset < line.size() && line[offset] == ' ') ++offset;
  return static_cast<std::uint32_t>(count_characters(line.substr(0, offset))) + 1;
}

// The number of a cell with one decimal comma.
std::optional<double> with_decimal_comma(std::string_view cell) {
  if (std::count(cell.begin(), cell.end(), ',') != 1 || cell.find('.') != std::string_view::npos) return {};
  std::string text(cell);
  text[text.find(',')] = '.';
  return parse_number(text);
}

// With its mark, or as an English text begins: every second byte is 0.
bool is_utf16(std::string_view text) {
  return text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF") ||
         (text.size() > 3 && (text[0] == '\0') != (text[1] == '\0') && (text[0] == '\0') == (text[2] == '\0') &&
          (text[1] == '\0') == (text[3] == '\0'));
}

// The text of a cell in a row of units: `V`, `[V]`, `(V)`, and `-` for a number without a unit.
std::string unit_text(std::string_view cell) {
  if (cell.size() > 1 && ((cell.front() == '[' && cell.back() == ']') || (cell.front() == '(' && cell.back() == ')')))
    cell = trimmed(cell.substr(1, cell.size() - 2));
  return std::string(cell == "-" ? "" : cell);
}

bool is_missing(std::string_view cell) { return cell.empty() || cell == "nan" || cell == "NaN" || cell == "NA"; }

class CsvReader {
 public:
  explicit CsvReader(MissingCells missing) : missing_(missing) {}

  CsvResult read(std::string_view text) {
    if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
    if (is_utf16(text)) {
      number_ = 1;
      fail("the file is in UTF-16; save it in UTF-8 (spreadsheets call it CSV UTF-8)", 1);
    }
    while (!text.empty() && result_.ok()) {
      const std::size_t end = std::min(text.find_first_of("\r\n"), text.size());
      const std::string_view line = text.substr(0, end);
      text.remove_prefix(end);
      text.remove_prefix(text.starts_with("\r\n") ? 2 : std::min<std::size_t>(1, text.size()));
      ++number_;
      if (trimmed(line).empty() || line.starts_with('#')) continue;
      if (result_.table.columns.empty()) {
        begin(line);
      } else {
        add(line);
      }
    }
    if (result_.ok() && result_.table.columns.empty()) fail("it holds no line with values", 0);
    return std::move(result_);
  }

 private:
  void fail(std::string why, std::uint32_t column) {
    result_.table = {};
    result_.error = std::move(why);
    result_.line = number_;
    result_.column = column;
  }

  void begin(std::string_view line) {
    separator_ = separator_of(line);
    std::vector<Cell> cells = split(line, separator_);
    if (cells.size() > 1 && cells.back().text.empty()) {
      unnamed_column_ = column_at(line, cells.back().offset);
      unnamed_line_ = number_;
      cells.pop_back();
    }
    const bool numbers = std::all_of(cells.begin(), cells.end(), [](const Cell& cell) {
      return parse_number(cell.text).has_value() || with_decimal_comma(cell.text).has_value();
    });
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const std::string name = numbers ? fmt::format("{}", i + 1) : cells[i].text;
      if (name.empty()) return fail(fmt::format("column {} has no name", i + 1), column_at(line, cells[i].offset));
      if (result_.table.find(name) >= 0) {
        return fail(fmt::format("two columns are called '{}'", name), column_at(line, cells[i].offset));
      }
      result_.table.names.push_back(name);
    }
    result_.table.columns.resize(cells.size());
    if (numbers) return add(line);
    may_be_units_ = true;
  }

  // The first row below the header holds units when it holds no number. True when it is done with, also by an error.
  bool take_units(std::string_view line, const std::vector<Cell>& cells) {
    std::size_t words = 0;
    for (const Cell& cell : cells) {
      if (cell.text.empty()) continue;
      if (parse_number(cell.text) || with_decimal_comma(cell.text) || is_missing(cell.text)) return false;
      if (is_digit(cell.text[0]) || cell.text[0] < ' ') return false;
      ++words;
    }
    std::vector<std::string>& names = result_.table.names;
    if (words == 0 || cells.size() > names.size() + 1) return false;
    for (std::size_t i = 0; i < std::min(cells.size(), names.size()); ++i) {
      const std::string unit = unit_text(cells[i].text);
      if (std::holds_alternative<UnitError>(parse_unit(unit))) {
        fail(fmt::format("'{}' is no number and no unit; below the header stand numbers, or a row of units",
                         printable(cells[i].text)),
             column_at(line, cells[i].offset));
        return true;
      }
      if (!unit.empty() && !names[i].ends_with(']') && !names[i].ends_with(')')) names[i] += " [" + unit + "]";
    }
    return true;
  }

  void add(std::string_view line) {
    if (line.find('"') != std::string_view::npos || may_be_units_) {
      const std::vector<Cell> cells = split(line, separator_);
      if (std::exchange(may_be_units_, false) && take_units(line, cells)) return;
      if (line.find('"') != std::string_view::npos) return add_quoted(line, cells);
    }
    std::vector<std::vector<double>>& columns = result_.table.columns;
    std::size_t offset = 0;
    std::size_t index = 0;
    while (true) {
      const std::size_t end = std::min(line.find(separator_, offset), line.size());
      const std::string_view cell = trimmed(line.substr(offset, end - offset));
      if (index == columns.size()) {
        if (end == line.size() && cell.empty()) break;
        const auto found = static_cast<std::size_t>(std::count(line.begin(), line.end(), separator_)) + 1;
        return refuse_surplus(line, found, offset);
      }
      if (!take(cell, index++, line, offset)) return;
      if (end == line.size()) break;
      offset = end + 1;
    }
    finish(line, index);
  }

  void add_quoted(std::string_view line, const std::vector<Cell>& cells) {
    const std::size_t width = result_.table.columns.size();
    const bool empty_end = cells.size() == width + 1 && cells.back().text.empty();
    if (cells.size() > width && !empty_end) return refuse_surplus(line, cells.size(), cells[width].offset);
    std::size_t index = 0;
    for (; index < std::min(width, cells.size()); ++index) {
      if (!take(cells[index].text, index, line, cells[index].offset)) return;
    }
    finish(line, index);
  }

  // One value more than there are names: of a header that ends with a separator, that column has no name.
  void refuse_surplus(std::string_view line, std::size_t found, std::size_t offset) {
    const std::size_t width = result_.table.columns.size();
    if (unnamed_column_ > 0 && found == width + 1) {
      number_ = unnamed_line_;
      return fail(fmt::format("column {} has no name", found), unnamed_column_);
    }
    fail(fmt::format("{} values, but the first line has {}{}", found, width,
                     separator_ == ',' && found == 2 * width
                         ? "; where a comma is the decimal mark, semicolons must separate the values"
                         : ""),
         column_at(line, offset));
  }

  // False after an error.
  bool take(std::string_view cell, std::size_t index, std::string_view line, std::size_t offset) {
    std::vector<std::vector<double>>& columns = result_.table.columns;
    std::optional<double> value = parse_number(cell);
    const bool has_point = cell.find('.') != std::string_view::npos;
    const auto mixed = [&](std::string_view here, std::string_view before, std::uint32_t where) {
      fail(fmt::format("'{}' has a decimal {}, but numbers before it (line {}) a decimal {}", printable(cell), here,
                       where, before),
           column_at(line, offset));
      return false;
    };
    if (value && has_point) {
      if (decimal_comma_ != 0) return mixed("point", "comma", decimal_comma_);
      if (decimal_point_ == 0) decimal_point_ = number_;
    }
    if (!value && separator_ != ',') {
      value = with_decimal_comma(cell);
      if (value && decimal_point_ != 0) return mixed("comma", "point", decimal_point_);
      if (value && decimal_comma_ == 0) decimal_comma_ = number_;
    }
    if (!value && missing_ == MissingCells::as_nan && is_missing(cell))
      value = std::numeric_limits<double>::quiet_NaN();
    if (!value) {
      fail(cell.empty() ? fmt::format("the value of '{}' is missing", result_.table.names[index])
                        : fmt::format("'{}' is no number{}", printable(cell), separation_hint(cell)),
           column_at(line, offset));
      return false;
    }
    columns[index].push_back(*value);
    return true;
  }

  static std::string_view separation_hint(std::string_view cell) {
    return is_digit(cell[0]) && cell.find_first_of("; \t") != std::string_view::npos
               ? "; values are separated as the first line is, by commas, semicolons or tabs"
               : "";
  }

  void finish(std::string_view line, std::size_t index) {
    const std::size_t width = result_.table.columns.size();
    if (index < width)
      return fail(fmt::format("{} value{}, but the first line has {}", index, index == 1 ? "" : "s", width),
                  column_at(line, line.size()));
    result_.table.lines.push_back(number_);
  }

  MissingCells missing_;
  CsvResult result_;
  std::uint32_t number_ = 0;
  std::uint32_t decimal_point_ = 0, decimal_comma_ = 0;  // the first line with one; 0: none so far
  char separator_ = ',';
  bool may_be_units_ = false;
  std::uint32_t unnamed_line_ = 0, unnamed_column_ = 0;  // of an empty cell at the end of the header
};

}  // namespace

int CsvTable::find(std::string_view name) const {
  const auto at = std::find(names.begin(), names.end(), name);
  return at == names.end() ? -1 : static_cast<int>(at - names.begin());
}

CsvResult read_csv(std::string_view text, MissingCells missing) { return CsvReader(missing).read(text); }

}  // namespace plantloop
