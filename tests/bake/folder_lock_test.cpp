#include <cerrno>
#include <filesystem>

#include <gtest/gtest.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "host/bake/bake.h"
#include "host/bake/folder.h"
#include "tests/bake/fake_solver.h"

namespace {

enum class Locks { all, files_only, none };

Locks& locks() {
  static Locks kind = Locks::all;
  return kind;
}

}  // namespace

// In place of the C library's: NFS refuses to lock a folder with EBADF, and some file systems lock nothing.
extern "C" int flock(int descriptor, int operation) noexcept {
  struct stat about {};
  const bool is_folder = ::fstat(descriptor, &about) == 0 && S_ISDIR(about.st_mode);
  if (locks() == Locks::none || (locks() == Locks::files_only && is_folder)) {
    errno = is_folder ? EBADF : ENOLCK;
    return -1;
  }
  return static_cast<int>(::syscall(SYS_flock, descriptor, operation));
}

namespace fascicle::tests {
namespace {

namespace fs = std::filesystem;
using bake::FolderLock;

class FolderLocks : public testing::TestWithParam<Locks> {
 protected:
  FolderLocks() { locks() = GetParam(); }
  ~FolderLocks() override { locks() = Locks::all; }
  const TemporaryFolder folder_;
  const fs::path file_ = folder_ / bake::lock_name;
};

INSTANTIATE_TEST_SUITE_P(Everywhere, FolderLocks, testing::Values(Locks::all, Locks::files_only));

TEST_P(FolderLocks, HoldUntilTheyAreDestroyed) {
  {
    const FolderLock one(folder_ / "");
    EXPECT_THROW(FolderLock(folder_ / ""), bake::FolderInUse);
    EXPECT_TRUE(bake::is_in_use_here(folder_ / ""));
    EXPECT_EQ(fs::exists(file_), GetParam() == Locks::files_only);
  }
  EXPECT_FALSE(bake::is_in_use_here(folder_ / ""));
  EXPECT_FALSE(fs::exists(file_));
  EXPECT_NO_THROW(FolderLock(folder_ / ""));
}

// What a killed bake leaves holds no lock.
TEST(FolderLocksOfFiles, TakeOverAFileThatIsLeft) {
  locks() = Locks::files_only;
  const TemporaryFolder folder;
  const fs::path file = folder / bake::lock_name;
  write_text(file, "");
  {
    const FolderLock one(folder / "");
    EXPECT_THROW(FolderLock(folder / ""), bake::FolderInUse);
  }
  EXPECT_FALSE(fs::exists(file));
  // No file behind a link is opened or removed.
  write_text(folder / "other", "precious");
  fs::create_symlink("other", file);
  EXPECT_THROW(FolderLock(folder / ""), bake::BakeError);
  EXPECT_EQ(read_text(folder / "other"), "precious");
  locks() = Locks::all;
}

// The control of the above: two bakes in one folder, as before.
TEST(FolderLocksOfFiles, AreNotNeededWhereNothingCanBeLocked) {
  locks() = Locks::none;
  const TemporaryFolder folder;
  {
    const FolderLock one(folder / "");
    EXPECT_NO_THROW(FolderLock(folder / ""));
    EXPECT_FALSE(bake::is_in_use_here(folder / ""));
  }
  EXPECT_FALSE(fs::exists(folder / bake::lock_name));
  locks() = Locks::all;
}

}  // namespace
}  // namespace fascicle::tests
