// Reading what several commands take.

#include "app/request.h"

#include <fmt/format.h>

#include <filesystem>

#include "app/command.h"
#include "app/figures.h"
#include "engine/base/files.h"

namespace plantloop::app {

CLI::Option* add_set_option(CLI::App& parser, std::vector<std::string>& texts) {
  return parser
      .add_option("--set", texts, "give a parameter another value or expression: path=expression, any number of times")
      ->allow_extra_args(false)
      ->type_name("PATH=EXPRESSION");
}

CLI::Option* add_strict_option(CLI::App& parser, bool& strict) {
  return parser.add_flag("--strict", strict, "take every warning as an error, also what is noticed during a run");
}

bool read_overrides(const std::vector<std::string>& texts, Overrides& overrides) {
  for (const std::string& text : texts) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos || equals == 0) {
      complain(fmt::format("--set {}: it must be path=expression, as in --set controller.ki=20", text));
      return false;
    }
    overrides.push_back({text.substr(0, equals), text.substr(equals + 1)});
  }
  return true;
}

std::string extension_of(const std::string& path) { return std::filesystem::path(path).extension().string(); }

std::shared_ptr<Diagram> load_diagram(const std::string& path, Report& report) {
  auto diagram = Diagram::load(path, report, plot_words());
  if (diagram && !report.has_errors()) return diagram;
  print(report);
  return nullptr;
}

bool write_result(const std::string& path, const std::string& bytes) {
  const std::string error = write_file(path, bytes);
  if (error.empty()) return true;
  complain(fmt::format("cannot write '{}': {}", path, error));
  return false;
}

}  // namespace plantloop::app
