// A recording as JSON: native rates, sides, units and provenance. Numbers are the shortest that read back the same;
// what is not finite is null.
//
// {"plantloop_recording": 1, "provenance": {...},
//  "rates": [{"time": [...], "side": [...]}, {"period": 0.1, "offset": 0, "time": [...]}, ...],
//  "columns": [{"name": "theta", "unit": "rad", "rate": 0, "values": [...]}, ...],
//  "events": {"h.reset": [...]}}
//
// rates[0] is the continuous one; a column's times are those of its rate.

#include <array>
#include <charconv>
#include <cmath>

#include "engine/run/json_text.h"
#include "engine/run/native.h"

namespace plantloop {
namespace {

void add_list(std::string& out, const std::vector<double>& values) {
  out += '[';
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (i > 0) out += ',';
    add_number(out, values[i]);
  }
  out += ']';
}

void add_rates(std::string& out, const Recording& recording) {
  out += "\"rates\": [\n";
  for (std::size_t rate = 0; rate < std::max<std::size_t>(1, recording.hits.size()); ++rate) {
    if (rate > 0) {
      const auto [period, offset] = rate < recording.rates.size() ? recording.rates[rate] : std::pair(0.0, 0.0);
      out += ",\n{\"period\": ";
      add_number(out, period);
      out += ", \"offset\": ";
      add_number(out, offset);
      out += ", \"time\": ";
    } else {
      out += "{\"time\": ";
    }
    std::vector<double> times;
    for_rows_of(recording, static_cast<int>(rate), [&](std::size_t row) { times.push_back(recording.time()[row]); });
    add_list(out, times);
    if (rate == 0) {
      out += ", \"side\": [";
      for (std::size_t row = 0; row < recording.rows(); ++row) {
        if (row > 0) out += ',';
        out += std::array{"-1", "0", "1"}[static_cast<std::size_t>(recording.side()[row] + 1)];
      }
      out += ']';
    }
    out += '}';
  }
  out += "],\n";
}

void add_columns(std::string& out, const Recording& recording) {
  out += "\"columns\": [\n";
  bool first = true;
  for (const std::size_t index : written_columns(recording)) {
    const RecordedColumn& column = recording.columns[index];
    if (!first) out += ",\n";
    first = false;
    out += "{\"name\": ";
    add_text(out, column.name);
    out += ", \"unit\": ";
    add_text(out, column.unit);
    out += ", \"rate\": " + std::to_string(column.rate);
    if (!column.names.empty()) {
      out += ", \"names\": [";
      for (std::size_t i = 0; i < column.names.size(); ++i) {
        out += i > 0 ? ", " : "";
        add_text(out, column.names[i]);
      }
      out += "]";
    }
    out += ", \"values\": ";
    std::vector<double> values;
    for_rows_of(recording, column.rate, [&](std::size_t row) { values.push_back(recording.at(row, index)); });
    add_list(out, values);
    out += '}';
  }
  out += "],\n";
}

}  // namespace

void add_number(std::string& out, double value) {
  if (!std::isfinite(value)) {
    out += "null";
    return;
  }
  std::array<char, 32> text{};
  out.append(text.data(), std::to_chars(text.data(), text.data() + text.size(), value).ptr);
}

void add_text(std::string& out, std::string_view text) {
  constexpr std::string_view digits = "0123456789abcdef";
  out += '"';
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      out += '\\';
      out += c;
    } else if (c == '\n') {
      out += "\\n";
    } else if (byte < 0x20) {
      out += "\\u00";
      out += digits[byte >> 4U];
      out += digits[byte & 0xFU];
    } else {
      out += c;
    }
  }
  out += '"';
}

std::string to_json(const Recording& recording) {
  std::string out = "{\"plantloop_recording\": " + std::to_string(recording_format) + ",\n\"provenance\": {";
  bool first = true;
  for (const auto& [key, text] : recording.provenance) {
    out += first ? "" : ", ";
    first = false;
    add_text(out, key);
    out += ": ";
    add_text(out, text);
  }
  out += "},\n";
  add_rates(out, recording);
  add_columns(out, recording);
  out += "\"events\": {";
  first = true;
  for (const auto& [name, times] : recording.events) {
    out += first ? "" : ", ";
    first = false;
    add_text(out, name);
    out += ": ";
    add_list(out, times);
  }
  out += "}}\n";
  return out;
}

}  // namespace plantloop
