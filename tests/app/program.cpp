// A shell reads the arguments, so that tests write commands as a user types them.

#include "tests/app/program.h"

#include <sys/wait.h>

#include <cstdlib>
#include <stdexcept>

#include "engine/base/files.h"

namespace plantloop::testing_program {

Workplace::Workplace() {
  std::string name = (std::filesystem::temp_directory_path() / "plantloop-test-XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder");
  folder_ = name;
}

Workplace::~Workplace() {
  std::error_code ignored;
  std::filesystem::remove_all(folder_, ignored);
}

void Workplace::write(const std::string& name, const std::string& text) const {
  std::filesystem::create_directories((folder_ / name).parent_path());
  const std::string error = write_file((folder_ / name).string(), text);
  if (!error.empty()) throw std::runtime_error(error);
}

std::string Workplace::read(const std::string& name) const {
  FileResult file = read_file((folder_ / name).string());
  if (!file.ok()) throw std::runtime_error(name + ": " + file.error);
  return file.value;
}

Outcome Workplace::run(const std::string& arguments) const {
  const std::string command =
      "cd '" + folder_.string() + "' && '" PLANTLOOP_PROGRAM "' " + arguments + " > .out 2> .err < /dev/null";
  const int status = std::system(command.c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, read(".out"), read(".err")};
}

}  // namespace plantloop::testing_program
