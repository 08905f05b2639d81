// Harmonic extension, compared with a dense solve that assembles the same problem differently.
#include "host/build/harmonic.h"

#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include "host/base/parallel.h"
#include "host/build/bar.h"
#include "host/build/boundary.h"

namespace fascicle::tests {
namespace {

using build::VertexValue;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using scene::Vector3d;

// Gradients of the four hat functions from the inverse of the corner matrix, and the volume from its
// determinant; the library uses face normals.
MatrixXd dense_matrix(const mesh::TetMesh& mesh) {
  const auto count = static_cast<Eigen::Index>(mesh.vertices.size());
  MatrixXd matrix = MatrixXd::Zero(count, count);
  for (const auto& t : mesh.tetrahedra) {
    Eigen::Matrix4d corners;
    for (int k = 0; k < 4; ++k)
      corners.row(k) << 1.0, mesh.vertices[t[static_cast<std::size_t>(k)]].transpose();
    const Eigen::Matrix<double, 3, 4> gradient = corners.inverse().bottomRows<3>();
    const double volume = std::abs(corners.determinant()) / 6.0;
    for (int a = 0; a < 4; ++a)
      for (int b = 0; b < 4; ++b)
        matrix(t[static_cast<std::size_t>(a)], t[static_cast<std::size_t>(b)]) +=
            volume * gradient.col(a).dot(gradient.col(b));
  }
  return matrix;
}

std::vector<char> on_boundary(const mesh::TetMesh& mesh) {
  std::vector<char> flag(mesh.vertices.size(), 0);
  for (const auto& t : build::boundary_triangles(mesh, "test"))
    for (const std::uint32_t corner : t) flag[corner] = 1;
  return flag;
}

VectorXd dense_solution(const mesh::TetMesh& mesh, const std::vector<char>& given, const VectorXd& values) {
  const MatrixXd matrix = dense_matrix(mesh);
  std::vector<Eigen::Index> inner, outer;
  for (std::size_t v = 0; v < given.size(); ++v)
    (given[v] ? outer : inner).push_back(static_cast<Eigen::Index>(v));
  VectorXd result = values;
  const VectorXd solved =
      MatrixXd(matrix(inner, inner)).ldlt().solve(-(matrix(inner, outer) * VectorXd(values(outer))));
  result(inner) = solved;
  return result;
}

// A long bar, so that values at one end do not reach the other.
const scene::Bar long_bar{.size = {2.0, 0.2, 0.2}, .vertices = {51, 6, 6}, .jitter = 0.25};

TEST(Harmonic, MatrixIsThatOfTheHatFunctions) {
  const mesh::TetMesh mesh = build::make_bar({.vertices = {5, 4, 4}, .jitter = 0.2}, "test");
  const build::LaplaceMatrix matrix = build::laplace_matrix(mesh);
  const MatrixXd dense = dense_matrix(mesh);
  for (std::uint32_t i = 0; i < mesh.vertices.size(); ++i) {
    // Both sum the same few products; entries are about 0.1.
    EXPECT_NEAR(matrix.diagonal[i], dense(i, i), 1e-14);
    for (std::uint32_t k = matrix.rings.offset[i]; k < matrix.rings.offset[i + 1]; ++k)
      EXPECT_NEAR(matrix.coupling[k], dense(i, matrix.rings.neighbour[k]), 1e-14);
  }
}

TEST(Harmonic, IsTheDenseSolution) {
  const mesh::TetMesh mesh = build::make_bar(long_bar, "test");
  const std::vector<char> given = on_boundary(mesh);
  const build::LaplaceMatrix matrix = build::laplace_matrix(mesh);
  build::HarmonicExtension extension(matrix, given);
  // One end, a ring in the middle, and everything except one end: local, local on two sides, and wide.
  const std::vector<std::pair<double, double>> bands{{0.0, 0.1}, {0.9, 1.1}, {0.3, 2.0}};
  for (const auto& [low, high] : bands) {
    VectorXd values = VectorXd::Zero(static_cast<Eigen::Index>(mesh.vertices.size()));
    std::vector<VertexValue> list;
    for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v) {
      if (!given[v] || mesh.vertices[v][0] < low || mesh.vertices[v][0] > high) continue;
      values[v] = 0.25 + mesh.vertices[v][1] + 2.0 * mesh.vertices[v][2];
      list.push_back({v, values[v]});
    }
    const VectorXd dense = dense_solution(mesh, given, values);
    const auto found = extension.extend(list);
    ASSERT_TRUE(found);
    std::vector<char> reached(mesh.vertices.size(), 0);
    for (const VertexValue& v : *found) {
      EXPECT_FALSE(given[v.vertex]);
      reached[v.vertex] = 1;
      // The omitted part is below `negligible` all along its rim.
      EXPECT_NEAR(v.value, dense[v.vertex], 2.0 * build::HarmonicExtension::negligible);
    }
    std::size_t left_out = 0;
    for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v) {
      if (given[v] || reached[v]) continue;
      ++left_out;
      EXPECT_NEAR(dense[v], 0.0, 2.0 * build::HarmonicExtension::negligible);
    }
    // Local solves are the point: a third of the bar gets no value from its end.
    if (high < 1.0) {
      EXPECT_GT(left_out, found->size() / 3);
    }
  }
}

TEST(Harmonic, AFieldThatReachesEverythingIsSolvedTightly) {
  const mesh::TetMesh mesh =
      build::make_bar({.size = {1, 1, 1}, .vertices = {7, 7, 7}, .jitter = 0.3}, "test");
  const std::vector<char> given = on_boundary(mesh);
  VectorXd values = VectorXd::Zero(static_cast<Eigen::Index>(mesh.vertices.size()));
  std::vector<VertexValue> list;
  for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v)
    if (given[v]) list.push_back({v, values[v] = mesh.vertices[v].squaredNorm()});
  const build::LaplaceMatrix matrix = build::laplace_matrix(mesh);
  const auto found = build::HarmonicExtension(matrix, given).extend(list);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->size() + list.size(), mesh.vertices.size());
  const VectorXd dense = dense_solution(mesh, given, values);
  // 1e-8 of the right-hand side, times the condition number of a mesh with 7 vertices a side, about 10.
  for (const VertexValue& v : *found) EXPECT_NEAR(v.value, dense[v.vertex], 1e-6);
}

TEST(Harmonic, ForgetsTheSolveBefore) {
  const mesh::TetMesh mesh = build::make_bar(long_bar, "test");
  const std::vector<char> given = on_boundary(mesh);
  const build::LaplaceMatrix matrix = build::laplace_matrix(mesh);
  const std::vector<VertexValue> first{{0, 1.0}, {1, 0.5}}, second{{0, 0.25}};
  ASSERT_TRUE(given[0] && given[1]);
  build::HarmonicExtension used(matrix, given), fresh(matrix, given);
  used.extend(first);
  const auto again = used.extend(second), alone = fresh.extend(second);
  ASSERT_TRUE(again && alone);
  ASSERT_EQ(again->size(), alone->size());
  for (std::size_t k = 0; k < again->size(); ++k) {
    EXPECT_EQ((*again)[k].vertex, (*alone)[k].vertex);
    EXPECT_EQ((*again)[k].value, (*alone)[k].value);
  }
}

TEST(Harmonic, ReachesNothingWhereAllIsGiven) {
  const mesh::TetMesh mesh = build::make_bar({.vertices = {3, 2, 2}}, "test");
  const std::vector<char> given(mesh.vertices.size(), 1);
  const build::LaplaceMatrix matrix = build::laplace_matrix(mesh);
  const std::vector<VertexValue> all{{0, 1.0}};
  const auto found = build::HarmonicExtension(matrix, given).extend(all);
  ASSERT_TRUE(found);
  EXPECT_TRUE(found->empty());
}

TEST(Parallel, DoesEveryPieceOnceAndPassesExceptionsOn) {
  for (const std::size_t threads : {1u, 2u, 7u}) {
    std::vector<int> done(100, 0);
    base::for_each_in_parallel(done.size(), threads, [&](std::size_t piece, std::size_t worker) {
      EXPECT_LT(worker, threads);
      ++done[piece];
    });
    EXPECT_EQ(done, std::vector<int>(100, 1));
    EXPECT_THROW(base::for_each_in_parallel(100, threads,
                                            [](std::size_t piece, std::size_t) {
                                              if (piece == 40) throw std::runtime_error("piece 40");
                                            }),
                 std::runtime_error);
  }
  base::for_each_in_parallel(0, 4, [](std::size_t, std::size_t) { FAIL(); });
}

}  // namespace
}  // namespace fascicle::tests
