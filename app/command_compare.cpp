// plantloop compare: whether two results, or two pictures, are the same.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "app/command.h"
#include "app/difference.h"
#include "app/draw.h"
#include "app/request.h"
#include "engine/base/files.h"
#include "engine/run/compare.h"
#include "render/error.h"
#include "render/image.h"

namespace plantloop::app {

namespace {

struct CompareOptions {
  std::string found, wanted;
  std::string figure;
  Tolerance tolerance;
};

constexpr std::size_t most_drawn = 3;  // signals in the figure

// A result as named signals.
struct Result {
  std::vector<std::string> names;
  std::vector<SampledSignal> signals;
  const SampledSignal* find(const std::string& name) const {
    const auto at = std::find(names.begin(), names.end(), name);
    return at == names.end() ? nullptr : &signals[static_cast<std::size_t>(at - names.begin())];
  }
};

// Nothing after complaining.
std::optional<Result> read_result(const std::string& path) {
  const FileResult file = read_file(path, std::size_t{4} << 30);
  const auto wrong = [&](const std::string& why) {
    complain(fmt::format("cannot read '{}': {}", path, why));
    return std::nullopt;
  };
  if (!file.ok()) return wrong(file.error);
  Result result;
  if (extension_of(path) == ".npz") {
    const RecordingResult read = from_npz(file.value);
    if (!read.ok()) return wrong(read.error);
    for (std::size_t i = 0; i < read.recording.columns.size(); ++i) {
      result.names.push_back(read.recording.columns[i].name);
      result.signals.push_back(signal_of(read.recording, i));
    }
    return result;
  }
  const CsvResult read = read_csv(file.value);
  if (!read.ok()) return wrong(fmt::format("line {}: {}", read.line, read.error));
  const int time = read.table.find("time");
  if (time < 0) return wrong("it has no column 'time'");
  const auto& times = read.table.columns[static_cast<std::size_t>(time)];
  if (!std::is_sorted(times.begin(), times.end())) return wrong("its times do not ascend");
  for (std::size_t i = 0; i < read.table.names.size(); ++i) {
    if (static_cast<int>(i) == time) continue;
    result.names.push_back(read.table.names[i]);
    result.signals.push_back(signal_of(read.table, i, static_cast<std::size_t>(time)));
  }
  return result;
}

// The worse of both directions: no sample of either file may be missed by the other.
Deviation compare_both_ways(const SampledSignal& found, const SampledSignal& wanted, const Tolerance& tolerance) {
  const Deviation one = worst_deviation(found, wanted, tolerance);
  Tolerance back = tolerance;
  back.of_signal = true;
  Deviation other = worst_deviation(wanted, found, back);
  std::swap(other.found, other.wanted);
  const bool other_is_worse =
      one.met != other.met ? one.met : other.distance - other.allowed > one.distance - one.allowed;
  return other_is_worse ? other : one;
}

std::string describe(const ComparedSignal& s, const CompareOptions& o) {
  const Deviation& d = s.deviation;
  if (d.outside) return fmt::format("  {}: at {:g} s only one of them has a value\n", s.name, d.time);
  return fmt::format("  {}: differs most at {:.9g} s, {:.9g} in {} and {:.9g} in {}: by {:g}, allowed {:g}\n", s.name,
                     d.time, d.found, o.found, d.wanted, o.wanted, d.distance, d.allowed);
}

// false after complaining.
bool draw(const Figure& figure, const std::string& path) {
  if (path.empty()) return true;
  const std::string error = write_figure(figure, path);
  if (!error.empty()) complain(error);
  return error.empty();
}

int compare_results(const CompareOptions& o) {
  const std::optional<Result> found = read_result(o.found), wanted = read_result(o.wanted);
  if (!found || !wanted) return input_wrong;
  std::vector<ComparedSignal> differing;
  std::string text;
  for (const std::string& name : wanted->names) {
    if (!found->find(name)) text += fmt::format("  {}: only in {}\n", name, o.wanted);
  }
  for (std::size_t i = 0; i < found->names.size(); ++i) {
    const SampledSignal* other = wanted->find(found->names[i]);
    if (other == nullptr) {
      text += fmt::format("  {}: only in {}\n", found->names[i], o.found);
      continue;
    }
    const Deviation d = compare_both_ways(found->signals[i], *other, o.tolerance);
    if (d.met) continue;
    differing.push_back({found->names[i], found->signals[i], *other, o.tolerance, d});
    text += describe(differing.back(), o);
  }
  if (text.empty()) return write_out(fmt::format("{} and {} agree\n", o.found, o.wanted)) ? done : run_failed;
  write_out(fmt::format("{} and {} differ\n{}", o.found, o.wanted, text));
  std::stable_sort(differing.begin(), differing.end(), [](const ComparedSignal& a, const ComparedSignal& b) {
    return a.deviation.distance - a.deviation.allowed > b.deviation.distance - b.deviation.allowed;
  });
  if (differing.size() > most_drawn) differing.resize(most_drawn);
  if (!differing.empty() && draw(figure_of(differing, o.found, o.wanted), o.figure) && !o.figure.empty())
    write_out(fmt::format("  drawn in {}\n", o.figure));
  return run_failed;
}

std::optional<Image> read_picture(const std::string& path) {
  const FileResult file = read_file(path);
  std::string error = file.error;
  if (file.ok()) {
    try {
      return decode_png({reinterpret_cast<const std::uint8_t*>(file.value.data()), file.value.size()});
    } catch (const RenderError& e) {
      error = e.what();
    }
  }
  complain(fmt::format("cannot read '{}': {}", path, error));
  return std::nullopt;
}

int compare_pictures(const CompareOptions& o) {
  const std::optional<Image> found = read_picture(o.found), wanted = read_picture(o.wanted);
  if (!found || !wanted) return input_wrong;
  if (found->width != wanted->width || found->height != wanted->height) {
    write_out(fmt::format("{} and {} differ: one has {} x {} pixels, the other {} x {}\n", o.found, o.wanted,
                          found->width, found->height, wanted->width, wanted->height));
    return run_failed;
  }
  std::size_t differing = 0;
  int most = 0;
  for (std::size_t i = 0; i + 2 < found->rgb.size(); i += 3) {
    int d = 0;
    for (std::size_t c = 0; c < 3; ++c) d = std::max(d, std::abs(found->rgb[i + c] - wanted->rgb[i + c]));
    if (d > 0) ++differing;
    most = std::max(most, d);
  }
  if (differing == 0) return write_out(fmt::format("{} and {} agree\n", o.found, o.wanted)) ? done : run_failed;
  write_out(fmt::format("{} and {} differ in {} of {} pixels, by up to {} of 255\n", o.found, o.wanted, differing,
                        found->rgb.size() / 3, most));
  if (o.figure.empty()) return run_failed;
  constexpr double dpi = 152.4;  // that of figures
  const std::vector<std::uint8_t> bytes = encode_png(difference_of(*found, *wanted), dpi);
  if (write_result(o.figure, {reinterpret_cast<const char*>(bytes.data()), bytes.size()}))
    write_out(fmt::format("  drawn in {}\n", o.figure));
  return run_failed;
}

int compare(const CompareOptions& o) {
  const bool one = extension_of(o.found) == ".png", other = extension_of(o.wanted) == ".png";
  if (one != other) {
    complain(fmt::format("{} and {}: a picture can be compared with a picture only", o.found, o.wanted));
    return input_wrong;
  }
  return one ? compare_pictures(o) : compare_results(o);
}

}  // namespace

}  // namespace plantloop::app

PLANTLOOP_COMMAND(compare) {
  using namespace plantloop::app;
  const auto o = std::make_shared<CompareOptions>();
  o->figure = "out/difference.png";
  parser.description(
      "Compare two results (.csv or .npz), or two pictures (.png). Results may have different times: each sample is "
      "compared with the other file's value at that time. Without tolerances they must agree to the last digit.");
  parser.add_option("A", o->found, "the result to look at")->required();
  parser.add_option("B", o->wanted, "what it should be; tolerances are relative to its values")->required();
  parser.add_option("--rtol", o->tolerance.rel, "allowed difference as a part of the value")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  parser.add_option("--atol", o->tolerance.abs, "allowed difference in the signal's unit, in addition")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  parser.add_option("--shift", o->tolerance.shift, "allowed difference in time, in s")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  parser.add_option("--figure", o->figure, "file for the picture of what differs, .png or .svg; \"\" for none")
      ->capture_default_str();
  parser.footer(
      "Exit status 0 when they agree, 1 when they differ, 2 when a file cannot be read.\n\n"
      "Examples:\n"
      "  plantloop compare new.csv old.csv --rtol 1e-6 --atol 1e-9\n"
      "  plantloop compare out/speed.png expected/speed.png --figure out/speed-difference.png");
  return [o] { return compare(*o); };
}
