// The hand that pulls flesh: what it holds, that it does not change the model otherwise, and that flesh
// follows it.
#include "host/studio/hand.h"

#include <filesystem>
#include <memory>

#include <gtest/gtest.h>

#include "host/model/validate.h"
#include "host/studio/live_motion.h"
#include "host/studio/workshop.h"

namespace fascicle::tests {
namespace {

using studio::Held;
using studio::LiveMotion;
using studio::RunningBody;
using studio::Vector3d;

// A bar held at one end, without gravity; its stiffness in Hz.
std::string bar(const std::string& frequency) {
  return "[scene]\nfps = 60\nend = 1.0\ngravity = [0, 0, 0]\n[bar]\nsize = [0.4, 0.1, 0.1]\nvertices = [13, "
         "4, 4]\n"
         "[layers.body]\nfrequency = " +
         frequency +
         "\ndamping = 6.0\n"
         "[pin.wall]\nwhere = { below = { axis = \"x\", fraction = 0.0 } }\n";
}

class HandTest : public testing::Test {
 protected:
  std::shared_ptr<RunningBody> body_of(const std::string& text) {
    build::BuildOptions options;
    options.mesher = std::filesystem::path(FASCICLE_BINARY_DIR) / "fascicle-mesher";
    return studio::Workshop({"bar", "bar.toml", {}}, options, device_).make(text, {}, 1, {});
  }
  static std::uint32_t farthest_along_x(const model::Model& model) {
    std::uint32_t best = 0;
    for (std::uint32_t i = 0; i < model.vertex_count; ++i)
      if (model.rest[3 * i] > model.rest[3 * best]) best = i;
    return best;
  }
  static Vector3d place(const LiveMotion& motion, const studio::ShownFrame& shown, std::uint32_t i) {
    (void)motion;
    const float* p = &shown.frame->positions[3 * std::size_t{i}];
    return Vector3d(shown.frame->origin[0], shown.frame->origin[1], shown.frame->origin[2]) +
           shown.model->unit * Vector3d(double{p[0]}, double{p[1]}, double{p[2]});
  }
  pipeline::ChosenDevice device_ = pipeline::ChosenDevice::cpu(1, cpu_reference::Simd::automatic, "a test");
};

TEST_F(HandTest, HoldsFreeVerticesNearAndFallsOff) {
  const auto body = body_of(bar("4.0"));
  const model::Model& model = body->model();
  const std::uint32_t tip = farthest_along_x(model);
  const Held held = studio::held_around(model, tip, 0.08);
  ASSERT_FALSE(held.empty());
  for (const auto& [i, share] : held) {
    EXPECT_FALSE(model.is_kinematic(i));
    EXPECT_GT(share, 0.0f);
    EXPECT_LE(share, i == tip ? 1.0f : 0.9999f);
  }
  EXPECT_TRUE(std::is_sorted(held.begin(), held.end()));
  const model::Model with = studio::with_hand(model, held);
  model::check_model(with);
  EXPECT_EQ(with.force_count, model.force_count + 1);
  EXPECT_EQ(with.force_index.size(), held.size());
}

// With zero force, the bits are those of the model without a hand.
TEST_F(HandTest, AHandThatDoesNotPullChangesNoBit) {
  LiveMotion with(body_of(bar("4.0"))), without(body_of(bar("4.0")));
  const std::uint32_t tip = farthest_along_x(with.body().model());
  for (int k = 0; k < 5; ++k) with.advance(), without.advance();
  ASSERT_GT(with.grab(tip, 0.0, Vector3d::Zero()), 0u);
  for (int k = 0; k < 20; ++k)
    ASSERT_EQ(with.advance().numbers.position_hash, without.advance().numbers.position_hash) << k;
  with.release();
  for (int k = 0; k < 5; ++k)
    ASSERT_EQ(with.advance().numbers.position_hash, without.advance().numbers.position_hash) << k;
}

// From soft, like a belly, to stiff, like a man's muscle: within 1.5 s the flesh is pulled to the target,
// within a quarter of the distance, and after release it returns.
TEST_F(HandTest, FleshFollowsAndComesBack) {
  for (const char* frequency : {"2.0", "8.0", "30.0"}) {
    LiveMotion motion(body_of(bar(frequency)));
    const std::uint32_t tip = farthest_along_x(motion.body().model());
    const Vector3d start = place(motion, motion.again(), tip);
    motion.grab(tip, 0.08, start);
    const Vector3d way(0.0, 0.05, 0.0);
    studio::ShownFrame shown = motion.again();
    double furthest = 0.0;
    for (int k = 0; k < 90; ++k) {
      // Like a mouse: moves for a third of a second, then stays.
      motion.hand()->move(start + std::min(1.0, k / 20.0) * way);
      shown = motion.advance();
      furthest = std::max(furthest, place(motion, shown, tip)[1] - start[1]);
    }
    // The centre of the held region reaches the target; the tip, further out, moves a little more.
    EXPECT_NEAR(place(motion, shown, tip)[1] - start[1], way[1], 0.25 * way[1]) << frequency;
    EXPECT_LT(furthest, 2.0 * way[1]) << frequency;
    motion.release();
    for (int k = 0; k < 180; ++k) shown = motion.advance();
    EXPECT_NEAR(place(motion, shown, tip)[1], start[1], 0.05 * way[1]) << frequency;
  }
}

}  // namespace
}  // namespace fascicle::tests
