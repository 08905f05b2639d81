// A forearm whose hand rotates: with a muscle's `twist`, its flesh winds around the bone from elbow to wrist
// and keeps its volume. Without it the flesh sticks to the bone, and all of the rotation is at the wrist.
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "cpu_reference/solver/cpu_solver.h"
#include "host/build/build.h"
#include "host/drive/drive_source.h"
#include "host/scene/scene.h"

namespace fascicle::tests {

namespace {

using Eigen::Vector3d;

// The built-in arm: its forearm is along x.
constexpr double elbow = 0.30, wrist = 0.56;  // m
constexpr std::uint32_t forearm_joint = 2, hand_joint = 3;
constexpr double hand_turn = M_PI / 2.0;
// At damping 6 1/s a swing decays to e^-6 in this time.
constexpr int frames_to_stillness = 60;

// The straight arm with its hand rotated about the forearm, held until the flesh is at rest.
struct TwistedArm {
  model::Model model;
  std::vector<Vector3d> rest, held;  // m, the model's vertices

  explicit TwistedArm(double twist, double turn = hand_turn) {
    // A thin bone: the flesh next to it does not rotate. Stiff flesh without a volume term: only T_r keeps
    // the volume.
    scene::Scene scene = scene::load_scene(
        "arm", {.set = {"layers.fat.volume=0", "layers.muscle.volume=0", "layers.fat.alpha=0.3",
                        "layers.muscle.alpha=1", "layers.muscle.where={bone_distance={maximum=0.045}}",
                        "layers.bone.where={bone_distance={maximum=0.006}}"}});
    scene.muscles = {{.name = "wound", .bone = "forearm", .gain = 0.0, .twist = twist}};
    auto& character = std::get<rig::Character>(scene.geometry);
    rig::Clip still{.name = "turned", .duration = 1.0, .channels = {}};
    const double sine = std::sin(turn / 2.0), cosine = std::cos(turn / 2.0);
    still.channels.push_back({hand_joint,
                              rig::ChannelPath::rotation,
                              rig::Interpolation::linear,
                              {0.0, 1.0},
                              {sine, 0.0, 0.0, cosine, sine, 0.0, 0.0, cosine}});
    character.clips = {still};
    scene.clip = "turned";
    scene.end = 1.0;

    build::Report report;
    build::BuildOptions options;
    options.mesher = FASCICLE_MESHER;
    model = build::build_model(scene, report, options);
    drive::DriveSource drives(scene, model);
    const auto solver = cpu_reference::make_cpu_solver(model, {}, 2);
    solver->load(drives.initial_state());
    model::Frame frame;
    for (int k = 0; k < frames_to_stillness; ++k) {
      solver->submit(drives.settle_drive(), {.positions = true});
      frame = solver->collect();
    }
    const auto metres = [&](const std::vector<float>& values, const std::array<double, 3>& origin) {
      std::vector<Vector3d> places;
      for (std::size_t i = 0; i < model.vertex_count; ++i)
        places.emplace_back(origin[0] + model.unit * double{values[3 * i]},
                            origin[1] + model.unit * double{values[3 * i + 1]},
                            origin[2] + model.unit * double{values[3 * i + 2]});
      return places;
    };
    rest = metres(model.rest, model.rest_origin);
    held = metres(frame.positions, frame.origin);
  }

  double along(std::size_t i) const { return (rest[i].x() - elbow) / (wrist - elbow); }

  // The mean rotation about the bone of flesh at least 2 cm from the axis, between two places along it (0 at
  // the elbow, 1 at the wrist), radians.
  double turn_between(double from, double to) const {
    double sine = 0.0, cosine = 0.0;
    for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
      if (model.is_kinematic(i) || along(i) < from || along(i) > to ||
          std::hypot(rest[i].y(), rest[i].z()) < 0.02)
        continue;
      sine += rest[i].y() * held[i].z() - rest[i].z() * held[i].y();
      cosine += rest[i].y() * held[i].y() + rest[i].z() * held[i].z();
    }
    return std::atan2(sine, cosine);
  }

  // The volume of tetrahedra along the forearm, relative to rest.
  double volume_ratio() const {
    double now = 0.0, before = 0.0;
    const auto volume = [&](const std::vector<Vector3d>& at, const std::uint32_t* v) {
      return (at[v[1]] - at[v[0]]).cross(at[v[2]] - at[v[0]]).dot(at[v[3]] - at[v[0]]);
    };
    for (std::size_t t = 0; t < model.tetrahedron.size(); t += 4) {
      const std::uint32_t* v = &model.tetrahedron[t];
      const double middle = (along(v[0]) + along(v[1]) + along(v[2]) + along(v[3])) / 4.0;
      if (middle < 0.15 || middle > 0.75) continue;
      now += volume(held, v);
      before += volume(rest, v);
    }
    return now / before;
  }
};

// The rotation from 1/5 to 4/5 of the way, relative to that share of the hand's: 1 is as uniform as the
// requested shear.
double winding(const TwistedArm& arm) {
  return (arm.turn_between(0.7, 0.9) - arm.turn_between(0.1, 0.3)) / (0.6 * hand_turn);
}

TEST(Twist, CarriesTheFleshAroundTheBoneAndKeepsItsVolume) {
  const TwistedArm wound(1.0), half(0.5), plain(0.0);
  double before = -M_PI;
  for (const double from : {0.1, 0.3, 0.5, 0.7}) {
    const double turn = wound.turn_between(from, from + 0.2);
    EXPECT_GT(turn, before) << from;
    before = turn;
  }
  RecordProperty("winding with twist 1, 1/2, 0", std::to_string(winding(wound)) + " " +
                                                     std::to_string(winding(half)) + " " +
                                                     std::to_string(winding(plain)));
  // Measured 0.80, 0.46 and 0.12. It does not reach 1 because flesh next to the bone is attached to it, and
  // the bone does not rotate; the tolerance of a quarter allows for another mesh.
  EXPECT_NEAR(winding(wound), 0.8, 0.2);
  EXPECT_LT(winding(half), winding(wound) - 0.2);
  EXPECT_GT(winding(half), winding(plain) + 0.2);
  // The control: a rotated hand alone does not wind the flesh.
  EXPECT_LT(winding(plain), 0.25);

  RecordProperty("volume with and without",
                 std::to_string(wound.volume_ratio()) + " " + std::to_string(plain.volume_ratio()));
  // det T_r = 1 and no volume term: measured 0.6 % more. Lines along the skin, 3.5 cm from the axis, are 1.4
  // % longer after this winding: a limb that kept their length would be shorter by that.
  EXPECT_NEAR(wound.volume_ratio(), 1.0, 0.01);
}

// A twisting muscle does nothing if nothing rotates.
TEST(Twist, NeedsATurn) {
  const TwistedArm unturned(1.0, 0.0);
  // Positions are floats of a body 0.7 m long: 1e-7 of that at a radius of 3 cm.
  EXPECT_NEAR(unturned.turn_between(0.1, 0.9), 0.0, 1e-5);
}

}  // namespace

}  // namespace fascicle::tests
