// Reading CSV: lines, cells, numbers, each complaint with its place.

#include "engine/base/csv.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <optional>

#include "engine/base/numbers.h"
#include "engine/base/text.h"

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

bool is_missing(std::string_view cell) { return cell.empty() || cell == "nan" || cell == "NaN" || cell == "NA"; }

class CsvReader {
 public:
  explicit CsvReader(MissingCells missing) : missing_(missing) {}

  CsvResult read(std::string_view text) {
    if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
    while (!text.empty() && result_.ok()) {
      const std::size_t end = std::min(text.find('\n'), text.size());
      std::string_view line = text.substr(0, end);
      text.remove_prefix(std::min(end + 1, text.size()));
      if (line.ends_with('\r')) line.remove_suffix(1);
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
    const std::vector<Cell> cells = split(line, separator_);
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
    if (numbers) add(line);
  }

  void add(std::string_view line) {
    std::vector<std::vector<double>>& columns = result_.table.columns;
    std::size_t offset = 0;
    std::size_t index = 0;
    while (true) {
      const std::size_t end = std::min(line.find(separator_, offset), line.size());
      const std::string_view cell = trimmed(line.substr(offset, end - offset));
      if (index == columns.size()) {
        const auto found = static_cast<std::size_t>(std::count(line.begin(), line.end(), separator_)) + 1;
        return fail(fmt::format("{} values, but the first line has {}{}", found, columns.size(),
                                separator_ == ',' && found == 2 * columns.size()
                                    ? "; where a comma is the decimal mark, semicolons must separate the values"
                                    : ""),
                    column_at(line, offset));
      }
      std::optional<double> value = parse_number(cell);
      if (value && decimal_comma_ != 0 && cell.find('.') != std::string_view::npos) {
        return fail(fmt::format("'{}' has a decimal point, but numbers before it (line {}) a decimal comma",
                                printable(cell), decimal_comma_),
                    column_at(line, offset));
      }
      if (value && decimal_point_ == 0 && cell.find('.') != std::string_view::npos) decimal_point_ = number_;
      if (!value && separator_ != ',') {
        value = with_decimal_comma(cell);
        if (value && decimal_point_ != 0) {
          return fail(fmt::format("'{}' has a decimal comma, but numbers before it (line {}) a decimal point",
                                  printable(cell), decimal_point_),
                      column_at(line, offset));
        }
        if (value && decimal_comma_ == 0) decimal_comma_ = number_;
      }
      if (!value && missing_ == MissingCells::as_nan && is_missing(cell))
        value = std::numeric_limits<double>::quiet_NaN();
      if (!value) {
        return fail(cell.empty() ? fmt::format("the value of '{}' is missing", result_.table.names[index])
                                 : fmt::format("'{}' is no number", printable(cell)),
                    column_at(line, offset));
      }
      columns[index++].push_back(*value);
      if (end == line.size()) break;
      offset = end + 1;
    }
    if (index < columns.size()) {
      fail(fmt::format("{} value{}, but the first line has {}", index, index == 1 ? "" : "s", columns.size()),
           column_at(line, line.size()));
    }
  }

  MissingCells missing_;
  CsvResult result_;
  std::uint32_t number_ = 0;
  std::uint32_t decimal_point_ = 0, decimal_comma_ = 0;  // the first line with one; 0: none so far
  char separator_ = ',';
};

}  // namespace

int CsvTable::find(std::string_view name) const {
  const auto at = std::find(names.begin(), names.end(), name);
  return at == names.end() ? -1 : static_cast<int>(at - names.begin());
}

CsvResult read_csv(std::string_view text, MissingCells missing) { return CsvReader(missing).read(text); }

}  // namespace plantloop
