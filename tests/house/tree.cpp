// Reads the repository's text files once.

#include "tests/house/tree.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>

namespace plantloop::house {
namespace {

namespace fs = std::filesystem;

bool is_left_out(const fs::path& path) {
  const std::string name = path.filename().string();
  const bool hidden = name.starts_with('.') && name != ".ci" && fs::is_directory(path);
  return hidden || (path.parent_path() == "." && (name == "build" || name == "out"));
}

bool is_text(const fs::path& path) {
  if (path.filename() == ".git") return false;  // of a second working tree: a file that says where the first one is
  static constexpr std::array binary{".png", ".npz", ".pdf", ".otf", ".ttf", ".gz"};
  return std::ranges::find(binary, path.extension().string()) == binary.end();
}

TextFile read(const fs::path& path) {
  TextFile file{.path = path.lexically_normal().generic_string(), .lines = {}};
  std::ifstream in(path);
  for (std::string line; std::getline(in, line);) file.lines.push_back(line);
  return file;
}

}  // namespace

const std::vector<TextFile>& text_files() {
  static const std::vector<TextFile> files = [] {
    std::vector<TextFile> found;
    for (fs::recursive_directory_iterator at("."), end; at != end; ++at) {
      if (is_left_out(at->path())) at.disable_recursion_pending();
      if (at->is_regular_file() && is_text(at->path())) found.push_back(read(at->path()));
    }
    std::ranges::sort(found, {}, &TextFile::path);
    return found;
  }();
  return files;
}

std::vector<TextFile> cpp_files() {
  std::vector<TextFile> found;
  std::ranges::copy_if(text_files(), std::back_inserter(found),
                       [](const TextFile& file) { return file.path.ends_with(".h") || file.path.ends_with(".cpp"); });
  return found;
}

bool covers(std::string_view prefix, std::string_view path) {
  if (!path.starts_with(prefix)) return false;
  if (path.size() == prefix.size() || prefix.ends_with('/')) return true;
  const char next = path[prefix.size()];
  return next == '/' || next == '.' || next == '_';
}

std::string at_line(const TextFile& file, std::size_t index, std::string_view what) {
  return fmt::format("{}:{}: {}\n", file.path, index + 1, what);
}

}  // namespace plantloop::house
