// The fibre field, compared with a dense solve and a closed form; and its constraints.
#include "host/build/fibre.h"

#include <cmath>
#include <cstdint>
#include <numbers>
#include <set>
#include <utility>

#include <Eigen/Geometry>
#include <Eigen/QR>
#include <gtest/gtest.h>

#include "host/build/bar.h"
#include "host/build/boundary.h"
#include "host/model/model.h"
#include "tests/build/scenes.h"

namespace fascicle::tests {
namespace {

using build::FibreConstraint;
using build::FibreSolution;
using scene::Vector3d;

struct Mesh {
  mesh::TetMesh tets;
  build::OneRings rings;
};

Mesh bar_mesh(std::array<std::uint32_t, 3> vertices, double jitter) {
  scene::Bar bar;
  bar.vertices = vertices;
  bar.jitter = jitter;
  Mesh mesh{build::make_bar(bar, "test"), {}};
  mesh.rings = build::one_rings(mesh.tets.vertices.size(), mesh.tets.tetrahedra);
  return mesh;
}

FibreSolution solve(const Mesh& mesh, const std::vector<FibreConstraint>& constraints,
                    const build::FibreOptions& options = {}) {
  return build::solve_fibre_field(mesh.tets.vertices, mesh.rings, constraints, options);
}

// Constraints at both ends of the bar.
std::vector<FibreConstraint> at_ends(const Mesh& mesh, const Vector3d& low, const Vector3d& high) {
  std::vector<FibreConstraint> constraints;
  for (std::uint32_t i = 0; i < mesh.tets.vertices.size(); ++i) {
    const double x = mesh.tets.vertices[i][0];
    if (x < 1e-9) constraints.push_back({i, low});
    if (x > 0.4 - 1e-9) constraints.push_back({i, high});
  }
  return constraints;
}

// Equations (1) to (3) as printed, as one dense least-squares problem; rows are normalised.
Eigen::MatrixX3d dense_solution(const Mesh& mesh, const std::vector<FibreConstraint>& constraints) {
  const auto& q = mesh.tets.vertices;
  double edge = 0.0;
  for (std::size_t i = 0; i < q.size(); ++i)
    for (const std::uint32_t j : mesh.rings[i]) edge += (q[j] - q[i]).norm();
  edge /= static_cast<double>(mesh.rings.neighbour.size());
  const auto n = static_cast<Eigen::Index>(q.size()), c = static_cast<Eigen::Index>(constraints.size());
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(n + c, n);
  Eigen::MatrixX3d b = Eigen::MatrixX3d::Zero(n + c, 3);
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto ring = mesh.rings[static_cast<std::size_t>(i)];
    double sum = 0.0;
    for (const std::uint32_t j : ring)
      sum += std::exp(-(q[j] - q[static_cast<std::size_t>(i)]).norm() / edge);
    for (const std::uint32_t j : ring)
      a(i, j) = -std::exp(-(q[j] - q[static_cast<std::size_t>(i)]).norm() / edge) / sum;
    a(i, i) = 1.0;
  }
  const double root = std::sqrt(1.0e3);
  for (Eigen::Index k = 0; k < c; ++k) {
    const FibreConstraint& constraint = constraints[static_cast<std::size_t>(k)];
    a(n + k, constraint.vertex) = root;
    b.row(n + k) = root * constraint.direction.transpose();
  }
  return Eigen::MatrixX3d(a.colPivHouseholderQr().solve(b)).rowwise().normalized();
}

TEST(FibreField, IsTheDenseLeastSquaresSolution) {
  const Mesh mesh = bar_mesh({7, 4, 4}, 0.3);
  const std::vector<FibreConstraint> constraints = at_ends(mesh, {1, 0, 0}, Vector3d(1, 2, -1).normalized());
  const Eigen::MatrixX3d dense = dense_solution(mesh, constraints);
  const FibreSolution field = solve(mesh, constraints, {.tolerance = 1e-12, .most_rounds = 1});
  // The residual is 1e-12 of the right-hand side; the least squares of a bar 7 vertices long amplify it by
  // 1e4.
  for (Eigen::Index i = 0; i < dense.rows(); ++i)
    EXPECT_LE((dense.row(i).transpose() - field.direction[static_cast<std::size_t>(i)]).norm(), 1e-7);
  // All directions are on one side, so no sign needs to change and the field of lines is the same.
  const FibreSolution lines = solve(mesh, constraints, {.tolerance = 1e-12});
  EXPECT_EQ(lines.rounds, 1u);
  for (std::size_t i = 0; i < lines.direction.size(); ++i)
    EXPECT_LE((lines.direction[i] - field.direction[i]).norm(), 1e-12);
}

// The control: the comparison detects another lambda.
TEST(FibreField, DiffersFromTheDenseSolutionWithAnotherLambda) {
  const Mesh mesh = bar_mesh({7, 4, 4}, 0.3);
  const std::vector<FibreConstraint> constraints = at_ends(mesh, {1, 0, 0}, Vector3d(1, 2, -1).normalized());
  const Eigen::MatrixX3d dense = dense_solution(mesh, constraints);
  const FibreSolution field = solve(mesh, constraints, {.lambda = 1.0, .most_rounds = 1});
  double worst = 0.0;
  for (Eigen::Index i = 0; i < dense.rows(); ++i)
    worst = std::max(worst, (dense.row(i).transpose() - field.direction[static_cast<std::size_t>(i)]).norm());
  EXPECT_GT(worst, 1e-4);
}

TEST(FibreField, IsStraightInAStraightBar) {
  for (const double jitter : {0.0, 0.3}) {
    const Mesh mesh = bar_mesh({21, 5, 5}, jitter);
    const FibreSolution field = solve(mesh, at_ends(mesh, {1, 0, 0}, {1, 0, 0}));
    EXPECT_TRUE(field.has_converged);
    // Constant fields solve (1) exactly; the tolerance is 1e-8 of the residual, over a bar 20 edges long.
    for (const Vector3d& d : field.direction) EXPECT_LE((d - Vector3d(1, 0, 0)).norm(), 1e-5);
  }
}

TEST(FibreField, KeepsItsConstraints) {
  const Mesh mesh = bar_mesh({21, 5, 5}, 0.2);
  const Vector3d low = Vector3d(1, 1, 0).normalized(), high = Vector3d(1, -1, 1).normalized();
  const std::vector<FibreConstraint> constraints = at_ends(mesh, low, high);
  const FibreSolution field = solve(mesh, constraints);
  // lambda is 1e3 and the other terms are at most 1, so directions deviate by about a thousandth.
  for (const FibreConstraint& c : constraints)
    EXPECT_LE((field.direction[c.vertex] - c.direction).norm(), 2e-3);
  for (const Vector3d& d : field.direction) EXPECT_NEAR(d.norm(), 1.0, 1e-12);
}

TEST(FibreField, DoesNotDependOnTheUnit) {
  Mesh mesh = bar_mesh({11, 4, 4}, 0.3);
  const std::vector<FibreConstraint> constraints = at_ends(mesh, {1, 0, 0}, {0, 1, 0});
  const FibreSolution metres = solve(mesh, constraints);
  for (Vector3d& p : mesh.tets.vertices) p *= 1024.0;
  const FibreSolution scaled = solve(mesh, constraints);
  for (std::size_t i = 0; i < metres.direction.size(); ++i)
    EXPECT_EQ(metres.direction[i], scaled.direction[i]);  // a power of two causes no rounding
  for (Vector3d& p : mesh.tets.vertices) p *= 0.001;
  const FibreSolution other = solve(mesh, constraints);
  for (std::size_t i = 0; i < metres.direction.size(); ++i)
    EXPECT_LE((metres.direction[i] - other.direction[i]).norm(), 1e-6);
}

// Directions that are nearly opposed mean lines that are nearly parallel, here 20 degrees apart; vertices in
// between lie in that range. The control: the equations as printed turn the long way round, by 160 degrees.
TEST(FibreField, TakesOpposedDirectionsForLinesThatLieClose) {
  const Mesh mesh = bar_mesh({22, 6, 6}, 0.1);
  const double tilt = 20.0 / 180.0 * std::numbers::pi;
  std::vector<FibreConstraint> constraints;
  std::vector<char> on_skin(mesh.tets.vertices.size(), 0);
  for (const auto& t : build::boundary_triangles(mesh.tets, "test"))
    for (const std::uint32_t corner : t) on_skin[corner] = 1;
  for (std::uint32_t i = 0; i < on_skin.size(); ++i)
    if (on_skin[i])
      constraints.push_back({i, mesh.tets.vertices[i][0] < 0.2
                                    ? Vector3d(1, 0, 0)
                                    : Vector3d(-std::cos(tilt), std::sin(tilt), 0)});
  const auto least_along_x = [](const FibreSolution& field) {
    double least = 1.0;
    for (const Vector3d& d : field.direction) least = std::min(least, std::abs(d[0]));
    return least;
  };
  const FibreSolution lines = solve(mesh, constraints);
  EXPECT_GT(lines.rounds, 1u);
  // The equations contain second differences and may overshoot a step by a few degrees.
  EXPECT_GT(least_along_x(lines), std::cos(1.5 * tilt));
  const FibreSolution printed = solve(mesh, constraints, {.most_rounds = 1});
  EXPECT_LT(least_along_x(printed), std::cos(2.0 * tilt));
  // The iterations of all rounds are counted.
  EXPECT_GT(printed.iterations, 0u);
  EXPECT_GT(lines.iterations, printed.iterations);
}

TEST(FibreField, IsNothingWhereNothingIsSaid) {
  Mesh mesh = bar_mesh({5, 3, 3}, 0.0);
  const FibreSolution none = solve(mesh, {});
  for (const Vector3d& d : none.direction) EXPECT_EQ(d, Vector3d(Vector3d::Zero()));
  EXPECT_EQ(none.rounds, 0u) << "nothing is solved";
  // A second bar, disconnected from the first.
  const std::vector<FibreConstraint> constraints = at_ends(mesh, {1, 0, 0}, {1, 0, 0});
  const auto count = static_cast<std::uint32_t>(mesh.tets.vertices.size());
  for (std::uint32_t i = 0; i < count; ++i)
    mesh.tets.vertices.push_back(mesh.tets.vertices[i] + Vector3d(9, 0, 0));
  const std::size_t tets = mesh.tets.tetrahedra.size();
  for (std::size_t t = 0; t < tets; ++t) {
    auto copy = mesh.tets.tetrahedra[t];
    for (std::uint32_t& corner : copy) corner += count;
    mesh.tets.tetrahedra.push_back(copy);
  }
  mesh.rings = build::one_rings(mesh.tets.vertices.size(), mesh.tets.tetrahedra);
  const FibreSolution field = solve(mesh, constraints);
  for (std::uint32_t i = 0; i < count; ++i) {
    EXPECT_NEAR(std::abs(field.direction[i][0]), 1.0, 1e-6);
    EXPECT_EQ(field.direction[count + i], Vector3d(Vector3d::Zero()));
  }
}

TEST(FibreField, HasTheSameBitsEveryTime) {
  const Mesh mesh = bar_mesh({11, 5, 5}, 0.3);
  const std::vector<FibreConstraint> constraints = at_ends(mesh, {1, 0, 0}, {0, 1, 0});
  const FibreSolution a = solve(mesh, constraints), b = solve(mesh, constraints);
  for (std::size_t i = 0; i < a.direction.size(); ++i) EXPECT_EQ(a.direction[i], b.direction[i]);
}

// A bar with a bone along it: the core is bone, the rest follows the fibre field.
scene::Scene boned_bar() {
  scene::Scene scene = bar_scene();
  scene.bones = {{"bone", {0.0, 0.04, 0.04}, {0.4, 0.05, 0.04}}};
  scene.layers[0].fibre.reset();
  scene.layers[0].fibre_field = true;
  scene.layers.push_back({});
  scene.layers[1].name = "bone";
  scene.layers[1].kinematic = true;
  scene.layers[1].where = {scene::BoneDistance{0.0, 0.01}};
  return scene;
}

build::Body body_of(const scene::Scene& scene) {
  build::Body body;
  body.mesh = build::make_bar(std::get<scene::Bar>(scene.geometry), "test");
  for (const scene::BoneSegment& bone : scene.bones) body.bones.push_back({bone.from, bone.to, {}});
  return body;
}

TEST(FibreConstraints, FollowTheBoneInsideAndTheSkinOutside) {
  const scene::Scene scene = boned_bar();
  const build::Body body = body_of(scene);
  build::Measures measures(body);
  std::vector<std::uint32_t> layer_of;
  for (const double distance : measures.bone_distances()) layer_of.push_back(distance <= 0.01 ? 1u : 0u);
  std::vector<char> on_skin(layer_of.size(), 0);
  for (const auto& t : build::boundary_triangles(body.mesh, "test"))
    for (const std::uint32_t corner : t) on_skin[corner] = 1;
  const Vector3d bone = Vector3d(0.4, 0.01, 0.0).normalized();
  std::size_t inside = 0, flat = 0;
  for (const FibreConstraint& c : build::fibre_constraints(scene, layer_of, 0.02, measures)) {
    EXPECT_NEAR(c.direction.norm(), 1.0, 1e-12);
    if (layer_of[c.vertex] == 1) {
      EXPECT_LE((c.direction - bone).norm(), 1e-12);
      ++inside;
      continue;
    }
    ASSERT_TRUE(on_skin[c.vertex]);
    const Vector3d& p = body.mesh.vertices[c.vertex];
    // Away from edges and ends the normal of the skin is y or z.
    if (p[0] < 0.01 || p[0] > 0.39) continue;
    const bool y = p[1] < 1e-9 || p[1] > 0.08 - 1e-9, z = p[2] < 1e-9 || p[2] > 0.08 - 1e-9;
    if (y && z) continue;
    EXPECT_NEAR(c.direction[y ? 1 : 2], 0.0, 1e-12);
    ++flat;
  }
  EXPECT_GT(inside, 10u);
  EXPECT_GT(flat, 100u);
}

// Joint 0 is in the middle of this chain, and its bone is listed last. Each bone after the first points back,
// and is turned to agree with the one before it.
TEST(FibreConstraints, TurnBonesAlongTheirChainInAnyOrder) {
  const scene::Scene scene = boned_bar();
  build::Body body = body_of(scene);
  const Vector3d a(0.0, 0.04, 0.04), b(0.2, 0.04, 0.04), c(0.3, 0.04, 0.04), d(0.4, 0.04, 0.04);
  body.bones = {{d, c, {1, 0, -1}}, {a, b, {2, -1, 0}}, {c, b, {0, 2, 1}}};
  build::Measures measures(body);
  const std::vector<std::uint32_t> layer_of(body.mesh.vertices.size(), 1u);
  const std::vector<FibreConstraint> constraints = build::fibre_constraints(scene, layer_of, 0.02, measures);
  ASSERT_EQ(constraints.size(), layer_of.size());
  for (const FibreConstraint& constraint : constraints)
    EXPECT_EQ(constraint.direction, Vector3d(1, 0, 0)) << body.mesh.vertices[constraint.vertex].transpose();
}

TEST(FibreConstraints, FollowDrawnCurves) {
  scene::Scene scene = boned_bar();
  scene.fibres = {{"slant", {{0.1, 0.08, 0.08}, {0.2, 0.08, 0.04}, {0.3, 0.08, 0.08}}, 0.005}};
  const build::Body body = body_of(scene);
  build::Measures measures(body);
  const std::vector<std::uint32_t> layer_of(body.mesh.vertices.size(), 0u);
  const Vector3d down = Vector3d(0.1, 0, -0.04).normalized(), up = Vector3d(0.1, 0, 0.04).normalized();
  std::size_t drawn = 0;
  for (const FibreConstraint& c : build::fibre_constraints(scene, layer_of, 0.02, measures)) {
    const Vector3d& p = body.mesh.vertices[c.vertex];
    const double first = build::segment_distance(p, {0.1, 0.08, 0.08}, {0.2, 0.08, 0.04});
    const double second = build::segment_distance(p, {0.2, 0.08, 0.04}, {0.3, 0.08, 0.08});
    if (std::min(first, second) > 0.005) continue;
    EXPECT_LE((c.direction - (first <= second ? down : up)).norm(), 1e-12);
    ++drawn;
  }
  EXPECT_GE(drawn, 5u);
}

TEST(FibreConstraints, FollowPaint) {
  const scene::Scene scene = boned_bar();
  build::Body body = body_of(scene);
  body.skin_surface = {body.mesh.vertices, build::boundary_triangles(body.mesh, "test")};
  // Half of the top face is painted with a slanted direction that points slightly out of the face; the other
  // half is unpainted. Neighbours have opposite signs, since a direction is a line.
  const Vector3d slanted(0.3, 0.1, 0.2), in_the_top = Vector3d(0.3, 0.0, 0.2).normalized();
  body.painted = {{"_FIBER", 3, {}}};
  const auto is_painted = [](const Vector3d& p) { return p[0] < 0.21; };
  for (std::size_t i = 0; i < body.mesh.vertices.size(); ++i) {
    const bool painted = is_painted(body.mesh.vertices[i]);
    for (int k = 0; k < 3; ++k)
      body.painted[0].values.push_back(painted ? (i % 2 ? 1 : -1) * slanted[k] : 0.0);
  }
  build::Measures measures(body);
  const std::vector<std::uint32_t> layer_of(body.mesh.vertices.size(), 0u);
  std::size_t painted = 0, others = 0;
  for (const FibreConstraint& c : build::fibre_constraints(scene, layer_of, 0.02, measures)) {
    const Vector3d& p = body.mesh.vertices[c.vertex];
    // On the interior of the top face, where the normal is y.
    if (p[1] < 0.08 - 1e-9 || p[0] < 0.01 || p[0] > 0.39 || p[2] < 0.01 || p[2] > 0.07) continue;
    if (is_painted(p)) {
      EXPECT_GE(std::abs(c.direction.dot(in_the_top)), 1.0 - 1e-12);
      ++painted;
    } else {
      EXPECT_LT(std::abs(c.direction.dot(in_the_top)), 0.95);
      ++others;
    }
  }
  EXPECT_GT(painted, 20u);
  EXPECT_GT(others, 20u);
}

// One direction painted all over, corners of the bar included: each vertex of the skin takes its part in the
// plane across the sum of its triangles' normals.
TEST(FibreConstraints, FollowPaintAtEveryVertexOfTheSkin) {
  const scene::Scene scene = boned_bar();
  build::Body body = body_of(scene);
  const std::vector<Vector3d>& at = body.mesh.vertices;
  body.skin_surface = {at, build::boundary_triangles(body.mesh, "test")};
  const Vector3d painted = Vector3d(1.0, 0.3, -0.2).normalized();
  body.painted = {{"_FIBER", 3, {}}};
  for (std::size_t i = 0; i < at.size(); ++i)
    body.painted[0].values.insert(body.painted[0].values.end(), painted.begin(), painted.end());
  std::vector<Vector3d> normal(at.size(), Vector3d::Zero());
  for (const auto& t : body.skin_surface.triangles)
    for (const std::uint32_t i : t) normal[i] += (at[t[1]] - at[t[0]]).cross(at[t[2]] - at[t[0]]);
  build::Measures measures(body);
  const std::vector<std::uint32_t> layer_of(at.size(), 0u);
  std::vector<char> follows(at.size(), 0);
  for (const FibreConstraint& c : build::fibre_constraints(scene, layer_of, 0.02, measures)) {
    const Vector3d flat =
        painted - painted.dot(normal[c.vertex]) / normal[c.vertex].squaredNorm() * normal[c.vertex];
    EXPECT_NEAR(std::abs(c.direction.dot(flat.normalized())), 1.0, 1e-12) << "vertex " << c.vertex;
    follows[c.vertex] = 1;
  }
  for (std::size_t i = 0; i < at.size(); ++i)
    EXPECT_EQ(follows[i] != 0, normal[i] != Vector3d::Zero()) << "vertex " << i;
}

TEST(FibreDirections, OfAModelComeFromTheField) {
  build::Report report;
  const model::Model model = build::build_model(boned_bar(), report);
  ASSERT_NO_THROW(model::check_model(model));
  EXPECT_GT(report.fibres.constraints, 300u);
  EXPECT_EQ(report.fibres.without, 0u);
  EXPECT_LT(report.fibres.bent_edges, report.fibres.edges / 100);  // at the corners of the ends
  std::size_t muscle = 0;
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    const Vector3d d(model.fibre[3 * i], model.fibre[3 * i + 1], model.fibre[3 * i + 2]);
    if (model.layer_of(i) == 1) {
      EXPECT_EQ(d, Vector3d(Vector3d::Zero()));  // bone has no fibre
      continue;
    }
    ++muscle;
    EXPECT_EQ(model.beta[i], 0.6f);
    EXPECT_NEAR(d.norm(), 1.0, 1e-6);
    // Along bone and skin, fibres follow x within a few degrees; on the end faces they cannot.
    const double x = model.rest_origin[0] + model.unit * double{model.rest[3 * i]};
    if (x > 0.03 && x < 0.37) {
      EXPECT_GT(std::abs(d[0]), 0.9);
    }
  }
  EXPECT_GT(muscle, 300u);
}

// Counted again from the model's edges and directions. As every layer has fibres here, these are all of the
// field's.
TEST(FibreDirections, AreCountedAsTheyAre) {
  scene::Scene scene = boned_bar();
  scene.layers.pop_back();
  scene.bones.clear();
  // The lines turn by half a turn around a bend, so somewhere two neighbours must have opposed directions.
  scene.fibres = {
      {"bend",
       {{0.35, 0.01, 0.04}, {0.12, 0.01, 0.04}, {0.1, 0.04, 0.04}, {0.12, 0.07, 0.04}, {0.35, 0.07, 0.04}},
       0.02}};
  build::Report report;
  const model::Model model = build::build_model(scene, report);
  std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (std::size_t t = 0; t < model.tetrahedron_count(); ++t)
    for (std::size_t a = 0; a < 4; ++a)
      for (std::size_t b = 0; b < 4; ++b)
        if (const std::uint32_t i = model.tetrahedron[4 * t + a], j = model.tetrahedron[4 * t + b]; i < j)
          edges.insert({i, j});
  std::uint32_t directed = 0, flipped = 0, bent = 0;
  for (const auto& [i, j] : edges) {
    const auto of = [&](std::uint32_t k) {
      return Vector3d(model.fibre[3 * k], model.fibre[3 * k + 1], model.fibre[3 * k + 2]);
    };
    if (of(i) == Vector3d::Zero() || of(j) == Vector3d::Zero()) continue;
    ++directed;
    flipped += of(i).dot(of(j)) < 0.0 ? 1u : 0u;
    bent += std::abs(of(i).dot(of(j))) < 0.5 ? 1u : 0u;
  }
  EXPECT_EQ(report.fibres.edges, directed);
  EXPECT_GT(flipped, 0u);
  EXPECT_EQ(report.fibres.flipped_edges, flipped);
  EXPECT_EQ(report.fibres.bent_edges, bent);
}

TEST(FibreDirections, NeedSomethingThatLeadsThem) {
  scene::Scene scene = boned_bar();
  scene.bones.clear();
  scene.layers.pop_back();
  expect_refusal([&] { build_quietly(scene); }, "draw [fibres.NAME]");
}

}  // namespace
}  // namespace fascicle::tests
