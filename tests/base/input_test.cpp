// What is accepted as input: regular files up to a size limit, and nothing that could block.
#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include "host/base/errors.h"
#include "host/base/file.h"

namespace fascicle::tests {
namespace {

namespace fs = std::filesystem;

class ReadInput : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("fascicle-inputs-" + std::to_string(getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path write(const std::string& text) const {
    std::ofstream(folder_ / "file") << text;
    return folder_ / "file";
  }
  template <class Read>
  static std::string refusal(const Read& read) {
    try {
      (void)read();
    } catch (const base::InputError& error) {
      return error.what();
    }
    return "no error";
  }
  static std::string refusal_of(const fs::path& path, std::uint64_t most_bytes = 1000) {
    return refusal([&] { return base::read_input(path, most_bytes); });
  }

  fs::path folder_;
};

TEST_F(ReadInput, TakesAWholeFile) {
  EXPECT_EQ(base::read_input(write("text"), 4), "text");
  EXPECT_EQ(base::read_input(write(""), 0), "");
  EXPECT_EQ(base::read_input_bytes(write("ab"), 9), (std::vector<unsigned char>{'a', 'b'}));
  EXPECT_EQ(base::read_input_if_there(folder_ / "none", 9), std::nullopt);
  EXPECT_EQ(base::read_input_if_there(write("a") / "below", 9), std::nullopt);
}

TEST_F(ReadInput, ReadsToTheEndOfFilesThatSayTheyAreEmpty) {
  const std::string status = base::read_input("/proc/self/status", 1 << 20);
  EXPECT_NE(status.find("\nPid:"), std::string::npos);
  EXPECT_NE(refusal_of("/proc/self/status", 10).find("more than the 10 bytes"), std::string::npos);
}

TEST_F(ReadInput, RefusesWhatIsTooLarge) {
  EXPECT_EQ(refusal_of(write("12345"), 4),
            (folder_ / "file").string() +
                ": has more than the 4 bytes allowed for such a file; is it the right one?");
}

TEST_F(ReadInput, WaitsForNothing) {
  const fs::path pipe = folder_ / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  for (const fs::path& path : {pipe, folder_, fs::path("/dev/zero"), fs::path("/dev/null")}) {
    EXPECT_EQ(refusal_of(path), path.string() + ": is not a regular file; give the name of one");
    if (path != folder_) {
      EXPECT_EQ(refusal([&] { return base::File(path, base::FileMode::read).size(); }), refusal_of(path));
    }
  }
  EXPECT_EQ(refusal([&] { return base::File(pipe, base::FileMode::modify).size(); }), refusal_of(pipe));
  EXPECT_EQ(refusal([&] { return base::read_input_if_there(pipe, 10); }), refusal_of(pipe));
  EXPECT_EQ(refusal_of(folder_ / "none"), (folder_ / "none").string() + ": does not exist");
}

TEST_F(ReadInput, FollowsLinksWhereThatIsWanted) {
  fs::create_symlink(write("text"), folder_ / "link");
  EXPECT_EQ(base::read_input(folder_ / "link", 9), "text");
  EXPECT_NE(refusal([&] { return base::read_input_bytes(folder_ / "link", 9, base::Links::refused); }),
            "no error");
}

}  // namespace
}  // namespace fascicle::tests
