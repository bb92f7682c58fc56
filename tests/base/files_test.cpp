// Files: limits, atomic writing, and the borders of a project.

#include "engine/base/files.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>

namespace plantloop {
namespace fs = std::filesystem;
namespace {

class Files : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "plantloop-XXXXXX").string();
    folder_ = fs::canonical(::mkdtemp(name.data()));
  }
  void TearDown() override { fs::remove_all(folder_); }
  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  std::size_t count() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
  }
  fs::path folder_;
};

TEST_F(Files, AreReadBackAsWritten) {
  const std::string bytes("a\0b\n\xff", 5);
  EXPECT_EQ(write_file(path("a"), bytes), "");
  const FileResult read = read_file(path("a"));
  EXPECT_TRUE(read.ok());
  EXPECT_EQ(read.value, bytes);
  EXPECT_EQ(write_file(path("a"), ""), "");
  EXPECT_EQ(read_file(path("a")).value, "");
}

TEST_F(Files, ReadingTellsWhyNot) {
  EXPECT_EQ(read_file(path("none")).error, "there is no such file");
  EXPECT_EQ(read_file(folder_.string()).error, "it is a folder");
  EXPECT_EQ(read_file("/dev/zero").error, "it is no regular file");
  ASSERT_EQ(::mkfifo(path("pipe").c_str(), 0600), 0);
  EXPECT_EQ(read_file(path("pipe")).error, "it is no regular file");
  write_file(path("large"), std::string(3 << 20, 'x'));
  EXPECT_EQ(read_file(path("large"), 2 << 20).error, "it is larger than 2 MB");
}

TEST_F(Files, WithoutCommitTheOldFileStaysAndNothingIsLeft) {
  write_file(path("a"), "old");
  {
    AtomicFile file(path("a"));
    file.write(std::string(1 << 20, 'x'));
    EXPECT_EQ(read_file(path("a")).value, "old");
    EXPECT_EQ(count(), 2U);
  }
  EXPECT_EQ(read_file(path("a")).value, "old");
  EXPECT_EQ(count(), 1U);
}

TEST_F(Files, WritingKeepsPermissionsAndLinks) {
  write_file(path("a"), "old");
  fs::permissions(path("a"), fs::perms::owner_read | fs::perms::owner_write);
  fs::create_symlink(path("a"), path("link"));
  EXPECT_EQ(write_file(path("link"), "new"), "");
  EXPECT_TRUE(fs::is_symlink(path("link")));
  EXPECT_EQ(read_file(path("a")).value, "new");
  EXPECT_EQ(fs::status(path("a")).permissions(), fs::perms::owner_read | fs::perms::owner_write);
}

TEST_F(Files, WritingMakesTheFoldersThatAreMissing) {
  EXPECT_EQ(why_not_writable(path("new/folder/a")), "");
  EXPECT_FALSE(fs::exists(path("new")));
  EXPECT_EQ(write_file(path("new/folder/a"), "x"), "");
  EXPECT_EQ(read_file(path("new/folder/a")).value, "x");
}

TEST_F(Files, WritingTellsWhyNot) {
  write_file(path("file"), "x");
  EXPECT_EQ(write_file(path("file/a"), "x"),
            "cannot make the folder '" + path("file") + "': a part of its path is no folder");
  EXPECT_EQ(why_not_writable(path("file/a")), "'" + path("file") + "' is not a folder");
  EXPECT_EQ(why_not_writable(path(".")), "it is a folder");
}

TEST_F(Files, AProjectIsTheNearestFolderWithItsMark) {
  fs::create_directories(folder_ / "p/q/r");
  EXPECT_EQ(project_folder(path("p/q/r/a.yaml")), path("p/q/r"));
  write_file(path("p/plantloop.yaml"), "");
  EXPECT_EQ(project_folder(path("p/q/r/a.yaml")), path("p"));
  fs::create_directory(folder_ / "p/q/.git");
  EXPECT_EQ(project_folder(path("p/q/r/a.yaml")), path("p/q"));
}

TEST_F(Files, PathsStayInsideTheProject) {
  fs::create_directories(folder_ / "p/q");
  const std::string project = path("p");
  const std::string from = path("p/q/a.yaml");
  EXPECT_EQ(resolve_path(project, from, "../b.yaml").value, path("p/b.yaml"));
  EXPECT_EQ(resolve_path(project, from, "x/../c.yaml").value, path("p/q/c.yaml"));
  EXPECT_EQ(resolve_path(project, from, "../../b.yaml").error, "it lies outside of the project");
  EXPECT_EQ(resolve_path(project, from, "../../pp/b.yaml").error, "it lies outside of the project");
  EXPECT_EQ(resolve_path(project, from, "/etc/passwd").error, "a path is relative to the file that contains it");
  EXPECT_FALSE(resolve_path(project, from, "http://example.org/a").ok());
  EXPECT_FALSE(resolve_path(project, from, "").ok());
  fs::create_symlink(folder_, folder_ / "p/q/up");
  EXPECT_EQ(resolve_path(project, from, "up/b.yaml").error, "it lies outside of the project");
}

}  // namespace
}  // namespace plantloop
