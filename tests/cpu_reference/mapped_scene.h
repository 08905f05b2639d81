// A body in motion and its images: rotated, mirrored, renumbered. The Oracle's tests in double and the CPU
// solver's in float check on the same bodies that these do not change a trajectory.
#pragma once

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <Eigen/LU>

#include "tests/cpu_reference/oracle_run.h"
#include "tests/support/test_models.h"

namespace fascicle::tests {

// A body and its motion, in numbers that stay exact in float under the tests' maps: the rotation below has
// entries in 25ths, and all lengths are multiples of 25/2^k.
struct Scene {
  Mesh mesh;
  Points velocities;
  std::vector<float> alpha, beta;
  Points fibres;
  std::vector<bool> pinned;
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
};

// The rotation by the quaternion (4, 2, 2, 1)/5.
inline Eigen::Matrix3d exact_rotation() {
  Eigen::Matrix3d R;
  R << 15, 0, 20, 16, 15, -12, -12, 20, 9;
  return R / 25.0;
}

inline Scene make_scene(unsigned seed, bool pinned) {
  constexpr double grid = 25.0 / 4096.0;
  std::mt19937 random(seed);
  std::uniform_int_distribution<int> small(-20, 20);
  std::uniform_real_distribution<float> unit(0.05f, 1.0f);
  Scene scene;
  scene.mesh = jittered(kuhn_bar(3, 2, 2, 16 * grid), grid, 1, seed);
  for (const Eigen::Vector3d& p : scene.mesh.points) {
    scene.velocities.push_back(grid * 2 * Eigen::Vector3d(small(random), small(random), small(random)));
    scene.alpha.push_back(unit(random));
    scene.beta.push_back(unit(random));
    // Not normalised, so that rotation is exact; the Oracle uses only the direction.
    scene.fibres.push_back(25.0 * Eigen::Vector3d(1 + std::abs(small(random)), small(random), small(random)));
    scene.pinned.push_back(pinned && p.x() < 4 * grid);
  }
  scene.gravity = pinned ? Eigen::Vector3d(25.0 / 16, -6.25, 25.0 / 8) : Eigen::Vector3d::Zero();
  return scene;
}

inline Scene mapped(const Scene& scene, const Eigen::Matrix3d& R, const Eigen::Vector3d& t) {
  Scene copy = scene;
  for (Eigen::Vector3d& p : copy.mesh.points) p = R * p;
  for (Eigen::Vector3d& v : copy.velocities) v = R * v;
  for (Eigen::Vector3d& d : copy.fibres) d = R * d;
  copy.gravity = R * scene.gravity;
  copy.translation = t;
  if (R.determinant() < 0.0)
    for (auto& tetrahedron : copy.mesh.tetrahedra) std::swap(tetrahedron[2], tetrahedron[3]);
  return copy;
}

// The same body with vertex i renumbered to new_number[i].
inline Scene renumbered(const Scene& scene, const std::vector<std::uint32_t>& new_number) {
  Scene renamed = scene;
  for (std::size_t i = 0; i < scene.mesh.points.size(); ++i) {
    const std::uint32_t to = new_number[i];
    renamed.mesh.points[to] = scene.mesh.points[i];
    renamed.velocities[to] = scene.velocities[i];
    renamed.alpha[to] = scene.alpha[i];
    renamed.beta[to] = scene.beta[i];
    renamed.fibres[to] = scene.fibres[i];
    renamed.pinned[to] = scene.pinned[i];
  }
  for (auto& tetrahedron : renamed.mesh.tetrahedra)
    for (std::uint32_t& i : tetrahedron) i = new_number[i];
  return renamed;
}

inline std::vector<std::uint32_t> shuffled_numbers(std::size_t count, unsigned seed) {
  std::vector<std::uint32_t> numbers(count);
  std::iota(numbers.begin(), numbers.end(), 0u);
  std::shuffle(numbers.begin(), numbers.end(), std::mt19937(seed));
  return numbers;
}

// Converts a trajectory of the renumbered body to the original numbers.
inline std::vector<Points> in_old_numbers(const std::vector<Points>& trajectory,
                                          const std::vector<std::uint32_t>& new_number) {
  std::vector<Points> all;
  for (const Points& points : trajectory) {
    Points& old = all.emplace_back();
    for (const std::uint32_t to : new_number) old.push_back(points[to]);
  }
  return all;
}

inline model::Model model_of(const Scene& scene, bool momentum_scaled = true, double damping = 0.0) {
  BodyOptions options;
  options.momentum_scaled = momentum_scaled;
  options.damping = damping;
  model::Model model = make_model(scene.mesh, options);
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    model.alpha[i] = scene.alpha[i];
    model.beta[i] = scene.beta[i];
    for (int k = 0; k < 3; ++k) model.fibre[3 * i + std::size_t(k)] = float(scene.fibres[i][k]);
    if (scene.pinned[i]) make_kinematic(model, i);
  }
  fill_weights(model);
  return model;
}

}  // namespace fascicle::tests
