// `fascicle verify` on intact bakes, and on bakes with any byte changed.
#include "host/bake/verify.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <sys/resource.h>

#include "host/bake/folder.h"
#include "host/bake/manifest.h"
#include "host/bake/read_frame_cache.h"
#include "tests/bake/fake_bakes.h"

namespace fascicle::tests {
namespace {

namespace fs = std::filesystem;
using bake::verify_bake;
using bake::VerifyResult;

std::string finding_of(const VerifyResult& result, const std::string& name) {
  for (const bake::VerifiedFile& file : result.files)
    if (file.name == name) return (file.is_good ? "good: " : "wrong: ") + file.finding;
  return "not looked at";
}

void flip(const fs::path& path, std::uint64_t at) {
  std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
  file.seekg(static_cast<std::streamoff>(at));
  const auto byte = static_cast<unsigned char>(file.get());
  file.seekp(static_cast<std::streamoff>(at));
  file.put(static_cast<char>(byte ^ 0x10u));
}

// A bake in a fresh folder, frames 0 to 6.
class Verify : public testing::Test {
 protected:
  void SetUp() override { fake_bake_into(options_for(bake), short_scene(6)); }
  VerifyResult verified() const { return verify_bake({.bake = bake}); }

  TemporaryFolder folder_;
  const fs::path bake = folder_ / "out";
};

TEST_F(Verify, FindsNothingInABakeAsItWasWritten) {
  const VerifyResult result = verified();
  EXPECT_TRUE(result.is_good());
  EXPECT_EQ(result.status, "complete");
  EXPECT_EQ(finding_of(result, "frames.fascicle"), "good: 7 frames, all good");
  EXPECT_EQ(finding_of(result, "metrics.csv"), "good: 7 rows");
  EXPECT_EQ(finding_of(result, "model.fascicle").rfind("good: ", 0), 0U);
}

TEST_F(Verify, FindsNothingInABakeThatWasStopped) {
  const fs::path stopped = folder_ / "stopped";
  bake_until(options_for(stopped), short_scene(6), 3);
  const VerifyResult result = verify_bake({.bake = stopped});
  EXPECT_TRUE(result.is_good());
  EXPECT_EQ(result.status, "interrupted");
  EXPECT_EQ(finding_of(result, "frames.fascicle"), "good: 4 of 7 frames, all good");
  EXPECT_EQ(finding_of(result, "checkpoint"), "good: of frame 3, good");
}

// Bytes everywhere: in headers, numbers, checksums and padding.
TEST_F(Verify, FindsAnyByteThatIsNotAsItWas) {
  for (const char* name : {"frames.fascicle", "model.fascicle", "checkpoint"}) {
    const fs::path path = bake / name;
    ASSERT_TRUE(fs::exists(path)) << name;
    const std::uint64_t size = fs::file_size(path);
    for (std::uint64_t at = 0; at < size; at += std::max<std::uint64_t>(1, size / 3000)) {
      flip(path, at);
      EXPECT_FALSE(verified().is_good()) << name << ", byte " << at;
      flip(path, at);
    }
    EXPECT_TRUE(verified().is_good()) << name;
  }
}

TEST_F(Verify, NamesTheFrames) {
  const std::uint64_t record = (fs::file_size(bake / "frames.fascicle") - 104) / 7;
  for (const std::uint64_t k : {1u, 3u, 4u}) flip(bake / "frames.fascicle", 104 + k * record + 40);
  EXPECT_EQ(finding_of(verified(), "frames.fascicle"), "wrong: damaged: frames 1, 3 to 4");
}

TEST_F(Verify, FindsWhatIsCutOff) {
  for (const char* name : {"frames.fascicle", "model.fascicle", "checkpoint"}) {
    const std::uint64_t size = fs::file_size(bake / name);
    for (const std::uint64_t left :
         {size - 1, size / 2, std::uint64_t{105}, std::uint64_t{1}, std::uint64_t{0}}) {
      const fs::path whole = folder_ / "whole";
      fs::copy_file(bake / name, whole, fs::copy_options::overwrite_existing);
      fs::resize_file(bake / name, left);
      EXPECT_FALSE(verified().is_good()) << name << " of " << left << " bytes";
      fs::copy_file(whole, bake / name, fs::copy_options::overwrite_existing);
    }
  }
}

TEST_F(Verify, FindsWhatIsMissingOfAStoppedBake) {
  const fs::path stopped = folder_ / "stopped";
  bake_until(options_for(stopped), short_scene(6), 3);
  const std::uint64_t size = fs::file_size(stopped / "frames.fascicle");
  flip(stopped / "frames.fascicle", size - 20);
  const std::string wanted = "wrong: missing or damaged at the end: frame 3";
  EXPECT_EQ(finding_of(verify_bake({.bake = stopped}), "frames.fascicle"), wanted);
  fs::resize_file(stopped / "frames.fascicle", size - 20);
  EXPECT_EQ(finding_of(verify_bake({.bake = stopped}), "frames.fascicle"), wanted);
}

// A list of that many numbers would not fit into memory.
TEST_F(Verify, CountsTheMissingFramesOfAHeaderThatLies) {
  const fs::path path = bake / "frames.fascicle";
  const auto lie = [&](std::uint64_t frames) {
    bake::CacheHeader header = bake::FrameCacheReader(path).header();
    header.frames = frames;
    const std::string bytes = bake::encode_cache_header(header);
    std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
    file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  };
  lie(10'000'000);
  EXPECT_TRUE(contains(finding_of(verified(), "frames.fascicle"),
                       "missing or damaged at the end: frames 7 to 10000000"));
  lie(10'000'001);
  EXPECT_TRUE(contains(finding_of(verified(), "frames.fascicle"), "impossible frame rate, start or size"));
}

// A sparse file takes no space, whatever its length.
TEST_F(Verify, IsNotHeldUpByAFileThatIsMuchTooLong) {
  fs::resize_file(bake / "frames.fascicle", std::uint64_t{1} << 42);
  EXPECT_TRUE(verified().is_good());
}

// A frame's checksum is checked before the frame takes memory: this one would take 2 GiB, which the limit is
// below.
TEST_F(Verify, ALongFrameTakesNoMemoryBeforeItIsKnownToBeWhole) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "SKIPPED: sanitizers need all of the address space";
#endif
  const fs::path path = bake / "frames.fascicle";
  bake::CacheHeader header = bake::FrameCacheReader(path).header();
  header.vertex_count = 60'000'000;
  write_text(path, bake::encode_cache_header(header));
  fs::resize_file(path, bake::cache_header_bytes + bake::cache_record_bytes(header.vertex_count));
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_AS, &before), 0);
  const rlimit limit{std::uint64_t{600} << 20, before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_AS, &limit), 0);
  std::uint64_t frames = 1;
  EXPECT_NO_THROW(frames = bake::FrameCacheReader(path).frame_count());
  EXPECT_EQ(::setrlimit(RLIMIT_AS, &before), 0);
  EXPECT_EQ(frames, 0U);
}

// Meshes name their materials, and these their images. Names that no bake writes are not looked for.
TEST_F(Verify, FindsMaterialsAndImagesThatAreGone) {
  const auto refer = [&](const std::string& mesh, const std::string& to) {
    write_text(bake / mesh, "# a mesh\nmtllib " + to + "\n" + read_text(bake / mesh));
  };
  refer("rest.obj", "rest.mtl");
  EXPECT_EQ(finding_of(verified(), "rest.obj"), "wrong: lacks rest.mtl");
  write_text(bake / "rest.mtl", "newmtl skin\nmap_Kd textures/image_000.png\nmap_Kd ../../etc/passwd.png\n");
  EXPECT_EQ(finding_of(verified(), "rest.obj"), "wrong: lacks textures/image_000.png");
  fs::create_directory(bake / "textures");
  write_text(bake / "textures/image_000.png", "a picture");
  EXPECT_EQ(finding_of(verified(), "rest.obj"), "good: there");
  refer("obj/frame_000000.obj", "surface.mtl");
  EXPECT_EQ(finding_of(verified(), "obj/"), "wrong: lacks obj/surface.mtl");
  write_text(bake / "obj/surface.mtl", "newmtl skin\nmap_Kd ../textures/image_001.png\n");
  EXPECT_EQ(finding_of(verified(), "obj/"), "wrong: lacks textures/image_001.png");
  write_text(bake / "textures/image_001.png", "a picture");
  EXPECT_TRUE(verified().is_good());
}

// A killed bake leaves "running" behind, but not its lock.
TEST_F(Verify, TellsABakeThatWasKilledFromOneThatRuns) {
  bake::set_status(bake, bake::Status::running, "");
  EXPECT_EQ(verified().status, "running");
  EXPECT_FALSE(verified().in_use_here);
  const bake::FolderLock lock(bake);
  EXPECT_TRUE(verified().in_use_here);
}

TEST_F(Verify, FindsAFolderOfFramesThatIsGone) {
  bake::BakeOptions options = options_for(folder_ / "series");
  options.formats = {"obj"};
  fake_bake_into(options, short_scene(6));
  EXPECT_TRUE(verify_bake({.bake = options.folder}).is_good());
  fs::remove_all(folder_ / "series/obj");
  EXPECT_EQ(finding_of(verify_bake({.bake = options.folder}), "obj/"), "wrong: is missing");
}

// A valid frame with a valid checksum, but not the hash in the manifest.
TEST_F(Verify, FindsAFrameOfAnotherBake) {
  const fs::path path = bake / "frames.fascicle";
  std::string record;
  {
    const bake::FrameCacheReader cache(path);
    model::Frame frame = cache.read(2);
    frame.positions.front() += 1.0F;
    record = bake::encode_cache_record(cache.header(), frame);
  }
  std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
  file.seekp(static_cast<std::streamoff>(bake::cache_header_bytes + 2 * record.size()));
  file << record << std::flush;
  EXPECT_EQ(finding_of(verified(), "frames.fascicle"), "wrong: differs from the manifest: frame 2");
}

TEST_F(Verify, FindsWhatIsGone) {
  for (const char* name : {"frames.fascicle", "metrics.csv", "model.fascicle"}) {
    fs::rename(bake / name, folder_ / "away");
    EXPECT_EQ(finding_of(verified(), name), "wrong: is missing");
    fs::rename(folder_ / "away", bake / name);
  }
  std::ofstream(bake / "metrics.csv", std::ios::app) << "7\n";
  EXPECT_EQ(finding_of(verified(), "metrics.csv"), "wrong: has 8 rows instead of 7");
  fs::remove(bake / "manifest.json");
  EXPECT_TRUE(contains(message_of<bake::BakeError>([&] { verified(); }), "holds no bake"));
}

TEST(RangesText, IsShort) {
  EXPECT_EQ(bake::ranges_text({}), "");
  EXPECT_EQ(bake::ranges_text({5}), "5");
  EXPECT_EQ(bake::ranges_text({0, 1, 2, 7, 9, 10}), "0 to 2, 7, 9 to 10");
  std::vector<std::uint64_t> odd;
  for (std::uint64_t k = 0; k < 100; ++k) odd.push_back(2 * k + 1);
  EXPECT_EQ(bake::ranges_text(odd), "1, 3, 5, 7, 9, 11, 13, 15, 17, 19, 21, 23 and more");
}

}  // namespace
}  // namespace fascicle::tests
