// A folder of its own for each test, in which scripts run and files are made.

#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <filesystem>

#include <string>
#include <string_view>
#include <vector>

#include "scripts/host/host.h"

namespace plantloop {

struct ScriptResult {
  int status = 0;
  std::string output, messages;
  double seconds = 0;
};

class Workshop : public ::testing::Test {
 protected:
  Workshop();
  ~Workshop() override;

  // Runs the text as the script `experiment.lua` of the project `project`, which is also the working directory.
  ScriptResult run(std::string_view script, const std::vector<std::string>& arguments = {});
  // What a script prints, without its last line end; the messages when it fails.
  std::string printed(const std::string& script);
  // What an expression is, as `print` shows it; `pl` is there.
  std::string value(const std::string& expression);
  // The message of a failing script, without the trace.
  std::string complaint(const std::string& script);

  void write(const std::string& path, std::string_view text) const;
  std::string read(const std::string& path) const;
  // A diagram of one first-order lag behind a step at 1 s: y = 1 - exp(-(t - 1)/tau), in lag.yaml.
  void write_lag() const;

  const std::filesystem::path& outside() const { return outside_; }  // the folder around the project
  ScriptOptions options;

 private:
  std::filesystem::path outside_, before_;
};

}  // namespace plantloop
