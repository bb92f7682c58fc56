// The files of a diagram: each read once, with the types that it may name.

#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "engine/diagram/model.h"

namespace plantloop {

class Files {
 public:
  Files(std::string project, Report& report) : project_(std::move(project)), report_(report) {}

  // What a file brings: its scope, and the types written in it.
  struct File {
    std::shared_ptr<FileScope> scope;
    std::map<std::string, std::shared_ptr<const TypeDecl>> own;
    bool complete = false;  // false while it is being read
  };

  // The diagram itself, whose tree is given.
  const File& add_root(const std::string& path, Node& root);

  std::vector<std::shared_ptr<const FileScope>> scopes;
  std::vector<std::shared_ptr<const Source>> sources;

 private:
  void read_types(File& file, Node& root);
  void read_imports(File& file, const Node& root);
  void import(File& into, const std::string& prefix, const Node& path);
  const File* load(const std::string& path, const Node& from);
  void bring(File& into, const std::string& name, const std::shared_ptr<const TypeDecl>& type, const Node& from);

  std::string project_;
  Report& report_;
  std::map<std::string, File> files_;                       // by path with links resolved
  std::vector<std::pair<std::string, std::string>> chain_;  // the files being read: key of files_, path as written
};

// The keys of a file's top level, checked; false when the file is not one of this format.
bool check_top_level(const Node& root, Report& report);

}  // namespace plantloop
