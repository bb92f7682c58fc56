// Folders of tests: made below the system's folder for temporary files, removed afterwards.

#include "tests/scripts/workshop.h"

#include <cstdlib>

#include <chrono>
#include <fstream>
#include <iterator>
#include <sstream>

namespace plantloop {
namespace fs = std::filesystem;

Workshop::Workshop() : before_(fs::current_path()) {
  std::string name = (fs::canonical(fs::temp_directory_path()) / "plantloop-scripts-XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error("no folder for the test");
  outside_ = name;
  fs::create_directory(outside_ / "project");
  fs::current_path(outside_ / "project");
  write("plantloop.yaml", "");
  options.time_limit = 60;
  options.max_memory = std::size_t{256} << 20;
}

Workshop::~Workshop() {
  std::error_code ignored;
  fs::current_path(before_, ignored);
  fs::remove_all(outside_, ignored);
}

ScriptResult Workshop::run(std::string_view script, const std::vector<std::string>& arguments) {
  std::ostringstream output;
  std::ostringstream messages;
  ScriptOptions own = options;
  own.output = &output;
  own.messages = &messages;
  const auto start = std::chrono::steady_clock::now();
  ScriptResult result;
  result.status = run_script_text(script, "experiment.lua", arguments, own);
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  result.output = output.str();
  result.messages = messages.str();
  return result;
}

std::string Workshop::printed(const std::string& script) {
  ScriptResult result = run("local pl = require 'plantloop'; " + script);
  if (result.status != script_done) return result.messages;
  if (result.output.ends_with('\n')) result.output.pop_back();
  return result.output;
}

std::string Workshop::value(const std::string& expression) { return printed("print(" + expression + ")"); }

std::string Workshop::complaint(const std::string& script) {
  const ScriptResult result = run("local pl = require 'plantloop'; " + script);
  if (result.status == script_done) return "no error: " + result.output;
  return result.messages.substr(0, result.messages.find('\n'));
}

void Workshop::write(const std::string& path, std::string_view text) const {
  const fs::path parent = fs::path(path).parent_path();
  if (!parent.empty()) fs::create_directories(parent);
  std::ofstream(path, std::ios::binary) << text;
}

std::string Workshop::read(const std::string& path) const {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

void Workshop::write_lag() const {
  write("lag.yaml",
        "plantloop: 1\n"
        "title: A lag\n"
        "parameters: {tau: 2}\n"
        "blocks:\n"
        "  u: {type: step, time: 1, after: 1, unit: V}\n"
        "  y: {type: first_order, in: u, tau: tau, unit: m}\n"
        "  save: 2*y\n"
        "simulation: {stop: 5, rtol: 1e-9, atol: 1e-12}\n"
        "record: [u, y, save]\n"
        "figures:\n"
        "  response: {panels: [{y: [u, y], lines: [{y: 1, label: end}]}, {y: save}]}\n"
        "expect:\n"
        "  - {signal: y, max: 1}\n"
        "  - {signal: y, final: 2, abs: 0.1}\n");
}

}  // namespace plantloop
