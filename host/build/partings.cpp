#include "host/build/partings.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "host/build/surface_search.h"
#include "host/scene/pose.h"

namespace fascicle::build {

namespace {

using scene::Vector3d;

constexpr std::size_t most_of_clip = 16;
constexpr std::size_t most_of_all = 96;

}  // namespace

std::vector<std::vector<Eigen::Matrix4d>> poses_of_clips(const scene::Character& character, double scale) {
  std::vector<std::vector<Eigen::Matrix4d>> poses;
  if (character.clips.empty()) return poses;
  const std::size_t each = std::clamp<std::size_t>(most_of_all / character.clips.size(), 1, most_of_clip);
  for (const scene::Clip& clip : character.clips)
    for (std::size_t k = 0; k < each; ++k) {
      const double time =
          clip.duration * (2.0 * static_cast<double>(k) + 1.0) / (2.0 * static_cast<double>(each));
      poses.push_back(scene::pose_at(character, &clip, time));
      for (Eigen::Matrix4d& map : poses.back()) map.block<3, 1>(0, 3) *= scale;
    }
  return poses;
}

Partings::Partings(const scene::SurfaceMesh& skin, const SkinWeights& weights,
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

bool Partings::do_part(std::uint32_t a, std::uint32_t b) const {
  if (poses_.empty()) return false;
  const std::array<std::uint32_t, 2> triangle{a, b};
  const auto corner = [&](std::size_t side, std::size_t k) -> const Vector3d& {
    return skin_.vertices[skin_.triangles[triangle[side]][k]];
  };
  // The nearest places, as far as a corner or a middle of one of them is one of the two.
  std::array<std::array<double, 3>, 2> place{};
  double nearest = near_;
  bool is_near = false;
  for (std::size_t side = 0; side < 2; ++side) {
    const std::size_t other = 1 - side;
    for (std::size_t k = 0; k < 4; ++k) {
      std::array<double, 3> from{1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0};
      if (k < 3) from = {k == 0 ? 1.0 : 0.0, k == 1 ? 1.0 : 0.0, k == 2 ? 1.0 : 0.0};
      const Vector3d point =
          from[0] * corner(side, 0) + from[1] * corner(side, 1) + from[2] * corner(side, 2);
      const SurfacePoint to =
          nearest_on_triangle(point, corner(other, 0), corner(other, 1), corner(other, 2));
      if (to.distance > nearest) continue;
      nearest = to.distance;
      is_near = true;
      place[side] = from;
      place[other] = to.weights;
    }
  }
  if (!is_near) return false;

  std::array<std::vector<Share>, 2> shares;
  std::array<Vector3d, 2> point;
  for (std::size_t side = 0; side < 2; ++side) {
    shares[side] = shares_at(triangle[side], place[side]);
    point[side] = Vector3d::Zero();
    for (std::size_t k = 0; k < 3; ++k) point[side] += place[side][k] * corner(side, k);
  }
  constexpr double alike = 1e-3;
  if (shares[0].size() == shares[1].size() &&
      std::equal(shares[0].begin(), shares[0].end(), shares[1].begin(), [](const Share& i, const Share& j) {
        return i.joint == j.joint && std::abs(i.weight - j.weight) < alike;
      }))
    return false;
  return std::any_of(poses_.begin(), poses_.end(), [&](const std::vector<Eigen::Matrix4d>& pose) {
    std::array<Vector3d, 2> moved{Vector3d::Zero(), Vector3d::Zero()};
    for (std::size_t side = 0; side < 2; ++side)
      for (const Share& share : shares[side])
        moved[side] += share.weight * (pose[share.joint].block<3, 3>(0, 0) * point[side] +
                                       pose[share.joint].block<3, 1>(0, 3));
    return (moved[0] - moved[1]).norm() - nearest > far_;
  });
}

}  // namespace fascicle::build
