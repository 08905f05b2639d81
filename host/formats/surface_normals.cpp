#include "host/formats/surface_normals.h"

#include <array>
#include <cmath>
#include <map>
#include <utility>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "host/formats/surface.h"

namespace fascicle::formats {

namespace {

using Eigen::Vector3d;

// Cosine of one degree: exporters round the normals of a vertex differently on the two sides of a seam.
constexpr double same_normal = 0.99985;
// 1 plus the cosine: below this, directions are so nearly opposite that the shortest rotation is undefined.
constexpr double opposite = 1e-6;

Vector3d at(std::span<const float> values, std::size_t i) {
  return {double{values[3 * i]}, double{values[3 * i + 1]}, double{values[3 * i + 2]}};
}

// Rotates v by the shortest rotation from a to b, both unit vectors.
Vector3d rotated(const Vector3d& v, const Vector3d& a, const Vector3d& b) {
  const double cosine = a.dot(b);
  if (1.0 + cosine < opposite) {
    // Half a turn about any axis perpendicular to a.
    Eigen::Index least = 0;
    a.cwiseAbs().minCoeff(&least);
    const Vector3d across = a.cross(Vector3d::Unit(least)).normalized();
    return 2.0 * across.dot(v) * across - v;
  }
  const Vector3d axis = a.cross(b);
  return v + axis.cross(v) + axis.cross(axis.cross(v)) / (1.0 + cosine);
}

// The neighbourhood's rotation about its normal that remains after the shortest rotation: sums of the cosines
// and sines of the angles between edges, weighted by their lengths.
struct Twist {
  double cosine = 0.0, sine = 0.0;
};

}  // namespace

SurfaceNormals::SurfaceNormals(const model::Model& model, std::vector<float> own)
    : own_(std::move(own)), triangle_(model.surface_triangle) {
  std::vector<float> rest = embed(model, model.rest);
  struct Group {
    Vector3d normal;
    std::uint32_t number;
  };
  std::map<std::array<float, 3>, std::vector<Group>> places;
  for (std::size_t i = 0; 3 * i < rest.size(); ++i) {
    // Adding 0 makes -0 and 0 equal.
    const std::array<float, 3> place{rest[3 * i] + 0.0f, rest[3 * i + 1] + 0.0f, rest[3 * i + 2] + 0.0f};
    const Vector3d normal = own_.empty() ? Vector3d::Zero() : at(own_, i);
    std::vector<Group>& groups = places[place];
    const Group* found = nullptr;
    for (const Group& group : groups)
      if (found == nullptr && (group.normal == normal || group.normal.dot(normal) > same_normal))
        found = &group;
    if (found == nullptr) found = &groups.emplace_back(Group{normal, groups_++});
    group_.push_back(found->number);
  }
  if (own_.empty()) return;
  rest_ = std::move(rest);
  rest_normals_ = normals_of_groups(rest_);
}

std::vector<double> SurfaceNormals::normals_of_groups(std::span<const float> positions) const {
  std::vector<double> sums(std::size_t{3} * groups_, 0.0);
  for (std::size_t t = 0; t < triangle_.size(); t += 3) {
    const auto edge = [&](std::size_t k, std::size_t axis) {
      return double{positions[std::size_t{3} * triangle_[t + k] + axis]} -
             double{positions[std::size_t{3} * triangle_[t] + axis]};
    };
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::size_t y = (axis + 1) % 3, z = (axis + 2) % 3;
      const double cross = edge(1, y) * edge(2, z) - edge(1, z) * edge(2, y);
      for (std::size_t k = 0; k < 3; ++k) sums[std::size_t{3} * group_[triangle_[t + k]] + axis] += cross;
    }
  }
  for (std::size_t i = 0; i < sums.size(); i += 3) {
    double* sum = &sums[i];
    const double length = std::sqrt((sum[0] * sum[0] + sum[1] * sum[1]) + sum[2] * sum[2]);
    for (std::size_t axis = 0; axis < 3; ++axis)
      sum[axis] = length > 0.0 ? sum[axis] / length : (axis == 1 ? 1.0 : 0.0);
  }
  return sums;
}

std::vector<float> SurfaceNormals::smooth_of(std::span<const float> positions) const {
  const std::vector<double> of_groups = normals_of_groups(positions);
  std::vector<float> normals(positions.size());
  for (std::size_t i = 0; i < normals.size(); ++i)
    normals[i] = static_cast<float>(of_groups[std::size_t{3} * group_[i / 3] + i % 3]);
  return normals;
}

std::vector<float> SurfaceNormals::of(std::span<const float> positions) const {
  if (own_.empty()) return smooth_of(positions);
  const std::vector<double>& before = rest_normals_;
  const std::vector<double> now = normals_of_groups(positions);
  const auto of_group = [](const std::vector<double>& values, std::uint32_t g) {
    return Vector3d(&values[std::size_t{3} * g]);
  };
  std::vector<Twist> twists(groups_);
  for (std::size_t t = 0; t < triangle_.size(); t += 3)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t corner = triangle_[t + k];
      const Vector3d from = of_group(before, group_[corner]), to = of_group(now, group_[corner]);
      Twist& twist = twists[group_[corner]];
      for (std::size_t other = 1; other < 3; ++other) {
        const std::uint32_t end = triangle_[t + (k + other) % 3];
        const Vector3d edge = rotated(at(rest_, end) - at(rest_, corner), from, to);
        const Vector3d edge_now = at(positions, end) - at(positions, corner);
        twist.cosine += edge.dot(edge_now) - edge.dot(to) * edge_now.dot(to);
        twist.sine += to.dot(edge.cross(edge_now));
      }
    }
  std::vector<float> normals(positions.size());
  for (std::size_t i = 0; i < group_.size(); ++i) {
    const Vector3d to = of_group(now, group_[i]);
    Vector3d normal = at(own_, i);
    if (normal.isZero(0.0)) {
      normal = to;
    } else {
      normal = rotated(normal, of_group(before, group_[i]), to);
      const Twist& twist = twists[group_[i]];
      const double size = std::sqrt(twist.cosine * twist.cosine + twist.sine * twist.sine);
      if (size > 0.0) {
        const Vector3d along = to.dot(normal) * to, across = normal - along;
        normal = along + (twist.cosine * across + twist.sine * to.cross(across)) / size;
      }
      normal.normalize();
    }
    for (Eigen::Index axis = 0; axis < 3; ++axis)
      normals[3 * i + static_cast<std::size_t>(axis)] = static_cast<float>(normal[axis]);
  }
  return normals;
}

}  // namespace fascicle::formats
