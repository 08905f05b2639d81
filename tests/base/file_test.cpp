// Files that appear complete or not at all, and are never written through a link.
#include "host/base/file.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "host/base/errors.h"
#include "host/base/part_file.h"

namespace fascicle::tests {
namespace {

namespace fs = std::filesystem;
using base::File;
using base::FileMode;

// Another user's file, with a link to it at the output's path.
class FileBesideLinks : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "fascicle-test-XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = name;
    std::ofstream(folder_ / "victim") << "precious";
  }
  void TearDown() override { fs::remove_all(folder_); }
  fs::path link(const std::string& name) const {
    fs::create_symlink(folder_ / "victim", folder_ / name);
    return folder_ / name;
  }
  static std::string text_of(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  static bool is_plain(const fs::path& path) { return fs::is_regular_file(fs::symlink_status(path)); }
  std::string victim() const { return text_of(folder_ / "victim"); }

  fs::path folder_;
};

TEST_F(FileBesideLinks, ReplaceTakesTheLinksPlace) {
  const fs::path path = link("out");
  File(path, FileMode::replace).write("mine");
  EXPECT_EQ(victim(), "precious");
  EXPECT_EQ(text_of(path), "mine");
  EXPECT_TRUE(is_plain(path));
  // A dangling link is replaced too.
  fs::create_symlink(folder_ / "nowhere", folder_ / "lost");
  File(folder_ / "lost", FileMode::replace).write("mine");
  EXPECT_FALSE(fs::exists(folder_ / "nowhere"));
  EXPECT_TRUE(is_plain(folder_ / "lost"));
}

// A hard link is not a symbolic link, but the other name's content must survive as well.
TEST_F(FileBesideLinks, ReplaceLeavesAFilesOtherName) {
  fs::create_hard_link(folder_ / "victim", folder_ / "out");
  File(folder_ / "out", FileMode::replace).write("mine");
  EXPECT_EQ(victim(), "precious");
  EXPECT_EQ(text_of(folder_ / "out"), "mine");
}

TEST_F(FileBesideLinks, ModifyRefuses) {
  EXPECT_THROW(File(link("out"), FileMode::modify), base::BakeError);
  File(folder_ / "victim", FileMode::modify).write("!");
  EXPECT_EQ(victim(), "precious!");
  // As in a snapshot by `cp -al`.
  fs::create_hard_link(folder_ / "victim", folder_ / "snapshot");
  EXPECT_THROW(File(folder_ / "victim", FileMode::modify), base::BakeError);
  fs::remove(folder_ / "snapshot");
  EXPECT_NO_THROW(File(folder_ / "victim", FileMode::modify));
}

TEST_F(FileBesideLinks, ReadFollows) {
  EXPECT_EQ(File(link("in"), FileMode::read).size(), 8u);
}

TEST_F(FileBesideLinks, WholeFilesReplaceLinks) {
  const fs::path path = link("whole");
  link("whole.tmp");
  base::write_whole(path, "mine");
  EXPECT_EQ(text_of(path), "mine");
  EXPECT_TRUE(is_plain(path));
  const fs::path beside = link("beside");
  base::write_whole_beside_others(beside, "mine");
  EXPECT_TRUE(is_plain(beside));
  // Names that the suffix of a temporary file would make too long.
  for (const std::size_t length : {std::size_t{230}, std::size_t{250}, std::size_t{255}}) {
    const fs::path longest = folder_ / std::string(length, 'n');
    base::write_whole_beside_others(longest, "mine");
    EXPECT_EQ(text_of(longest), "mine") << length;
  }
  const fs::path staged = link("staged");
  link("staged.tmp");
  base::stage(staged, "mine");
  base::publish(folder_, std::vector<fs::path>{staged});
  EXPECT_TRUE(is_plain(staged));
  EXPECT_EQ(victim(), "precious");
}

TEST_F(FileBesideLinks, StreamsReplaceLinksAndDoNotResumeThem) {
  const fs::path path = link("stream");
  link("stream.part");
  base::PartFile stream = base::PartFile::start(path);
  stream.write("mine");
  stream.finish();
  EXPECT_EQ(text_of(path), "mine");
  EXPECT_TRUE(is_plain(path));
  const fs::path resumed = link("resumed");
  link("resumed.part");
  EXPECT_THROW(base::PartFile::resume(resumed, 3), base::BakeError);
  EXPECT_THROW(base::PartFile::resume_lines(resumed, 0), base::BakeError);
  EXPECT_EQ(victim(), "precious");
}

}  // namespace
}  // namespace fascicle::tests
