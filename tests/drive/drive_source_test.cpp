#include "host/drive/drive_source.h"

#include <cmath>
#include <stdexcept>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "host/rig/pose.h"

namespace fascicle::tests::drive_source_test {
namespace {

using drive::DriveSource;
using Eigen::Matrix4d;
using Eigen::Vector3d;

constexpr double pi = 3.14159265358979323846;

// Two joints, the second a metre above the first. In two seconds the first moves 10 m along x and 1 m down,
// and the second turns by 90 degrees about z.
rig::Character walker() {
  rig::Character character;
  for (int j = 0; j < 2; ++j) {
    rig::Joint joint;
    joint.parent = j - 1;
    joint.rest_translation = Vector3d(0, j, 0);
    joint.rest_local(1, 3) = j;
    joint.inverse_bind(1, 3) = -j;
    joint.skins = true;
    character.skeleton.push_back(joint);
  }
  const double r = std::sqrt(0.5);
  using rig::ChannelPath, rig::Interpolation;
  character.clips.push_back(
      {"walk",
       2.0,
       {{0, ChannelPath::translation, Interpolation::linear, {0.0, 2.0}, {0, 0, 0, 10, -1, 0}},
        {1, ChannelPath::rotation, Interpolation::linear, {0.0, 2.0}, {0, 0, 0, 1, 0, 0, r, r}}}});
  return character;
}

struct Walk {
  scene::Scene scene;
  model::Model model;
};

// Only the parts of a model that a drive depends on.
Walk walking() {
  Walk s;
  s.scene.geometry = walker();
  s.scene.fps = 24.0;
  s.scene.start = 0.25;
  s.scene.end = 2.0;
  s.scene.solver.substeps = 4;
  s.model.unit = 0.5;
  s.model.rest_origin = {0.1, 0.75, -0.3};
  s.model.joint_count = 2;
  s.model.layers = {{"bone", 0.0, 1000.0, true}, {"fat", 6.0, 900.0, false}};
  return s;
}

Walk standing() {
  Walk s = walking();
  s.scene.geometry = scene::Bar{};
  s.model.joint_count = 0;
  return s;
}

Matrix4d matrix(const shader::Bone& b) {
  Matrix4d m;
  m << b.xx, b.xy, b.xz, b.xt, b.yx, b.yy, b.yz, b.yt, b.zx, b.zy, b.zz, b.zt, 0, 0, 0, 1;
  return m;
}

Vector3d vector(const std::array<double, 3>& a) {
  return {a[0], a[1], a[2]};
}

// Takes a rest position to a posed position, both in metres, as a solver does.
Vector3d through(const shader::Bone& bone, const Vector3d& p, const Walk& s,
                 const std::array<double, 3>& origin) {
  const Vector3d local = (p - vector(s.model.rest_origin)) / s.model.unit;
  return Vector3d((matrix(bone) * local.homogeneous()).head<3>()) * s.model.unit + vector(origin);
}

// Float rounding at a few working units.
constexpr double float_rounding = 2e-6;

TEST(DriveSource, bones_are_the_clip_at_the_ends_of_the_substeps) {
  const Walk s = walking();
  DriveSource source(s.scene, s.model);
  for (const std::uint64_t frame : {1u, 2u, 17u, 42u}) {
    const model::Drive drive = source.drive(frame);
    ASSERT_EQ(drive.bones.size(), 8u);
    EXPECT_EQ(drive.substeps, 4u);
    EXPECT_DOUBLE_EQ(drive.h, 1.0 / 96.0);
    for (std::uint64_t step = 1; step <= 4; ++step) {
      const double t = 0.25 + (static_cast<double>(frame - 1) + static_cast<double>(step) / 4.0) / 24.0;
      const Vector3d moved = Vector3d(10, -1, 0) * (t / 2.0);
      const Vector3d p(0.3, 1.9, -0.2);
      EXPECT_LT((through(drive.bones[2 * step - 2], p, s, drive.origin) - (p + moved)).norm(),
                float_rounding);
      const double angle = 0.5 * pi * t / 2.0;
      const Vector3d turned(0.3 * std::cos(angle) - 0.9 * std::sin(angle),
                            1.0 + 0.3 * std::sin(angle) + 0.9 * std::cos(angle), -0.2);
      EXPECT_LT((through(drive.bones[2 * step - 1], p, s, drive.origin) - (turned + moved)).norm(),
                float_rounding);
    }
  }
}

TEST(DriveSource, the_scenes_scale_holds_for_the_skeleton_too) {
  Walk s = walking();
  s.scene.scale = 0.01;
  s.model.unit = 1.0 / 64;
  DriveSource source(s.scene, s.model);
  const model::Drive drive = source.drive(42);  // it ends at 2 s
  const Vector3d p(0.003, 0.01, 0);             // m: 3 mm from the second joint
  EXPECT_LT((through(drive.bones[7], p, s, drive.origin) - Vector3d(0.1, 0.003, 0)).norm(), float_rounding);
}

TEST(DriveSource, origins_are_whole_units_near_the_root_and_shifts_are_exact) {
  const Walk s = walking();
  DriveSource source(s.scene, s.model);
  std::array<double, 3> last = source.initial_state().origin;
  bool moved = false;
  for (std::uint64_t frame = 1; frame <= 60; ++frame) {  // also past the end of the clip
    const model::Drive drive = source.drive(frame);
    const double t = std::min(2.0, 0.25 + static_cast<double>(frame) / 24.0);
    const Vector3d root = Vector3d(10, -1, 0) * (t / 2.0);
    for (std::size_t a = 0; a < 3; ++a) {
      const double units = drive.origin[a] / s.model.unit;
      EXPECT_EQ(units, std::floor(units));
      EXPECT_LE(std::abs(drive.origin[a] - root[static_cast<int>(a)]), 0.5 * s.model.unit + 1e-12);
      EXPECT_EQ(last[a] + static_cast<double>(drive.origin_shift[a]) * s.model.unit, drive.origin[a]);
      moved = moved || drive.origin_shift[a] != 0.0f;
    }
    last = drive.origin;
  }
  EXPECT_TRUE(moved);
}

TEST(DriveSource, the_origin_follows_a_root_that_skins) {
  Walk s = walking();
  auto& character = std::get<rig::Character>(s.scene.geometry);
  character.skeleton[0].skins = false;
  for (rig::Joint& joint : character.skeleton) joint.inverse_bind(1, 3) -= 20;
  character.root(1, 3) = 20;
  DriveSource source(s.scene, s.model);
  EXPECT_EQ(source.drive(42).origin, (std::array<double, 3>{10, 20, 0}));  // 20 + 1 - 1: the second joint
}

TEST(DriveSource, without_a_skeleton_the_origin_rests) {
  const Walk s = standing();
  DriveSource source(s.scene, s.model);
  EXPECT_EQ(source.initial_state().origin, s.model.rest_origin);
  for (const std::uint64_t frame : {1u, 100u}) {
    const model::Drive drive = source.drive(frame);
    EXPECT_EQ(drive.origin, s.model.rest_origin);
    EXPECT_EQ(drive.origin_shift, (std::array<float, 3>{0, 0, 0}));
    EXPECT_TRUE(drive.bones.empty());
  }
}

TEST(DriveSource, units_gravity_and_decay) {
  Walk s = standing();
  s.scene.gravity = {1, -9.81, 0.5};
  DriveSource source(s.scene, s.model);
  const model::Drive drive = source.drive(1);
  EXPECT_EQ(drive.gravity, (std::array<float, 3>{2.0f, -19.62f, 1.0f}));
  ASSERT_EQ(drive.decay.size(), 2u);
  EXPECT_EQ(drive.decay[0], 1.0f);
  // The nearest float, except for results within 1e-15 of a midpoint.
  EXPECT_FLOAT_EQ(drive.decay[1], static_cast<float>(std::exp(-6.0 / 96.0)));
}

TEST(DriveSource, forces_act_from_their_start_until_before_their_end) {
  Walk s = standing();
  s.scene.fps = 60.0;
  s.scene.start = 0.0;
  s.scene.forces = {{"gust", scene::ForceKind::wind, {0, 0, 8}, {}, 0.1, 0.2},
                    {"push", {}, {3, 0, 0}, {}, 0.0, 1e30}};
  s.model.force_count = 2;
  DriveSource source(s.scene, s.model);
  std::uint32_t acted = 0;
  for (std::uint64_t frame = 1; frame <= 30; ++frame) {
    const model::Drive drive = source.drive(frame);
    ASSERT_EQ(drive.forces.size(), 8u);
    for (std::size_t step = 0; step < 4; ++step) {
      // Frame 7 starts at 0.1 s, frame 13 at 0.2 s.
      const bool acts = frame >= 7 && frame <= 12;
      EXPECT_EQ(drive.forces[2 * step].z, acts ? 16.0f : 0.0f) << "frame " << frame << " substep " << step;
      EXPECT_EQ(drive.forces[2 * step + 1].x, 6.0f);
      acted += drive.forces[2 * step].z != 0.0f ? 1 : 0;
    }
  }
  EXPECT_EQ(acted, 24u);  // 0.1 s at 240 substeps per second
}

// Handles put frames before time 0. A force without a start acts there too, and while the flesh settles.
TEST(DriveSource, a_force_without_a_start_has_always_acted) {
  Walk s = standing();
  s.scene.start = -0.2;
  scene::Force wind;
  wind.name = "wind";
  wind.vector = {3, 0, 0};
  s.scene.forces = {wind};
  s.model.force_count = 1;
  DriveSource source(s.scene, s.model);
  EXPECT_EQ(source.drive(1).forces[0].x, 6.0f);
  EXPECT_EQ(source.settle_drive().forces[0].x, 6.0f);
}

TEST(DriveSource, a_force_may_begin_inside_a_frame) {
  Walk s = standing();
  s.scene.start = 1.0;
  s.scene.forces = {{"push", {}, {0.5, 0, 0}, {}, 1.0 + 6.0 / 96.0, 1e30}};
  s.model.force_count = 1;
  DriveSource source(s.scene, s.model);
  EXPECT_EQ(source.drive(1).forces[3].x, 0.0f);
  const model::Drive second = source.drive(2);  // the third substep starts there
  EXPECT_EQ(second.forces[1].x, 0.0f);
  EXPECT_EQ(second.forces[2].x, 1.0f);
}

bool same(const std::vector<shader::Bone>& a, std::span<const shader::Bone> b) {
  if (a.size() != b.size()) return false;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (matrix(a[i]) != matrix(b[i])) return false;
  }
  return true;
}

TEST(DriveSource, frames_come_in_any_order) {
  const Walk s = walking();
  DriveSource forward(s.scene, s.model), backward(s.scene, s.model);
  struct Kept {
    std::array<double, 3> origin;
    std::array<float, 3> shift;
    std::vector<shader::Bone> bones;
  };
  std::vector<Kept> kept;
  for (std::uint64_t frame = 1; frame <= 42; ++frame) {
    const model::Drive d = forward.drive(frame);
    kept.push_back({d.origin, d.origin_shift, {d.bones.begin(), d.bones.end()}});
  }
  for (std::uint64_t frame = 42; frame >= 1; --frame) {
    const model::Drive d = backward.drive(frame);
    EXPECT_EQ(d.origin, kept[frame - 1].origin);
    EXPECT_EQ(d.origin_shift, kept[frame - 1].shift);
    EXPECT_TRUE(same(kept[frame - 1].bones, d.bones)) << frame;
    backward.initial_state();
    EXPECT_TRUE(same(kept[frame - 1].bones, d.bones))
        << "initial_state() must not invalidate a drive's spans";
  }
}

TEST(DriveSource, the_initial_state_is_the_pose_at_start) {
  Walk s = walking();
  s.model.vertex_count = 2;
  s.model.rest = {0.0f, 0.5f, 0.0f, 1.0f, 2.5f, 0.0f};
  s.model.tag = {0, 0};
  s.model.skin_offset = {0, 1, 2};
  s.model.skin_joint = {0, 1};
  s.model.skin_weight = {1.0f, 1.0f};
  const model::State state = DriveSource(s.scene, s.model).initial_state();
  const rig::Character& character = std::get<rig::Character>(s.scene.geometry);
  const std::vector<Matrix4d> pose = rig::pose_at(character, &character.clips[0], s.scene.start);
  ASSERT_EQ(state.positions.size(), 6u);
  for (int i = 0; i < 2; ++i) {
    const auto at = static_cast<std::size_t>(3 * i);
    const Vector3d rest =
        Vector3d(s.model.rest[at], s.model.rest[at + 1], s.model.rest[at + 2]) * s.model.unit +
        vector(s.model.rest_origin);
    const Vector3d expected = (pose[static_cast<std::size_t>(i)] * rest.homogeneous()).head<3>();
    const Vector3d got =
        Vector3d(state.positions[at], state.positions[at + 1], state.positions[at + 2]) * s.model.unit +
        vector(state.origin);
    EXPECT_LT((got - expected).norm(), float_rounding);
  }
}

TEST(DriveSource, refuses_models_of_other_scenes_and_frame_zero) {
  Walk s = walking();
  s.model.joint_count = 3;
  EXPECT_THROW(DriveSource(s.scene, s.model), std::invalid_argument);
  s = standing();
  s.model.force_count = 1;
  EXPECT_THROW(DriveSource(s.scene, s.model), std::invalid_argument);
  s = walking();
  s.scene.clip = "run";
  EXPECT_THROW(DriveSource(s.scene, s.model), scene::SceneError);
  s = walking();
  EXPECT_THROW(DriveSource(s.scene, s.model).drive(0), std::invalid_argument);
}

}  // namespace
}  // namespace fascicle::tests::drive_source_test
