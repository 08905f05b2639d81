// Properties of random bodies and parameters (rapidcheck): what is built and stepped stays finite, or is
// refused with a message that names the cause; and stepping gives the same bits on Vulkan.
// 50 cases each; RC_PARAMS="max_success=10000" makes it a soak test.
#include <bit>
#include <cmath>
#include <cstdlib>
#include <iostream>
#include <map>
#include <memory>
#include <regex>
#include <string>

#include <Eigen/Geometry>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include "cpu_reference/solver/cpu_solver.h"
#include "gpu/device.h"
#include "gpu/vulkan_solver.h"
#include "host/build/build.h"
#include "host/drive/drive_source.h"
#include "host/model/model.h"
#include "host/scene/scene.h"
#include "tests/gpu/vulkan_device.h"

namespace fascicle::tests {

namespace {

using Eigen::Vector3d;
using scene::Scene;

double number_in(double low, double high) {
  return low + (high - low) * (*rc::gen::inRange<int>(0, 1000001)) / 1e6;
}

// Small, large and edge values.
double fraction() {
  return *rc::gen::element(0.0, 1e-6, 0.3, 0.5, 0.999, 1.0, number_in(0.0, 1.0));
}

Vector3d direction() {
  return {number_in(-1, 1), number_in(-1, 1), number_in(-1, 1)};
}

Scene random_scene(scene::Geometry geometry) {
  Scene scene;
  scene.name = scene.source = "random";
  scene.geometry = std::move(geometry);
  scene.scale = *rc::gen::element(1.0, 1e-3, 1e3);
  const int layers = *rc::gen::inRange(1, 4);
  for (int k = 0; k < layers; ++k) {
    scene::Layer layer;
    layer.name = "layer" + std::to_string(k);
    layer.alpha = fraction();
    layer.beta = fraction();
    layer.damping = *rc::gen::element(0.0, 1.0, 13.4, 1e4);
    layer.density = *rc::gen::element(1.0, 1000.0, 2e4);
    layer.volume = fraction();
    if (const Vector3d d = direction(); d.norm() > 0.1 && *rc::gen::arbitrary<bool>())
      layer.fibre = d.normalized();
    layer.kinematic = *rc::gen::inRange(0, 6) == 0;
    layer.sliding = !layer.kinematic && *rc::gen::inRange(0, 4) == 0;
    if (k > 0)
      layer.where = {scene::HalfSpace{.axis = static_cast<scene::Axis>(*rc::gen::inRange(0, 3)),
                                      .below = *rc::gen::arbitrary<bool>(),
                                      .is_fraction = true,
                                      .value = number_in(0.0, 1.0)}};
    scene.layers.push_back(layer);
  }
  if (*rc::gen::arbitrary<bool>())
    scene.pins.push_back(
        {"pin",
         {scene::HalfSpace{.axis = scene::Axis::y, .below = true, .is_fraction = true, .value = 0.1}}});
  if (*rc::gen::arbitrary<bool>()) {
    scene::Force& wind = scene.forces.emplace_back();
    wind.name = "wind";
    wind.kind = scene::ForceKind::wind;
    wind.vector = direction() * number_in(0.0, 1e3);
  }
  scene.gravity = direction() * *rc::gen::element(0.0, 9.81, 1e3);
  scene.solver.rotation = *rc::gen::element(scene::Rotation::qcp, scene::Rotation::mueller2016);
  scene.solver.weights = *rc::gen::element(scene::WeightForm::symmetric, scene::WeightForm::kaneda2017);
  scene.solver.substeps = *rc::gen::element(1u, 2u, 8u);
  scene.fps = *rc::gen::element(1.0, 24.0, 60.0, 480.0);
  scene.end = 1.0;
  return scene;
}

// A refusal starts with the scene's source and then names what to change: vertices or tetrahedra by number,
// or a key of the scene file.
bool names_what_is_wrong(const std::string& message) {
  static const std::regex named(
      R"(random: (?:.*\b(?:vertex|vertices|tetrahedron) \(?\d|(?:layers|pins|probe|force)\.\w+(?:\.\w+)?: )"
      R"(|layers: no layer covers |bar: (?:size|vertices|jitter): |mesh: there are no t|mesh: .*set `scale`))");
  return std::regex_search(message, named, std::regex_constants::match_continuous);
}

TEST(Refusals, NameWhatIsWrong) {
  EXPECT_TRUE(names_what_is_wrong("random: mesh: no volume in tetrahedron 3 and 4 more (counted from 0)"));
  EXPECT_TRUE(names_what_is_wrong("random: layers.bone: this kinematic layer holds no vertex"));
  EXPECT_FALSE(names_what_is_wrong("random: the mesh is bad"));
  EXPECT_FALSE(names_what_is_wrong("mesh: no volume in tetrahedron 3"));
  EXPECT_FALSE(names_what_is_wrong("random: vector::_M_range_check"));
}

bool same_bits(const std::vector<float>& a, const std::vector<float>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](float x, float y) {
    return std::bit_cast<std::uint32_t>(x) == std::bit_cast<std::uint32_t>(y);
  });
}

class Properties : public testing::Test {
 protected:
  // One device for all cases: opening it takes longer than a case.
  static void SetUpTestSuite() {
    ::setenv("RC_PARAMS", "max_success=50", 0);
    std::string why;
    if (const auto index = usable_device(why))
      device_ = std::make_unique<gpu::Device>(*index);
    else if (vulkan_is_required())
      ADD_FAILURE() << "FASCICLE_REQUIRE_VULKAN=1, and there is no usable device: " << why;
    else
      std::cerr << "NO VULKAN DEVICE, random bodies are NOT compared with it: " << why << '\n';
  }
  static void TearDownTestSuite() { device_.reset(); }

  void SetUp() override { built_ = refused_ = compared_ = 0; }
  void TearDown() override {
    RecordProperty("built", built_);
    RecordProperty("refused", refused_);
    RecordProperty("compared_with_vulkan", compared_);
    // A quarter of the built bodies are compared; with 40 of them, the chance of no comparison is 1e-5.
    if (device_ && built_ >= 40) {
      EXPECT_GT(compared_, 0);
    }
  }

  // Builds and steps a scene. Fails the property unless all numbers are finite or the refusal names the
  // cause.
  void check(const Scene& scene, const build::BuildOptions& options = {}) {
    build::Report report;
    model::Model model;
    try {
      model = build::build_model(scene, report, options);
    } catch (const scene::SceneError& error) {
      if (!names_what_is_wrong(error.what())) RC_FAIL(error.what());
      ++refused_;
      return;
    }
    ++built_;
    model::check_model(model);
    drive::DriveSource drives(scene, model);
    const model::SolverOptions solver_options{.rotation = scene.solver.rotation};
    const auto threads = static_cast<unsigned>(*rc::gen::inRange(1, 4));
    const auto solver = cpu_reference::make_cpu_solver(model, solver_options, threads);
    std::unique_ptr<model::Solver> vulkan;
    if (device_ && *rc::gen::inRange(0, 4) == 0)
      vulkan = gpu::make_vulkan_solver(*device_, model, solver_options);
    constexpr model::Read everything{.positions = true, .velocities = true, .surface = true};
    for (model::Solver* each : {solver.get(), vulkan.get()})
      if (each) each->load(drives.initial_state());
    model::Frame frame;
    for (std::uint64_t k = 1; k <= 10; ++k) {
      solver->submit(drives.drive(k), everything);
      frame = solver->collect();
      for (const auto* values : {&frame.positions, &frame.velocities, &frame.surface})
        for (const float x : *values) RC_ASSERT(std::isfinite(x));
    }
    if (!vulkan) return;
    model::Frame other;
    for (std::uint64_t k = 1; k <= 10; ++k) {
      vulkan->submit(drives.drive(k), everything);
      other = vulkan->collect();
    }
    RC_ASSERT(same_bits(frame.positions, other.positions));
    RC_ASSERT(same_bits(frame.velocities, other.velocities));
    RC_ASSERT(same_bits(frame.surface, other.surface));
    ++compared_;
  }

  int built_ = 0, refused_ = 0, compared_ = 0;

 private:
  static inline std::unique_ptr<gpu::Device> device_;
};

TEST_F(Properties, RandomBarsStayFinite) {
  EXPECT_TRUE(rc::check("a bar of any size, shape and material stays finite", [&] {
    scene::Bar bar;
    bar.size = {number_in(1e-3, 10.0), number_in(1e-3, 10.0), number_in(1e-3, 10.0)};
    for (auto& count : bar.vertices) count = static_cast<std::uint32_t>(*rc::gen::inRange(2, 7));
    bar.jitter = *rc::gen::element(0.0, 0.1, 0.3);
    bar.seed = *rc::gen::arbitrary<std::uint64_t>();
    check(random_scene(bar));
  }));
  EXPECT_GT(built_, 25) << "most random bars are valid";
}

// Random points, some coincident or coplanar, and tetrahedra of any four of them.
TEST_F(Properties, RandomTetrahedraStayFiniteOrAreRefused) {
  EXPECT_TRUE(rc::check("any tetrahedra stay finite or are refused", [&] {
    mesh::TetMesh mesh;
    const int points = *rc::gen::inRange(0, 12);
    for (int k = 0; k < points; ++k) {
      const double coordinate = *rc::gen::element(0.0, 1.0, number_in(-1, 1), 1e-30, 1e30, std::nan(""));
      mesh.vertices.emplace_back(coordinate, number_in(-1, 1), *rc::gen::element(0.0, number_in(-1, 1)));
    }
    const int tetrahedra = *rc::gen::inRange(0, 12);
    for (int k = 0; k < tetrahedra; ++k) {
      std::array<std::uint32_t, 4> corners{};
      for (auto& corner : corners) corner = static_cast<std::uint32_t>(*rc::gen::inRange(0, points + 1));
      mesh.tetrahedra.push_back(corners);
    }
    check(random_scene(mesh));
  }));
  EXPECT_GT(refused_, 0) << "random numbers rarely form a valid mesh";
}

// A valid mesh of random shape: tetrahedra glued to faces, one after another.
mesh::TetMesh grown_mesh() {
  mesh::TetMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.tetrahedra = {{0, 1, 2, 3}};
  std::vector<std::array<std::uint32_t, 3>> faces{{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
  const int growth = *rc::gen::inRange(0, 20);
  for (int k = 0; k < growth; ++k) {
    const auto at = static_cast<std::size_t>(*rc::gen::inRange<std::size_t>(0, faces.size()));
    const auto [a, b, c] = faces[at];
    const Vector3d normal = (mesh.vertices[b] - mesh.vertices[a]).cross(mesh.vertices[c] - mesh.vertices[a]);
    const Vector3d top = (mesh.vertices[a] + mesh.vertices[b] + mesh.vertices[c]) / 3 +
                         normal.normalized() * number_in(0.2, 1.0) + 0.1 * direction();
    const auto d = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.push_back(top);
    mesh.tetrahedra.push_back({a, b, c, d});
    faces.erase(faces.begin() + static_cast<std::ptrdiff_t>(at));
    faces.push_back({a, b, d});
    faces.push_back({b, c, d});
    faces.push_back({c, a, d});
  }
  return mesh;
}

TEST_F(Properties, GrownMeshesStayFinite) {
  EXPECT_TRUE(rc::check("a grown mesh stays finite", [&] { check(random_scene(grown_mesh())); }));
  EXPECT_GT(built_, 25);
}

// A valid mesh with up to two defects.
TEST_F(Properties, DamagedMeshesStayFiniteOrAreRefused) {
  EXPECT_TRUE(rc::check("a damaged mesh stays finite or is refused", [&] {
    mesh::TetMesh mesh = grown_mesh();
    const int damages = *rc::gen::inRange(0, 3);
    for (int k = 0; k < damages; ++k) {
      const auto vertex = *rc::gen::inRange<std::size_t>(0, mesh.vertices.size());
      const auto tetrahedron = *rc::gen::inRange<std::size_t>(0, mesh.tetrahedra.size());
      const auto corner = *rc::gen::inRange<std::size_t>(0, 4);
      switch (*rc::gen::inRange(0, 6)) {
        case 0:
          mesh.vertices[vertex].x() = *rc::gen::element(std::nan(""), 1e30, 1e-30, INFINITY);
          break;
        case 1:
          mesh.vertices[vertex] += direction();
          break;
        case 2:
          mesh.vertices[vertex] = mesh.vertices[0];
          break;
        case 3:
          mesh.tetrahedra[tetrahedron][corner] = static_cast<std::uint32_t>(vertex);
          break;
        case 4:
          mesh.tetrahedra[tetrahedron][corner] += 7;
          break;
        default:
          mesh.tetrahedra.push_back(mesh.tetrahedra[tetrahedron]);
          break;
      }
    }
    check(random_scene(mesh));
  }));
  EXPECT_GT(built_, 3) << "a third of the meshes are undamaged";
  EXPECT_GT(refused_, 3) << "most damage is harmful";
}

// An octahedron, subdivided twice, its vertices at random distances from the centre: closed and star-shaped,
// so it never intersects itself.
mesh::SurfaceMesh random_surface() {
  mesh::SurfaceMesh surface;
  surface.vertices = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  surface.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                       {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  const int cuts = *rc::gen::inRange(0, 3);
  for (int cut = 0; cut < cuts; ++cut) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> halves;
    const auto half = [&](std::uint32_t a, std::uint32_t b) {
      const auto [at, is_new] =
          halves.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(surface.vertices.size()));
      if (is_new) surface.vertices.push_back((surface.vertices[a] + surface.vertices[b]).normalized());
      return at->second;
    };
    std::vector<std::array<std::uint32_t, 3>> finer;
    for (const auto& [a, b, c] : surface.triangles) {
      const std::uint32_t ab = half(a, b), bc = half(b, c), ca = half(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    surface.triangles = finer;
  }
  for (Vector3d& p : surface.vertices) p *= number_in(0.6, 1.4);
  return surface;
}

TEST_F(Properties, RandomSurfacesAroundBonesStayFinite) {
  build::BuildOptions options;
  options.mesher = std::string(FASCICLE_BINARY_DIR) + "/fascicle-mesher";
  EXPECT_TRUE(rc::check("a closed surface around bones stays finite", [&] {
    Scene scene = random_scene(random_surface());
    if (*rc::gen::arbitrary<bool>()) scene.resolution = scene.scale * number_in(0.3, 1.0);
    scene.bones = {{"bone", 0.3 * scene.scale * direction(), 0.3 * scene.scale * direction()}};
    scene::Layer bone;
    bone.name = "bone";
    bone.kinematic = true;
    bone.where = {scene::BoneDistance{.minimum = 0.0, .maximum = scene.scale * number_in(0.4, 1.0)}};
    scene.layers.push_back(bone);
    check(scene, options);
  }));
  EXPECT_GT(built_, 12) << "a layer of at least 0.4 around a bone usually contains a vertex";
}

}  // namespace

}  // namespace fascicle::tests
