// Files: read whole, written whole or not at all, and only where a diagram may reach.

#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace plantloop {

// A value, or why there is none, in words that follow "cannot read 'x': ".
struct FileResult {
  std::string value;
  std::string error;
  bool ok() const { return error.empty(); }
};

// The bytes of a regular file of at most `limit` bytes.
FileResult read_file(const std::string& path, std::size_t limit = std::size_t{64} << 20);

// A file that appears complete or not at all: written beside its target, flushed to disk and renamed by commit().
// Without commit() nothing is left behind; a killed run leaves the old file whole. Folders of the path that are missing
// are made.
class AtomicFile {
 public:
  explicit AtomicFile(const std::string& path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  void write(std::string_view bytes);
  // "" when the file is in place, else why not.
  std::string commit();
  const std::string& error() const { return error_; }

 private:
  void fail(const char* what);
  void flush();
  std::string path_, temporary_, error_, buffer_;
  int descriptor_ = -1;
};

// Why a file of that name could not be written, asked without writing; "" when it could.
std::string why_not_writable(const std::string& path);

// The same in one call; "" when the file is in place, else why not, in words that follow "cannot write 'x': ".
std::string write_file(const std::string& path, std::string_view bytes);

// The nearest folder upwards from the file that holds `.git` or `plantloop.yaml`, else the file's own folder. Absolute,
// links resolved.
std::string project_folder(const std::string& file);

// The path of a file that `from` (a file) names as `text`: relative to the folder of `from`, links resolved, inside
// `project`. The value is short where it can be: `from`'s folder joined with `text`. Whether the file exists is not
// asked.
FileResult resolve_path(const std::string& project, const std::string& from, const std::string& text);

}  // namespace plantloop
