// The workshop's cache of bodies: a body that was built before needs no mesher, and the cache is limited.
#include "host/studio/workshop.h"

#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include "host/bake/identity.h"
#include "host/studio/running_body.h"

namespace fascicle::tests {
namespace {

namespace fs = std::filesystem;
using studio::Workshop;

class WorkshopTest : public testing::Test {
 protected:
  void SetUp() override {
    const testing::TestInfo* info = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::temp_directory_path() / ("fascicle-workshop-" + std::string(info->name()));
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    fs::copy_file(fs::path(FASCICLE_BINARY_DIR) / "fascicle-mesher", mesher());
    options_.mesher = mesher();
    options_.is_cancelled = [this] { return cancels_; };
    workshop_.emplace(studio::TextSource{"arm", "arm.toml", folder_}, options_, device_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path mesher() const { return folder_ / "fascicle-mesher"; }
  static std::string text(const std::string& resolution, const std::string& more = "") {
    return "[scene]\nend = 0.1\n[character]\nmade = \"arm\"\nresolution = " + resolution + "\n" + more;
  }
  std::uint64_t hash_of(const std::string& scene_text) {
    return bake::model_hash(workshop_->make(scene_text, {}, ++revision_, {})->model());
  }

  fs::path folder_;
  build::BuildOptions options_;  // no disk cache
  const pipeline::ChosenDevice device_ =
      pipeline::ChosenDevice::cpu(2, cpu_reference::Simd::automatic, "a test");
  std::optional<Workshop> workshop_;
  std::uint32_t revision_ = 0;
  bool cancels_ = false;
};

TEST_F(WorkshopTest, ABodyThatComesAgainIsThere) {
  const std::uint64_t coarse = hash_of(text("0.05"));
  workshop_->warm();
  const std::uint64_t soft = hash_of(text("0.05", "[flesh]\nsoftness = 2.0\n"));
  const std::uint64_t fine = hash_of(text("0.04"));
  fs::remove(mesher());
  EXPECT_EQ(hash_of(text("0.05", "[flesh]\nsoftness = 2.0\n")), soft);
  EXPECT_EQ(hash_of(text("0.05")), coarse);
  EXPECT_EQ(hash_of(text("0.04")), fine);
  EXPECT_THROW(hash_of(text("0.06")), std::exception) << "the control: this one was never built";
  EXPECT_EQ(hash_of(text("0.05")), coarse) << "what failed takes nothing away";
  EXPECT_NE(soft, coarse);
  EXPECT_NE(fine, coarse);
}

// Dragging a slider cancels one build after another.
TEST_F(WorkshopTest, BuildsThatComeToNothingTakeNoPlace) {
  const std::uint64_t first = hash_of(text("0.05"));
  workshop_->warm();
  const auto of_number = [&](std::size_t k) { return text("0.0" + std::to_string(60 + k)); };
  cancels_ = true;
  for (std::size_t k = 0; k < Workshop::most_bodies; ++k)
    EXPECT_THROW(hash_of(of_number(k)), build::Cancelled);
  cancels_ = false;
  fs::remove(mesher());
  for (std::size_t k = 0; k < Workshop::most_bodies; ++k) EXPECT_THROW(hash_of(of_number(k)), std::exception);
  EXPECT_EQ(hash_of(text("0.05")), first);
}

// The least recently used body is evicted.
TEST_F(WorkshopTest, TheOldestBodyGoes) {
  const auto of_number = [&](std::size_t k) { return text("0.0" + std::to_string(60 + k)); };
  hash_of(of_number(0));
  workshop_->warm();
  for (std::size_t k = 1; k < Workshop::most_bodies; ++k) hash_of(of_number(k));
  hash_of(of_number(0));
  hash_of(of_number(Workshop::most_bodies));
  fs::remove(mesher());
  EXPECT_NO_THROW(hash_of(of_number(0)));
  EXPECT_NO_THROW(hash_of(of_number(Workshop::most_bodies)));
  EXPECT_THROW(hash_of(of_number(1)), std::exception);
}

}  // namespace
}  // namespace fascicle::tests
