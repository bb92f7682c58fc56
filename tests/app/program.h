// Runs the program in a folder of its own.

#pragma once

#include <filesystem>
#include <string>

namespace plantloop::testing_program {

struct Outcome {
  int status = -1;
  std::string out, err;
};

// A temporary folder that goes with the test; diagrams are written into it, the program runs in it.
class Workplace {
 public:
  Workplace();
  ~Workplace();
  Workplace(const Workplace&) = delete;
  Workplace& operator=(const Workplace&) = delete;

  void write(const std::string& name, const std::string& text) const;
  std::string read(const std::string& name) const;
  bool has(const std::string& name) const { return std::filesystem::exists(folder_ / name); }
  // `plantloop <arguments>`, as a shell reads them.
  Outcome run(const std::string& arguments) const;

 private:
  std::filesystem::path folder_;
};

}  // namespace plantloop::testing_program
