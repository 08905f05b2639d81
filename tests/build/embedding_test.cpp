// Embedding: the skin of a body rides on its tetrahedra.
#include "host/build/embedding.h"

#include <cmath>
#include <numeric>
#include <random>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "host/build/bar.h"
#include "host/build/skin_weights.h"
#include "tests/build/surfaces.h"

namespace fascicle::tests {
namespace {

using build::BodyMesh;
using build::RenderMesh;
using build::SkinWeights;
using build::WeldedSurface;
using mesh::TetMesh;
using scene::Vector3d;

// The tetrahedron in which a point is deepest, by exhaustive search; it solves a linear system where the
// library uses determinants.
std::uint32_t deepest(const TetMesh& mesh, const Vector3d& point) {
  std::uint32_t best = 0;
  double depth = -1e300;
  for (std::uint32_t k = 0; k < mesh.tetrahedra.size(); ++k) {
    Eigen::Matrix4d corners;
    for (int c = 0; c < 4; ++c)
      corners.col(c) << mesh.vertices[mesh.tetrahedra[k][static_cast<std::size_t>(c)]], 1.0;
    const double least = corners.fullPivLu().solve(point.homogeneous()).minCoeff();
    if (least > depth) {
      depth = least;
      best = k;
    }
  }
  return best;
}

// Points as a skin; every three consecutive points form a triangle.
WeldedSurface skin_of(const std::vector<Vector3d>& points) {
  WeldedSurface welded;
  welded.surface.vertices = points;
  for (std::uint32_t v = 0; v < points.size(); ++v) {
    welded.of_vertex.push_back(v);
    if (v >= 2) welded.surface.triangles.push_back({v - 2, v - 1, v});
  }
  return welded;
}

BodyMesh cage_of(const TetMesh& mesh, const WeldedSurface& welded) {
  BodyMesh body;
  body.mesh = mesh;
  body.keeps_skin = false;
  for (const Vector3d& p : welded.surface.vertices) body.home.push_back(deepest(mesh, p));
  return body;
}

std::vector<Vector3d> points_within(const Vector3d& size, std::size_t count) {
  std::mt19937 engine(11);
  const auto part = [&] { return static_cast<double>(engine()) / 4294967296.0; };
  std::vector<Vector3d> points;
  for (std::size_t k = 0; k < count; ++k) {
    const double x = part(), y = part(), z = part();
    points.push_back(size.cwiseProduct(Vector3d(x, y, z)));
  }
  return points;
}

// The arithmetic of kernel/embed.inc, in floats.
Eigen::Vector3f carried(const RenderMesh& render, std::size_t vertex,
                        const std::vector<Eigen::Vector3f>& at) {
  std::array<float, 4> w{};
  for (std::size_t c = 0; c < 4; ++c) w[c] = static_cast<float>(render.weights[vertex][c]);
  Eigen::Vector3f result;
  for (int a = 0; a < 3; ++a) {
    const auto x = [&](std::size_t c) { return at[render.corners[vertex][c]][a]; };
    result[a] = (w[0] * x(0) + w[1] * x(1)) + (w[2] * x(2) + w[3] * x(3));
  }
  return result;
}

const scene::Bar cage_bar{.size = {1.0, 0.5, 0.5}, .vertices = {9, 5, 5}, .jitter = 0.3};

TEST(Embedding, BarycentricCoordinatesOfKnownPoints) {
  TetMesh mesh;
  mesh.vertices = {{0, 0, 0}, {2, 0, 0}, {0, 4, 0}, {0, 0, 8}};
  const std::array<std::uint32_t, 4> t{0, 1, 2, 3};
  EXPECT_EQ(build::barycentric(mesh, t, {0, 0, 0}), (std::array<double, 4>{1, 0, 0, 0}));
  EXPECT_EQ(build::barycentric(mesh, t, {0, 4, 0}), (std::array<double, 4>{0, 0, 1, 0}));
  EXPECT_EQ(build::barycentric(mesh, t, {0.5, 1, 2}), (std::array<double, 4>{0.25, 0.25, 0.25, 0.25}));
  EXPECT_EQ(build::barycentric(mesh, t, {-1, 0, 0}), (std::array<double, 4>{1.5, -0.5, 0, 0}));
}

TEST(Embedding, RestPoseAndRigidMotionsComeBackInFloats) {
  const TetMesh mesh = build::make_bar(cage_bar, "test");
  const WeldedSurface welded = skin_of(points_within({1.0, 0.5, 0.5}, 300));
  build::Report report;
  const RenderMesh render =
      build::embed_surface(welded.surface, welded, cage_of(mesh, welded), {}, {}, report);
  ASSERT_EQ(render.corners.size(), 300u);
  EXPECT_EQ(render.triangles, welded.surface.triangles);
  EXPECT_TRUE(report.warnings.empty());
  const Eigen::Affine3d still = Eigen::Affine3d::Identity();
  Eigen::Affine3d turned = Eigen::Affine3d::Identity();
  turned.rotate(Eigen::AngleAxisd(2.0, Vector3d(1, 2, 3).normalized())).translate(Vector3d(0.3, -0.5, 0.2));
  for (const Eigen::Affine3d& motion : {still, turned}) {
    std::vector<Eigen::Vector3f> at;
    for (const Vector3d& p : mesh.vertices) at.push_back((motion * p).cast<float>());
    for (std::size_t v = 0; v < 300; ++v) {
      float sum = 0.0f;
      for (const double w : render.weights[v]) {
        EXPECT_EQ(static_cast<double>(static_cast<float>(w)), w);
        sum += static_cast<float>(w);
      }
      EXPECT_EQ(sum, 1.0f);
      // 1e-6 of the body, which is 1 m long. Positions, weights, products and sums are each rounded by 2^-25.
      EXPECT_LT((carried(render, v, at).cast<double>() - motion * welded.surface.vertices[v]).norm(), 1e-6);
    }
  }
}

TEST(Embedding, AKeptSkinRidesOnItself) {
  BodyMesh body;
  body.mesh = build::make_bar(cage_bar, "test");
  WeldedSurface welded = skin_of({body.mesh.vertices[0], body.mesh.vertices[1], body.mesh.vertices[2]});
  welded.of_vertex = {0, 1, 2, 1};
  mesh::SurfaceMesh surface = welded.surface;
  surface.vertices.push_back(surface.vertices[1]);
  build::Report report;
  const RenderMesh render = build::embed_surface(surface, welded, body, {}, {}, report);
  ASSERT_EQ(render.corners.size(), 4u);
  EXPECT_EQ(render.corners[3], (std::array<std::uint32_t, 4>{1, 1, 1, 1}));
  EXPECT_EQ(render.weights[3], (std::array<double, 4>{1, 0, 0, 0}));
}

TEST(Embedding, BothSidesOfASeamRideAlike) {
  const TetMesh mesh = build::make_bar(cage_bar, "test");
  WeldedSurface welded = skin_of(points_within({1.0, 0.5, 0.5}, 3));
  mesh::SurfaceMesh surface = welded.surface;
  surface.vertices.push_back(surface.vertices[1]);
  const BodyMesh body = cage_of(mesh, welded);
  welded.of_vertex = {0, 1, 2, 1};
  build::Report report;
  const RenderMesh render = build::embed_surface(surface, welded, body, {}, {}, report);
  EXPECT_EQ(render.corners[1], render.corners[3]);
  EXPECT_EQ(render.weights[1], render.weights[3]);
}

// Two overlapping limbs: two copies of the bar, the first moved by joint 0 and the second by joint 1.
struct TwoLimbs {
  TetMesh mesh;
  SkinWeights weights;
  std::uint32_t tetrahedra_of_one = 0;
};

TwoLimbs two_limbs(const Vector3d& apart) {
  const TetMesh bar = build::make_bar(cage_bar, "test");
  TwoLimbs limbs{bar, {}, static_cast<std::uint32_t>(bar.tetrahedra.size())};
  const auto count = static_cast<std::uint32_t>(bar.vertices.size());
  for (const Vector3d& p : bar.vertices) limbs.mesh.vertices.push_back(p + apart);
  for (const auto& t : bar.tetrahedra)
    limbs.mesh.tetrahedra.push_back({t[0] + count, t[1] + count, t[2] + count, t[3] + count});
  limbs.weights.offset.push_back(0);
  for (std::uint32_t v = 0; v < 2 * count; ++v) {
    limbs.weights.joint.push_back(v < count ? 0 : 1);
    limbs.weights.weight.push_back(1.0);
    limbs.weights.offset.push_back(v + 1);
  }
  return limbs;
}

SkinWeights all_on(std::uint32_t joint, std::size_t count) {
  SkinWeights weights;
  for (std::uint32_t v = 0; v <= count; ++v) weights.offset.push_back(v);
  weights.joint.assign(count, joint);
  weights.weight.assign(count, 1.0);
  return weights;
}

TEST(Embedding, AVertexRidesOnTheLimbThatItsJointsMove) {
  // The second limb overlaps most of the first. All homes are in the first limb, which is wrong for joint 1.
  const TwoLimbs limbs = two_limbs({0.3, 0, 0});
  const std::vector<Vector3d> points = points_within({0.65, 0.5, 0.5}, 100);
  std::vector<Vector3d> in_both;
  for (const Vector3d& p : points) in_both.push_back(p + Vector3d(0.32, 0, 0));
  const WeldedSurface welded = skin_of(in_both);
  BodyMesh body = cage_of(build::make_bar(cage_bar, "test"), welded);
  body.mesh = limbs.mesh;
  for (const std::uint32_t joint : {0u, 1u}) {
    build::Report report;
    const RenderMesh render =
        build::embed_surface(welded.surface, welded, body, limbs.weights, all_on(joint, 100), report);
    for (std::size_t v = 0; v < 100; ++v) {
      for (const std::uint32_t corner : render.corners[v])
        EXPECT_EQ(limbs.weights.joint[corner], joint) << "vertex " << v;
      EXPECT_GE(*std::min_element(render.weights[v].begin(), render.weights[v].end()), -1e-6);
    }
    EXPECT_TRUE(report.warnings.empty());
  }
}

// Three limbs in the same place, moved by joints 0, 1 and 1: the same place in each is equally good.
TEST(Embedding, TiesGoToTheHomeAndThenToTheLowestNumber) {
  const TetMesh bar = build::make_bar(cage_bar, "test");
  const auto vertices = static_cast<std::uint32_t>(bar.vertices.size());
  const auto tetrahedra = static_cast<std::uint32_t>(bar.tetrahedra.size());
  TwoLimbs limbs = two_limbs({0, 0, 0});
  limbs.mesh.vertices.insert(limbs.mesh.vertices.end(), bar.vertices.begin(), bar.vertices.end());
  for (const auto& t : bar.tetrahedra)
    limbs.mesh.tetrahedra.push_back(
        {t[0] + 2 * vertices, t[1] + 2 * vertices, t[2] + 2 * vertices, t[3] + 2 * vertices});
  for (std::uint32_t v = 0; v < vertices; ++v) {
    limbs.weights.joint.push_back(1);
    limbs.weights.weight.push_back(1.0);
    limbs.weights.offset.push_back(2 * vertices + v + 1);
  }
  const WeldedSurface welded = skin_of(points_within({1.0, 0.5, 0.5}, 20));
  const BodyMesh on_bar = cage_of(bar, welded);
  // {the skin's joint, the limb of its home, the limb that it rides on}: the home lacks joint 1, which two
  // limbs have; no limb has joint 2, so each is as good as the home.
  for (const auto& [joint, home, limb] : {std::array{1u, 0u, 1u}, {2u, 0u, 0u}, {2u, 1u, 1u}, {2u, 2u, 2u}}) {
    SCOPED_TRACE(testing::Message() << "joint " << joint << ", home in limb " << home);
    BodyMesh body = on_bar;
    body.mesh = limbs.mesh;
    for (std::uint32_t& number : body.home) number += home * tetrahedra;
    build::Report report;
    const RenderMesh render =
        build::embed_surface(welded.surface, welded, body, limbs.weights, all_on(joint, 20), report);
    for (std::size_t v = 0; v < 20; ++v)
      for (const std::uint32_t corner : render.corners[v])
        EXPECT_EQ(corner / vertices, limb) << "vertex " << v;
  }
}

TEST(Embedding, ALittleOutOfTheRightLimbIsBetterThanInsideTheWrongOne) {
  // The second limb begins at x = 0.9; one of its vertices is 0.01 before that, inside the first limb.
  const TwoLimbs limbs = two_limbs({0.9, 0, 0});
  const WeldedSurface welded = skin_of({{0.89, 0.2, 0.3}, {0.95, 0.2, 0.3}, {0.95, 0.3, 0.3}});
  BodyMesh body = cage_of(build::make_bar(cage_bar, "test"), welded);
  body.mesh = limbs.mesh;
  // Its home is the nearest tetrahedron of its own limb.
  double most = -1.0;
  for (std::size_t i = body.mesh.tetrahedra.size() / 2; i < body.mesh.tetrahedra.size(); ++i) {
    const auto weights = build::barycentric(body.mesh, body.mesh.tetrahedra[i], welded.surface.vertices[0]);
    const double least = *std::min_element(weights.begin(), weights.end());
    if (least <= most) continue;
    most = least;
    body.home[0] = static_cast<std::uint32_t>(i);
  }
  ASSERT_LT(most, -0.05);
  build::Report report;
  const RenderMesh render =
      build::embed_surface(welded.surface, welded, body, limbs.weights, all_on(1, 3), report);
  for (const std::uint32_t corner : render.corners[0]) EXPECT_EQ(limbs.weights.joint[corner], 1u);
  EXPECT_LT(report.fill.least_barycentric, 0.0);
  EXPECT_EQ(report.fill.riders_outside, 1u);
  // The control: the same position with the other limb's weights.
  build::Report other_report;
  const RenderMesh other =
      build::embed_surface(welded.surface, welded, body, limbs.weights, all_on(0, 3), other_report);
  for (const std::uint32_t corner : other.corners[0]) EXPECT_EQ(limbs.weights.joint[corner], 0u);
  EXPECT_EQ(other_report.fill.riders_outside, 0u);
}

TEST(Embedding, ReportsWhatSticksOutAndWhatOtherJointsMoveByTheFilesVertices) {
  const TwoLimbs limbs = two_limbs({5, 0, 0});
  // Vertex 4 of the file, 3 after welding, is half a cell outside.
  WeldedSurface welded = skin_of({{0.1, 0.2, 0.3}, {0.2, 0.2, 0.3}, {0.3, 0.3, 0.3}, {-0.06, 0.2, 0.2}});
  mesh::SurfaceMesh surface = welded.surface;
  surface.vertices.insert(surface.vertices.begin(), surface.vertices[0]);
  BodyMesh body = cage_of(build::make_bar(cage_bar, "test"), welded);
  body.mesh = limbs.mesh;
  welded.of_vertex = {0, 0, 1, 2, 3};
  SkinWeights skin = all_on(0, 4);
  skin.joint[2] = 7;  // a joint that moves no part of the body; vertex 3 of the file
  build::Report report;
  build::embed_surface(surface, welded, body, limbs.weights, skin, report);
  EXPECT_EQ(report.fill.riders_outside, 1u);
  EXPECT_LT(report.fill.least_barycentric, build::least_barycentric);
  ASSERT_EQ(report.warnings.size(), 2u);
  EXPECT_NE(report.warnings[0].text.find("vertex 4 of the file"), std::string::npos)
      << report.warnings[0].text;
  EXPECT_NE(report.warnings[1].text.find("vertex 3 of the file"), std::string::npos)
      << report.warnings[1].text;
  // Without the rigid parts, the remaining vertices have other numbers in the file.
  welded.file_vertex = {10, 11, 12, 23, 24};
  build::Report of_soft_skin;
  build::embed_surface(surface, welded, body, limbs.weights, skin, of_soft_skin);
  ASSERT_EQ(of_soft_skin.warnings.size(), 2u);
  EXPECT_NE(of_soft_skin.warnings[0].text.find("vertex 24 of the file"), std::string::npos);
  EXPECT_NE(of_soft_skin.warnings[1].text.find("vertex 23 of the file"), std::string::npos);
}

TEST(Embedding, AgreementIsTheCommonPart) {
  SkinWeights skin;
  skin.offset = {0, 2, 3, 5};
  skin.joint = {4, 2, 2, 4, 9};
  skin.weight = {0.75, 0.25, 1.0, 0.5, 0.5};
  EXPECT_EQ(build::weight_agreement(skin, 0, skin, {0, 0, 0, 0}, {1, 0, 0, 0}), 1.0);
  EXPECT_EQ(build::weight_agreement(skin, 0, skin, {1, 1, 1, 1}, {1, 0, 0, 0}), 0.25);
  EXPECT_EQ(build::weight_agreement(skin, 1, skin, {2, 2, 2, 2}, {1, 0, 0, 0}), 0.0);
  EXPECT_EQ(build::weight_agreement(skin, 0, skin, {1, 2, 1, 2}, {0.5, 0.5, 0, 0}), 0.5);
}

// A cage's boundary takes weights from its anchors, not from nearby skin.
TEST(SkinWeights, OfACageComeFromItsAnchors) {
  BodyMesh body;
  body.keeps_skin = false;
  body.mesh = build::make_bar({.size = {1, 0.5, 0.5}, .vertices = {11, 6, 6}, .jitter = 0.2}, "test");
  // One long distant triangle along x; the weight of joint 1 grows along it.
  const WeldedSurface welded = skin_of({{0, 9, 0}, {1, 9, 0}, {0, 9, 1}});
  SkinWeights skin;
  skin.offset = {0, 1, 2, 3};
  skin.joint = {0, 1, 0};
  skin.weight = {1.0, 1.0, 1.0};
  for (const Vector3d& p : body.mesh.vertices)
    body.anchor.push_back({0, {0.5 * (1.0 - p[0]), p[0], 0.5 * (1.0 - p[0])}});
  const SkinWeights found = build::body_skin_weights(body, welded, skin, 2, "test");
  ASSERT_EQ(found.offset.size(), body.mesh.vertices.size() + 1);
  for (std::size_t i = 0; i < body.mesh.vertices.size(); ++i) {
    double second = 0.0;
    for (std::uint32_t k = found.offset[i]; k < found.offset[i + 1]; ++k)
      if (found.joint[k] == 1) second += found.weight[k];
    // A linear field is harmonic; shares below 1e-4 are dropped.
    EXPECT_NEAR(second, body.mesh.vertices[i][0], 1.01e-4);
  }
}

}  // namespace
}  // namespace fascicle::tests
