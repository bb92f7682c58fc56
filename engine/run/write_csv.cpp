// A recording as CSV: one table over the union of times, 17 significant digits.

#include <bit>
#include <charconv>
#include <cstdint>

#include "engine/run/native.h"
#include "engine/run/recording.h"

namespace plantloop {
namespace {

// The text of a number, kept while the number stays: held columns are converted once per hit.
struct Cell {
  double value = 0;
  std::size_t length = 0;
  char text[32];

  std::string_view of(double number) {
    if (length == 0 || std::bit_cast<std::uint64_t>(number) != std::bit_cast<std::uint64_t>(value)) {
      value = number;
      length = static_cast<std::size_t>(
          std::to_chars(text, text + sizeof text, number, std::chars_format::general, 17).ptr - text);
    }
    return {text, length};
  }
};

// A name as a CSV cell (RFC 4180): quoted where it must be.
std::string quoted(const std::string& name) {
  if (name.find_first_of(",\"\r\n") == std::string::npos) return name;
  std::string text = "\"";
  for (const char c : name) {
    if (c == '"') text += '"';
    text += c;
  }
  return text + '"';
}

// A right side that differs in hidden columns only says nothing new.
bool repeats(const Recording& recording, const std::vector<std::size_t>& columns, std::size_t row) {
  if (row == 0 || recording.side()[row] != 1 || recording.time()[row] != recording.time()[row - 1]) return false;
  for (const std::size_t column : columns) {
    if (recording.at(row, column) != recording.at(row - 1, column)) return false;
  }
  return true;
}

}  // namespace

void write_csv(const Recording& recording, const std::function<void(std::string_view)>& write) {
  constexpr std::size_t chunk = 1 << 16;
  const std::vector<std::size_t> columns = written_columns(recording);
  std::vector<Cell> cells(columns.size());
  Cell time;
  std::string out = "time";
  for (const std::size_t column : columns) out += ',' + quoted(recording.columns[column].name);
  out += '\n';
  for (std::size_t row = 0; row < recording.rows(); ++row) {
    if (repeats(recording, columns, row)) continue;
    out += time.of(recording.time()[row]);
    for (std::size_t i = 0; i < columns.size(); ++i) {
      out += ',';
      out += cells[i].of(recording.at(row, columns[i]));
    }
    out += '\n';
    if (out.size() >= chunk) {
      write(out);
      out.clear();
    }
  }
  write(out);
}

std::string to_csv(const Recording& recording) {
  std::string text;
  text.reserve(recording.rows() * (written_columns(recording).size() + 1) * 21);
  write_csv(recording, [&](std::string_view part) { text += part; });
  return text;
}

}  // namespace plantloop
