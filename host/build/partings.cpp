#include "host/build/partings.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "host/build/surface_search.h"
#include "host/rig/pose.h"
#include "host/rig/smooth_clip.h"

namespace fascicle::build {

namespace {

using scene::Vector3d;

constexpr std::size_t most_of_clip = 16;
constexpr std::size_t most_of_all = 96;

Vector3d point_at(const mesh::SurfaceMesh& skin, std::uint32_t triangle,
                  const std::array<double, 3>& weights) {
  const auto& t = skin.triangles[triangle];
  return weights[0] * skin.vertices[t[0]] + weights[1] * skin.vertices[t[1]] +
         weights[2] * skin.vertices[t[2]];
}

// The parameters, 0 to 1, of the nearest points of two segments; any such pair if the segments are parallel.
std::pair<double, double> nearest_of_segments(const Vector3d& a, const Vector3d& b, const Vector3d& c,
                                              const Vector3d& d) {
  const auto along = [](const Vector3d& point, const Vector3d& from, const Vector3d& to) {
    const double length2 = (to - from).squaredNorm();
    return length2 > 0.0 ? std::clamp((point - from).dot(to - from) / length2, 0.0, 1.0) : 0.0;
  };
  const Vector3d u = b - a, v = d - c, w = a - c;
  const double uu = u.dot(u), uv = u.dot(v), vv = v.dot(v), denominator = uu * vv - uv * uv;
  double s = denominator > 0.0 ? std::clamp((uv * v.dot(w) - vv * u.dot(w)) / denominator, 0.0, 1.0) : 0.5;
  const double t = along(a + s * u, c, d);
  s = along(c + t * v, a, b);
  return {s, t};
}

}  // namespace

std::vector<std::vector<Eigen::Matrix4d>> poses_of_clips(const rig::Character& character, double scale) {
  std::vector<std::vector<Eigen::Matrix4d>> poses;
  if (character.clips.empty()) return poses;
  const std::size_t each = std::clamp<std::size_t>(most_of_all / character.clips.size(), 1, most_of_clip);
  const std::size_t count = std::min(character.clips.size(), most_of_all);
  for (std::size_t c = 0; c < count; ++c) {
    const rig::Clip& clip = character.clips[c * character.clips.size() / count];
    const rig::Clip straight = rig::straight_clip(clip);
    for (std::size_t k = 0; k < each; ++k) {
      const double time =
          clip.duration * (2.0 * static_cast<double>(k) + 1.0) / (2.0 * static_cast<double>(each));
      poses.push_back(rig::pose_at(character, &straight, time));
      for (Eigen::Matrix4d& map : poses.back()) map.block<3, 1>(0, 3) *= scale;
    }
  }
  return poses;
}

Partings::Partings(const mesh::SurfaceMesh& skin, const SkinWeights& weights,
                   std::span<const std::vector<Eigen::Matrix4d>> poses, double near, double far)
    : skin_(skin), weights_(weights), poses_(poses), near_(near), far_(far) {}

std::vector<Partings::Share> Partings::shares_at(std::uint32_t triangle,
                                                 const std::array<double, 3>& weights) const {
  std::map<std::uint32_t, double> sum;
  for (std::size_t c = 0; c < 3; ++c) {
    const std::uint32_t v = skin_.triangles[triangle][c];
    for (std::uint32_t k = weights_.offset[v]; k < weights_.offset[v + 1]; ++k)
      sum[weights_.joint[k]] += weights[c] * weights_.weight[k];
  }
  std::vector<Share> shares;
  for (const auto& [joint, weight] : sum) shares.push_back({joint, weight});
  return shares;
}

bool Partings::have_parted(std::uint32_t a, const std::array<double, 3>& at_a, std::uint32_t b,
                           const std::array<double, 3>& at_b) const {
  const std::array<std::vector<Share>, 2> shares{shares_at(a, at_a), shares_at(b, at_b)};
  const std::array<Vector3d, 2> point{point_at(skin_, a, at_a), point_at(skin_, b, at_b)};
  const double before = (point[0] - point[1]).norm();
  constexpr double alike = 1e-3;
  if (std::equal(shares[0].begin(), shares[0].end(), shares[1].begin(), shares[1].end(),
                 [](const Share& i, const Share& j) {
                   return i.joint == j.joint && std::abs(i.weight - j.weight) < alike;
                 }))
    return false;
  return std::any_of(poses_.begin(), poses_.end(), [&](const std::vector<Eigen::Matrix4d>& pose) {
    std::array<Vector3d, 2> moved{Vector3d::Zero(), Vector3d::Zero()};
    for (std::size_t side = 0; side < 2; ++side)
      for (const Share& share : shares[side])
        moved[side] += share.weight * (pose[share.joint].block<3, 3>(0, 0) * point[side] +
                                       pose[share.joint].block<3, 1>(0, 3));
    return (moved[0] - moved[1]).norm() - before > far_;
  });
}

// The nearest places of two triangles are a corner of one and a place of the other, or lie on a side of each.
// All nearby pairs of this kind are tested: long triangles may be nearest where they do not part.
bool Partings::do_part(std::uint32_t a, std::uint32_t b) const {
  if (poses_.empty()) return false;
  const auto corner = [&](std::uint32_t triangle, std::size_t k) -> const Vector3d& {
    return skin_.vertices[skin_.triangles[triangle][k]];
  };
  const auto parts_from_corner = [&](std::uint32_t i, std::uint32_t j) {
    for (std::size_t k = 0; k < 3; ++k) {
      const SurfacePoint to = nearest_on_triangle(corner(i, k), corner(j, 0), corner(j, 1), corner(j, 2));
      std::array<double, 3> from{};
      from[k] = 1.0;
      if (to.distance <= near_ && have_parted(i, from, j, to.weights)) return true;
    }
    return false;
  };
  if (parts_from_corner(a, b) || parts_from_corner(b, a)) return true;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) {
      const auto [at_i, at_j] =
          nearest_of_segments(corner(a, i), corner(a, (i + 1) % 3), corner(b, j), corner(b, (j + 1) % 3));
      std::array<double, 3> at_a{}, at_b{};
      at_a[i] = 1.0 - at_i;
      at_a[(i + 1) % 3] = at_i;
      at_b[j] = 1.0 - at_j;
      at_b[(j + 1) % 3] = at_j;
      const double distance = (point_at(skin_, a, at_a) - point_at(skin_, b, at_b)).norm();
      if (distance <= near_ && have_parted(a, at_a, b, at_b)) return true;
    }
  return false;
}

}  // namespace fascicle::build
