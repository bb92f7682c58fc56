// All commands.

#pragma once

#include <string>
#include <utility>
#include <vector>

#include "app/command.h"

namespace plantloop::app {

// Name and maker of each command, sorted by name; made by CMake from file names.
std::vector<std::pair<std::string, Action (*)(CLI::App&)>> commands();

}  // namespace plantloop::app
