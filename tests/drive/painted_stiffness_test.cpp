// Painted stiffness on flesh with physical units, compared with stated moduli and with rod theory.
#include <algorithm>
#include <cmath>
#include <optional>

#include <gtest/gtest.h>

#include "cpu_reference/solver/cpu_solver.h"
#include "host/bake/identity.h"
#include "host/build/build.h"
#include "host/drive/drive_source.h"
#include "host/made/made_character.h"
#include "host/scene/scene.h"

namespace fascicle::tests::painted_stiffness_test {
namespace {

using Eigen::Vector3d;

build::BuildOptions with_mesher() {
  build::BuildOptions options;
  options.mesher = FASCICLE_MESHER;
  return options;
}

model::Model built(const scene::Scene& scene) {
  build::Report report;
  return build::build_model(scene, report, with_mesher());
}

void paint(rig::Character& character, double (*stiffness_at)(const Vector3d&)) {
  rig::PaintedAttribute painted{"_STIFFNESS", 1, {}};
  for (const Vector3d& p : character.surface.vertices) painted.values.push_back(stiffness_at(p));
  character.painted = {painted};
}

// Fat on muscle on bone, with stiffness given as a modulus and as a frequency.
scene::Scene arm_scene(double modulus, double (*stiffness_at)(const Vector3d&)) {
  scene::Scene scene;
  scene.source = "test";
  rig::Character arm = made::make_character("arm");
  if (stiffness_at != nullptr) paint(arm, stiffness_at);
  scene.geometry = arm;
  scene.resolution = 0.04;
  scene.solver.integrator = scene::Integrator::implicit_step;
  scene::Layer fat, muscle, bone;
  fat.name = "fat";
  fat.youngs_modulus = modulus;
  muscle.name = "muscle";
  muscle.frequency = 5.0;
  muscle.where = {scene::BoneDistance{0.0, 0.04, {}}};
  bone.name = "bone";
  bone.kinematic = true;
  bone.where = {scene::BoneDistance{0.0, 0.02, {}}};
  if (stiffness_at != nullptr) fat.alpha_attribute = muscle.alpha_attribute = "_STIFFNESS";
  scene.layers = {fat, muscle, bone};
  return scene;
}

// Factors that are powers of two are exact.
TEST(PaintedStiffness, IsAFactorOnTheLayersModulus) {
  const model::Model plain = built(arm_scene(4e3, nullptr));
  const model::Model one = built(arm_scene(4e3, [](const Vector3d&) { return 1.0; }));
  // Barycentric weights on the skin add up to 1 only up to rounding.
  for (std::uint32_t i = 0; i < plain.vertex_count; ++i)
    EXPECT_NEAR(one.stiffness[i], plain.stiffness[i], 1e-12 * plain.stiffness[i])
        << "a factor of 1 changes nothing";
  for (const double factor : {4.0, 0.5}) {
    const model::Model painted = built(arm_scene(
        4e3, factor == 4.0 ? [](const Vector3d&) { return 4.0; } : [](const Vector3d&) { return 0.5; }));
    scene::Scene stated = arm_scene(factor * 4e3, nullptr);
    stated.layers[1].frequency = std::sqrt(factor) * 5.0;
    const model::Model other = built(stated);
    ASSERT_EQ(painted.vertex_count, other.vertex_count);
    for (std::uint32_t i = 0; i < painted.vertex_count; ++i)
      // Here the modulus of a frequency is the square of a square root.
      EXPECT_NEAR(painted.stiffness[i], other.stiffness[i], 1e-12 * other.stiffness[i]) << i;
    EXPECT_NE(bake::model_hash(painted), bake::model_hash(plain)) << "the control";
  }
}

// Flesh painted with zero or with a huge value can still be built.
TEST(PaintedStiffness, HasBounds) {
  const model::Model plain = built(arm_scene(4e3, nullptr));
  const model::Model least = built(arm_scene(4e3, [](const Vector3d&) { return 0.0; }));
  const model::Model most = built(arm_scene(4e3, [](const Vector3d&) { return 1e6; }));
  for (std::uint32_t r = 0; r < plain.vertex_count; ++r) {
    EXPECT_NEAR(least.youngs_modulus[r], 0.01 * plain.youngs_modulus[r], 1e-9 * plain.youngs_modulus[r]);
    EXPECT_NEAR(most.youngs_modulus[r], 10.0 * plain.youngs_modulus[r], 1e-9 * plain.youngs_modulus[r]);
  }
}

constexpr double length = 0.8, width = 0.1, held = 0.08;  // m

// A rod up from y = 0, on one still joint.
rig::Character rod() {
  constexpr std::uint32_t around = 16, up = 32;
  rig::Character rod;
  rig::Joint joint;
  joint.name = "wall";
  joint.skins = true;
  rod.skeleton = {joint};
  auto& vertices = rod.surface.vertices;
  // Evenly spaced along the square's edge.
  const auto place = [](std::uint32_t a, double y) {
    const std::uint32_t side = a / 4;
    const double along = width * (a % 4) / 4.0 - width / 2.0;
    const double h = width / 2.0;
    return side == 0   ? Vector3d(along, y, h)
           : side == 1 ? Vector3d(h, y, -along)
           : side == 2 ? Vector3d(-along, y, -h)
                       : Vector3d(-h, y, along);
  };
  for (std::uint32_t k = 0; k <= up; ++k)
    for (std::uint32_t a = 0; a < around; ++a) vertices.push_back(place(a, length * k / up));
  const auto bottom = static_cast<std::uint32_t>(vertices.size());
  vertices.emplace_back(0.0, 0.0, 0.0);
  vertices.emplace_back(0.0, length, 0.0);
  const auto at = [](std::uint32_t k, std::uint32_t a) { return k * around + a % around; };
  for (std::uint32_t a = 0; a < around; ++a) {
    for (std::uint32_t k = 0; k < up; ++k) {
      rod.surface.triangles.push_back({at(k, a), at(k, a + 1), at(k + 1, a)});
      rod.surface.triangles.push_back({at(k, a + 1), at(k + 1, a + 1), at(k + 1, a)});
    }
    rod.surface.triangles.push_back({bottom, at(0, a + 1), at(0, a)});
    rod.surface.triangles.push_back({bottom + 1, at(up, a), at(up, a + 1)});
  }
  rod.joints.resize(vertices.size());
  rod.weights.resize(vertices.size(), {1.0});
  return rod;
}

// The displacement of the rod's free end at rest under a force.
double sag(double (*stiffness_at)(const Vector3d&)) {
  scene::Scene scene;
  scene.source = "test";
  rig::Character character = rod();
  paint(character, stiffness_at);
  scene.geometry = character;
  scene.resolution = 0.04;
  scene.gravity = Vector3d::Zero();
  scene.solver.integrator = scene::Integrator::implicit_step;
  scene.solver.substeps = 4;
  scene.end = 3.0;
  scene.skeleton.simulated = {"wall"};
  scene::Layer flesh, wall;
  flesh.name = "flesh";
  flesh.youngs_modulus = 5e4;
  flesh.damping = 15.0;
  flesh.alpha_attribute = "_STIFFNESS";
  wall.name = "wall";
  wall.kinematic = true;
  wall.where = {scene::HalfSpace{scene::Axis::y, false, false, length - held}};
  scene.layers = {flesh, wall};
  scene.forces = {{.name = "weight",
                   .kind = scene::ForceKind::point,
                   .vector = Vector3d(0.0, -10.0, 0.0),
                   .where = {scene::HalfSpace{scene::Axis::y, true, false, 0.01}}}};
  const model::Model model = built(scene);
  drive::DriveSource drives(scene, model);
  const auto solver = cpu_reference::make_cpu_solver(
      model, {.integrator = scene::Integrator::implicit_step, .iterations = 30}, 2);
  solver->load(drives.initial_state());
  model::Frame frame;
  for (std::uint64_t k = 1; k <= scene::frame_count(scene); ++k) {
    solver->submit(drives.drive(k), {.positions = true});
    frame = solver->collect();
  }
  double sum = 0.0;
  int count = 0;
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    const double rest = model.rest_origin[1] + model.unit * double{model.rest[3 * i + 1]};
    if (rest > 0.005) continue;
    sum += rest - (frame.origin[1] + model.unit * double{frame.positions[3 * i + 1]});
    ++count;
  }
  EXPECT_GT(count, 4);
  return sum / count;
}

// A force F at the end of a rod of section A stretches it by F/A times the integral of dx/E. If its upper
// half is four times as stiff, that is 1/8 + 1/2 of the even rod's stretch.
TEST(PaintedStiffness, ARodHalfOfWhichIsStifferStretchesByTheClosedForm) {
  constexpr double middle = (length - held) / 2.0;
  const double even = sag([](const Vector3d&) { return 1.0; });
  const double half = sag([](const Vector3d& p) { return p[1] > middle ? 4.0 : 1.0; });
  const double all = sag([](const Vector3d&) { return 4.0; });
  // F L / (A E). The mesh has three edges across, and both ends are held or pulled over half an edge of 18,
  // so it is stiffer by about 15 %, which cancels in the ratios.
  EXPECT_NEAR(even, 10.0 * (length - held) / (width * width * 5e4), 0.2 * even);
  EXPECT_NEAR(all / even, 0.25, 0.01) << "linear except for the change of section: 1.4 % of stretch";
  // The edge of the paint is within an edge of the middle: 1/18 of the free length, on which the ratio
  // depends with a slope of 3/4.
  EXPECT_NEAR(half / even, 0.625, 0.04);
  EXPECT_GT(std::abs(half / even - 1.0), 0.2) << "the control: paint acts";
}

}  // namespace
}  // namespace fascicle::tests::painted_stiffness_test
