// Options that several commands have in common.

#pragma once

#include <CLI/CLI.hpp>
#include <memory>
#include <string>
#include <vector>

#include "engine/run/diagram.h"

namespace plantloop::app {

// --set path=expression, any number of times.
CLI::Option* add_set_option(CLI::App& parser, std::vector<std::string>& texts);
// --strict: warnings become errors.
CLI::Option* add_strict_option(CLI::App& parser, bool& strict);
// "path=expression" texts as overrides; false after complaining.
bool read_overrides(const std::vector<std::string>& texts, Overrides& overrides);

// ".csv" of "out/a.csv"
std::string extension_of(const std::string& path);
// The diagram of a file without errors, or null after printing what is wrong with it.
std::shared_ptr<Diagram> load_diagram(const std::string& path, Report& report);
// Writes the bytes; false after complaining.
bool write_result(const std::string& path, const std::string& bytes);

}  // namespace plantloop::app
