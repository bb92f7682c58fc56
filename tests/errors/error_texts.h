// Wrong diagrams and the exact text that they must give: tests/errors/<layer>/<name>.yaml beside <name>.txt.
//
// Each layer's test instantiates the suite with its own way to check a file:
//
//   PLANTLOOP_ERROR_TEXTS(DiagramErrors, "tests/errors/diagram", [](const std::string& path, Report& report) { ... });

#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <vector>

#include "engine/base/report.h"

namespace plantloop {

using Check = std::function<void(const std::string& path, Report& report)>;

// The names, without ending, of the .yaml files directly in a folder.
std::vector<std::string> error_cases(const std::string& folder);
// Fails unless the check of <folder>/<name>.yaml reports the text of <folder>/<name>.txt.
void expect_error_text(const std::string& folder, const std::string& name, const Check& check);

}  // namespace plantloop

// NOLINTNEXTLINE: a macro, because GoogleTest's suites are macros.
#define PLANTLOOP_ERROR_TEXTS(suite, folder, ...)                                                \
  class suite : public testing::TestWithParam<std::string> {};                                   \
  TEST_P(suite, TellsTheUser) { plantloop::expect_error_text(folder, GetParam(), __VA_ARGS__); } \
  INSTANTIATE_TEST_SUITE_P(All, suite, testing::ValuesIn(plantloop::error_cases(folder)),        \
                           [](const auto& instance) { return instance.param; })
