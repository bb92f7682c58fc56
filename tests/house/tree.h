// The files of the repository as lines of text, for tests that look at the tree itself.

#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace plantloop::house {

struct TextFile {
  std::string path;  // from the root, with '/'
  std::vector<std::string> lines;
};

// Every text file of the repository in order of its path; build folders, written figures and hidden folders but .ci are
// left out. The root is the working directory.
const std::vector<TextFile>& text_files();

// Those of them that are C++.
std::vector<TextFile> cpp_files();

// True when `path` is `prefix`, lies below it, or is the file `prefix` with some ending: "engine/block" covers
// engine/block.h.
bool covers(std::string_view prefix, std::string_view path);

// "path:12: what", with lines counted from 1; what an editor can jump to.
std::string at_line(const TextFile& file, std::size_t index, std::string_view what);

}  // namespace plantloop::house
