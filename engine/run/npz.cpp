// A recording as NPZ, which NumPy reads with numpy.load: native rates, each column an array of its name.
//
//   time, time.side       the times of the continuous rows, and -1, 1 or 0: left or right side of a jump, or neither
//   <column>              values; of a discrete column at its hits, whose times are <column>.time
//   time.hits.<rate>      rows of `time` at which a rate had its hits
//   time.meta             JSON: format version, provenance, rates, names, units and rates of the columns, events
//
// `time` is a reserved name in diagrams, so no column can be called like one of these.

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <nlohmann/json.hpp>
#include <optional>

#include "engine/run/native.h"
#include "engine/run/recording.h"
#include "engine/run/zip.h"

namespace plantloop {
namespace {

static_assert(std::endian::native == std::endian::little, "the arrays are written as they stand in memory");

template <typename T>
constexpr std::string_view type_code() {
  if constexpr (std::is_same_v<T, double>) return "<f8";
  if constexpr (std::is_same_v<T, std::int64_t>) return "<i8";
  if constexpr (std::is_same_v<T, std::int8_t>) return "|i1";
}

// An array file of NumPy, format 1.0: magic, version, length, a Python dictionary padded to 64 bytes, the numbers.
std::string array_file(std::string_view type, const std::string& shape, const void* values, std::size_t bytes) {
  std::string header = fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': {}, }}", type, shape);
  constexpr std::size_t before = 10;
  header.append(63 - (before + header.size()) % 64, ' ');
  header += '\n';
  std::string file("\x93NUMPY\x01\x00", 8);
  file += static_cast<char>(header.size() & 0xFFU);
  file += static_cast<char>(header.size() >> 8U);
  file += header;
  file.append(static_cast<const char*>(values), bytes);
  return file;
}

template <typename T>
std::string array_file(const std::vector<T>& values) {
  return array_file(type_code<T>(), fmt::format("({},)", values.size()), values.data(), values.size() * sizeof(T));
}

nlohmann::json meta_of(const Recording& recording) {
  nlohmann::json meta;
  meta["plantloop_recording"] = recording_format;
  meta["provenance"] = recording.provenance;
  meta["rates"] = recording.rates;
  meta["rate_count"] = recording.hits.size();
  meta["events"] = recording.events;
  meta["columns"] = nlohmann::json::array();
  for (const std::size_t index : written_columns(recording)) {
    const RecordedColumn& column = recording.columns[index];
    meta["columns"].push_back({{"name", column.name}, {"unit", column.unit}, {"rate", column.rate}});
    if (!column.names.empty()) meta["columns"].back()["names"] = column.names;
  }
  return meta;
}

// The numbers of an array file, or nothing when it is not one of that type with one dimension.
template <typename T>
std::optional<std::vector<T>> read_array(std::string_view file) {
  if (file.size() < 10 || !file.starts_with("\x93NUMPY\x01")) return std::nullopt;
  const std::size_t length =
      static_cast<unsigned char>(file[8]) + 256U * static_cast<std::size_t>(static_cast<unsigned char>(file[9]));
  if (file.size() < 10 + length) return std::nullopt;
  const std::string_view header = file.substr(10, length);
  const std::string_view data = file.substr(10 + length);
  const std::string type = fmt::format("'{}'", type_code<T>());
  if (header.find(type) == std::string_view::npos || data.size() % sizeof(T) != 0) return std::nullopt;
  std::vector<T> values(data.size() / sizeof(T));
  if (!values.empty()) std::memcpy(values.data(), data.data(), data.size());
  return values;
}

// Reads the members of one archive; `error` says what the first missing or strange one was.
struct Reader {
  const ZipResult& zip;
  std::string error;

  template <typename T>
  std::vector<T> array(const std::string& name) {
    const auto member = zip.members.find(name + ".npy");
    if (member == zip.members.end()) return missing<T>(fmt::format("it has no array '{}'", name));
    std::optional<std::vector<T>> values = read_array<T>(member->second);
    return values ? *values : missing<T>(fmt::format("array '{}' is not one that plantloop writes", name));
  }
  template <typename T>
  std::vector<T> missing(const std::string& why) {
    if (error.empty()) error = why;
    return {};
  }
};

// The rows of a recording from columns at their native rates.
std::string fill(Recording& recording, Reader& reader) {
  const std::vector<double> time = reader.array<double>("time");
  const std::vector<std::int8_t> side = reader.array<std::int8_t>("time.side");
  if (time.size() != side.size() || !std::is_sorted(time.begin(), time.end())) return "its times are damaged";
  for (std::size_t rate = 1; rate < recording.hits.size(); ++rate) {
    for (const std::int64_t row : reader.array<std::int64_t>(fmt::format("time.hits.{}", rate))) {
      const auto index = static_cast<std::size_t>(row);
      const std::vector<std::size_t>& before = recording.hits[rate];
      if (index >= time.size() || (!before.empty() && index <= before.back())) return "its hits are damaged";
      recording.hits[rate].push_back(index);
    }
  }
  std::vector<std::vector<double>> values;
  for (const RecordedColumn& column : recording.columns) {
    values.push_back(reader.array<double>(column.name));
    if (column.rate < 0 || (column.rate > 0 && static_cast<std::size_t>(column.rate) >= recording.hits.size()) ||
        values.back().size() != (column.rate == 0 ? time.size() : rows_of(recording, column.rate))) {
      return fmt::format("column '{}' has not as many values as times", column.name);
    }
  }
  if (!reader.error.empty()) return reader.error;
  std::vector<std::size_t> next(values.size(), 0);
  std::vector<double> row(values.size());
  recording.reserve(time.size());
  for (std::size_t r = 0; r < time.size(); ++r) {
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (recording.columns[i].rate == 0) {
        row[i] = values[i][r];
      } else if (!values[i].empty()) {
        const auto& hits = recording.hits[static_cast<std::size_t>(recording.columns[i].rate)];
        while (next[i] < hits.size() && hits[next[i]] <= r) ++next[i];
        row[i] = values[i][next[i] == 0 ? 0 : next[i] - 1];
      }
    }
    recording.append(time[r], side[r], row);
  }
  return {};
}

}  // namespace

std::string to_npz(const Recording& recording) {
  ZipWriter zip;
  zip.add("time.npy", array_file(recording.time()));
  zip.add("time.side.npy", array_file(recording.side()));
  const std::string meta = meta_of(recording).dump();
  zip.add("time.meta.npy", array_file(fmt::format("|S{}", meta.size()), "()", meta.data(), meta.size()));
  std::vector<std::vector<double>> hit_times(recording.hits.size());
  for (std::size_t rate = 1; rate < recording.hits.size(); ++rate) {
    std::vector<std::int64_t> rows;
    for (const std::size_t row : recording.hits[rate]) {
      rows.push_back(static_cast<std::int64_t>(row));
      hit_times[rate].push_back(recording.time()[row]);
    }
    zip.add(fmt::format("time.hits.{}.npy", rate), array_file(rows));
  }
  for (const std::size_t index : written_columns(recording)) {
    const RecordedColumn& column = recording.columns[index];
    std::vector<double> values;
    values.reserve(rows_of(recording, column.rate));
    for_rows_of(recording, column.rate, [&](std::size_t row) { values.push_back(recording.at(row, index)); });
    zip.add(column.name + ".npy", array_file(values));
    if (column.rate != 0) {
      zip.add(column.name + ".time.npy", array_file(hit_times[static_cast<std::size_t>(column.rate)]));
    }
  }
  return zip.finish();
}

RecordingResult from_npz(std::string_view bytes) {
  RecordingResult result;
  const ZipResult zip = read_zip(bytes);
  const auto fail = [&](std::string why) {
    result.recording = {};
    result.error = std::move(why);
    return result;
  };
  if (!zip.ok()) return fail(zip.error);
  const auto member = zip.members.find(std::string_view("time.meta.npy"));
  if (member == zip.members.end()) return fail("it is no recording of plantloop: it has no array 'time.meta'");
  const std::size_t header = member->second.find('\n');
  const auto meta = nlohmann::json::parse(
      header == std::string_view::npos ? std::string_view() : member->second.substr(header + 1), nullptr, false);
  try {
    if (meta.at("plantloop_recording").get<int>() > recording_format) {
      return fail("it was written by a newer plantloop");
    }
    Recording& recording = result.recording;
    meta.at("provenance").get_to(recording.provenance);
    meta.at("rates").get_to(recording.rates);
    meta.at("events").get_to(recording.events);
    recording.hits.resize(meta.at("rate_count").get<std::uint16_t>());
    for (const auto& column : meta.at("columns")) {
      recording.columns.push_back({.name = column.at("name").get<std::string>(),
                                   .unit = column.at("unit").get<std::string>(),
                                   .rate = column.at("rate").get<int>()});
      if (column.contains("names")) column.at("names").get_to(recording.columns.back().names);
    }
  } catch (const nlohmann::json::exception&) {
    return fail("its array 'time.meta' is damaged");
  }
  Reader reader{zip, {}};
  if (std::string why = fill(result.recording, reader); !why.empty() || !reader.error.empty()) {
    return fail(reader.error.empty() ? why : reader.error);
  }
  return result;
}

}  // namespace plantloop
