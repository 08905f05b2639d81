// Generated surfaces of the kinds found in artists' meshes.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include <Eigen/Geometry>

#include "host/scene/scene.h"
#include "tests/build/surfaces.h"

namespace fascicle::tests {

inline void append(mesh::SurfaceMesh& mesh, const mesh::SurfaceMesh& other,
                   const scene::Vector3d& shift = scene::Vector3d::Zero()) {
  const auto offset = static_cast<std::uint32_t>(mesh.vertices.size());
  for (const scene::Vector3d& p : other.vertices) mesh.vertices.push_back(p + shift);
  for (const auto& t : other.triangles)
    mesh.triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
}

// A tube of `radius` along a line of points, with `around` vertices per ring and a point at each closed end.
// Faces outward. Ring k is vertices [k x around, (k + 1) x around).
inline mesh::SurfaceMesh tube(const std::vector<scene::Vector3d>& line, double radius, std::uint32_t around) {
  mesh::SurfaceMesh mesh;
  const auto rings = static_cast<std::uint32_t>(line.size());
  // Lines are in the x-y plane, so z is perpendicular to all of them.
  const scene::Vector3d across(0, 0, 1);
  const auto along = [&](std::uint32_t k) {
    return (line[std::min(k + 1, rings - 1)] - line[k == 0 ? 0 : k - 1]).normalized();
  };
  for (std::uint32_t k = 0; k < rings; ++k) {
    const scene::Vector3d side = across.cross(along(k));
    for (std::uint32_t i = 0; i < around; ++i) {
      const double angle = 2.0 * 3.14159265358979 * i / around;
      mesh.vertices.push_back(line[k] + radius * (std::cos(angle) * across + std::sin(angle) * side));
    }
  }
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.push_back(line.front() - 0.5 * radius * along(0));
  mesh.vertices.push_back(line.back() + 0.5 * radius * along(rings - 1));
  for (std::uint32_t i = 0; i < around; ++i) {
    const std::uint32_t next = (i + 1) % around, last = (rings - 1) * around;
    for (std::uint32_t k = 0; k + 1 < rings; ++k) {
      const std::uint32_t a = k * around + i, b = k * around + next;
      mesh.triangles.push_back({a, b, b + around});
      mesh.triangles.push_back({a, b + around, a + around});
    }
    mesh.triangles.push_back({first, next, i});
    mesh.triangles.push_back({first + 1, last + i, last + next});
  }
  return mesh;
}

// A ball made of rings and sectors.
inline mesh::SurfaceMesh ball(double radius, std::uint32_t around) {
  mesh::SurfaceMesh mesh;
  const std::uint32_t rings = around / 2;
  for (std::uint32_t k = 1; k < rings; ++k) {
    const double polar = 3.14159265358979 * k / rings;
    for (std::uint32_t i = 0; i < around; ++i) {
      const double angle = 2.0 * 3.14159265358979 * i / around;
      mesh.vertices.push_back(radius * scene::Vector3d(std::sin(polar) * std::cos(angle),
                                                       std::sin(polar) * std::sin(angle), std::cos(polar)));
    }
  }
  const auto top = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.emplace_back(0, 0, radius);
  mesh.vertices.emplace_back(0, 0, -radius);
  for (std::uint32_t i = 0; i < around; ++i) {
    const std::uint32_t next = (i + 1) % around, last = (rings - 2) * around;
    mesh.triangles.push_back({top, i, next});
    mesh.triangles.push_back({top + 1, last + next, last + i});
    for (std::uint32_t k = 0; k + 2 < rings; ++k) {
      const std::uint32_t a = k * around + i, b = k * around + next;
      mesh.triangles.push_back({a, a + around, b + around});
      mesh.triangles.push_back({a, b + around, b});
    }
  }
  return mesh;
}

// Two legs and the hips above them: one tube bent like a hairpin. Legs are 0.7 m long with a radius of 0.1 m,
// `gap` apart (m; negative: they cross). Joint 0 moves the left leg, 1 the right one, 2 the bend and the
// upper 0.2 m of both, without blending. So along the skin, the legs' own parts are at least 0.4 m apart.
inline rig::Character make_legs(double gap) {
  constexpr std::uint32_t around = 24;
  constexpr double radius = 0.1, length = 0.7, hips = 0.2, step = 0.02;
  const double half = radius + gap / 2.0;
  std::vector<scene::Vector3d> line;
  for (double y = -length; y < -0.5 * step; y += step) line.emplace_back(-half, y, 0);
  const std::size_t bend = line.size();
  constexpr int steps = 24;
  for (int k = 0; k <= steps; ++k) {
    const double angle = 3.14159265358979 * k / steps;
    line.emplace_back(-half * std::cos(angle), half * std::sin(angle), 0);
  }
  for (std::size_t k = bend; k-- > 0;) line.emplace_back(half, line[k].y(), 0);

  rig::Character legs;
  legs.surface = tube(line, radius, around);
  for (const scene::Vector3d& p : legs.surface.vertices) {
    const std::uint32_t joint = p.y() > -hips ? 2 : p.x() < 0.0 ? 0 : 1;
    legs.joints.push_back({joint, 0, 0, 0, 0, 0, 0, 0});
    legs.weights.push_back({1, 0, 0, 0, 0, 0, 0, 0});
  }
  // If legs cross, the ring tells which leg a vertex belongs to.
  for (std::uint32_t v = 0; v < line.size() * around; ++v)
    if (legs.joints[v][0] != 2) legs.joints[v][0] = v < bend * around ? 0 : 1;
  legs.skeleton = {joint_at("left", -1, {-half, -hips, 0}), joint_at("right", -1, {half, -hips, 0}),
                   joint_at("hips", -1, {0, half, 0})};
  return legs;
}

}  // namespace fascicle::tests
