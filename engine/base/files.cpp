// Files: read whole, written whole or not at all, and only where a diagram may reach.

#include "engine/base/files.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <utility>

namespace plantloop {
namespace fs = std::filesystem;
namespace {

std::string words(int error) {
  if (error == ENOENT) return "there is no such file";
  if (error == EACCES || error == EPERM) return "it may not be opened (permissions)";
  if (error == EISDIR) return "it is a folder";
  if (error == ENOTDIR) return "a part of its path is no folder";
  if (error == ENOSPC) return "the disk is full";
  if (error == EROFS) return "the file system is read-only";
  return std::strerror(error);
}

struct Descriptor {
  int value;
  ~Descriptor() {
    if (value >= 0) ::close(value);
  }
};

bool is_inside(const fs::path& folder, const fs::path& path) {
  auto part = path.begin();
  for (const fs::path& name : folder) {
    if (name.empty()) continue;  // a trailing slash
    if (part == path.end() || *part != name) return false;
    ++part;
  }
  return true;
}

}  // namespace

FileResult read_file(const std::string& path, std::size_t limit) {
  // Without O_NONBLOCK a pipe would make us wait before we can refuse it.
  const Descriptor file{::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)};
  if (file.value < 0) return {{}, words(errno)};
  struct stat status {};
  if (::fstat(file.value, &status) != 0) return {{}, words(errno)};
  if (S_ISDIR(status.st_mode)) return {{}, words(EISDIR)};
  if (!S_ISREG(status.st_mode)) return {{}, "it is no regular file"};
  const auto too_large = [&] { return FileResult{{}, fmt::format("it is larger than {} MB", limit >> 20)}; };
  if (static_cast<std::size_t>(status.st_size) > limit) return too_large();
  std::string bytes(static_cast<std::size_t>(status.st_size) + 1, '\0');
  std::size_t size = 0;
  for (;;) {
    const ssize_t n = ::read(file.value, bytes.data() + size, bytes.size() - size);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return {{}, words(errno)};
    size += static_cast<std::size_t>(n);
    if (n == 0) break;
    if (size > limit) return too_large();  // it grew while we read
    if (size == bytes.size()) bytes.resize(2 * bytes.size());
  }
  bytes.resize(size);
  return {std::move(bytes), {}};
}

AtomicFile::AtomicFile(const std::string& path) : path_(path) {
  std::error_code ignored;
  // A link stays a link: what it points to is replaced.
  if (fs::is_symlink(path_, ignored)) path_ = fs::weakly_canonical(path_, ignored).string();
  if (const fs::path folder = fs::path(path_).parent_path(); !folder.empty()) {
    std::error_code failed;
    fs::create_directories(folder, failed);
    if (failed) {
      error_ = fmt::format("cannot make the folder '{}': {}", folder.string(), words(failed.value()));
      return;
    }
  }
  temporary_ = path_ + ".XXXXXX";
  descriptor_ = ::mkstemp(temporary_.data());
  if (descriptor_ < 0) {
    fail("open");
    return;
  }
  struct stat status {};
  const mode_t mask = ::umask(0);
  ::umask(mask);
  const mode_t mode = ::stat(path_.c_str(), &status) == 0 ? status.st_mode & 0777U : 0666U & ~mask;
  if (::fchmod(descriptor_, mode) != 0) fail("set the permissions of");
}

AtomicFile::~AtomicFile() {
  if (descriptor_ < 0) return;
  ::close(descriptor_);
  ::unlink(temporary_.c_str());
}

void AtomicFile::fail(const char* what) {
  if (error_.empty()) error_ = fmt::format("cannot {} it: {}", what, words(errno));
}

std::string why_not_writable(const std::string& path) {
  std::error_code ignored;
  if (fs::is_directory(path, ignored)) return "it is a folder";
  fs::path folder = fs::absolute(path, ignored).parent_path();
  while (!fs::exists(folder, ignored) && folder.has_relative_path()) folder = folder.parent_path();
  if (!fs::is_directory(folder, ignored)) return fmt::format("'{}' is not a folder", folder.string());
  if (::access(folder.c_str(), W_OK) != 0) return words(errno);
  return {};
}

void AtomicFile::write(std::string_view bytes) {
  constexpr std::size_t enough = 1 << 16;
  buffer_.append(bytes);
  if (buffer_.size() >= enough) flush();
}

void AtomicFile::flush() {
  std::string_view rest = buffer_;
  while (error_.empty() && !rest.empty()) {
    const ssize_t n = ::write(descriptor_, rest.data(), rest.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return fail("write");
    rest.remove_prefix(static_cast<std::size_t>(n));
  }
  buffer_.clear();
}

std::string AtomicFile::commit() {
  flush();
  if (!error_.empty()) return error_;
  if (::fsync(descriptor_) != 0 && errno != EINVAL) fail("write");
  if (::close(std::exchange(descriptor_, -1)) != 0) fail("write");
  if (error_.empty() && ::rename(temporary_.c_str(), path_.c_str()) != 0) fail("write");
  if (!error_.empty()) ::unlink(temporary_.c_str());
  return error_;
}

std::string write_file(const std::string& path, std::string_view bytes) {
  AtomicFile file(path);
  if (!file.error().empty()) return file.error();
  file.write(bytes);
  return file.commit();
}

std::string project_folder(const std::string& file) {
  std::error_code error;
  fs::path path = fs::weakly_canonical(fs::absolute(file, error), error);
  const fs::path own = path.parent_path();
  for (fs::path folder = own; !folder.empty(); folder = folder.parent_path()) {
    if (fs::exists(folder / ".git", error) || fs::exists(folder / "plantloop.yaml", error)) return folder.string();
    if (folder == folder.parent_path()) break;
  }
  return own.string();
}

FileResult resolve_path(const std::string& project, const std::string& from, const std::string& text) {
  if (text.empty()) return {{}, "the path is empty"};
  if (text.find("://") != std::string::npos) return {{}, "an address on the net is not read; name a file"};
  if (text.find('\0') != std::string::npos) return {{}, "a path has no NUL"};
  const fs::path named(text);
  if (named.is_absolute()) return {{}, "a path is relative to the file that contains it"};
  const fs::path joined = (fs::path(from).parent_path() / named).lexically_normal();
  std::error_code error;
  const fs::path real = fs::weakly_canonical(fs::absolute(joined, error), error);
  if (error) return {{}, words(error.value())};
  const fs::path root = fs::weakly_canonical(fs::absolute(project, error), error);
  if (!is_inside(root, real)) return {{}, "it lies outside of the project"};
  return {joined.string(), {}};
}

}  // namespace plantloop
