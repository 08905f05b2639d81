#include "host/build/joint_skin.h"

#include <algorithm>
#include <map>

#include <Eigen/Geometry>

namespace fascicle::build {

namespace {

// Skin is detached from its ancestors if it has less than this share in common with them, relative to an
// unrelated joint.
constexpr double little_above = 0.1;
// Joints that move less than this share of the skin by themselves are controls; skin in common with them does
// not count.
constexpr double least_share_above = 5e-3;
// A joint with less than this share of the largest overlap is only close by.
constexpr double least_of_most = 0.2;

using JointShares = std::vector<std::pair<std::uint32_t, double>>;

// Sums up weights by joint, optionally also for all ancestors.
class Adder {
 public:
  explicit Adder(const rig::Character& character)
      : character_(character), weight_(character.skeleton.size(), 0.0) {}

  void add_vertex(std::size_t vertex, double factor, bool to_those_above) {
    double all = 0.0;
    for (const double w : character_.weights[vertex]) all += std::max(w, 0.0);
    for (std::size_t k = 0; k < 8; ++k) {
      const double w = character_.weights[vertex][k];
      if (!(w > 0.0)) continue;
      auto j = static_cast<std::int32_t>(character_.joints[vertex][k]);
      do {
        const auto joint = static_cast<std::uint32_t>(j);
        if (weight_[joint] == 0.0) touched_.push_back(joint);
        weight_[joint] += factor * w / all;
        j = character_.skeleton[joint].parent;
      } while (to_those_above && j >= 0);
    }
  }

  JointShares take() {
    std::sort(touched_.begin(), touched_.end());
    JointShares parts;
    for (const std::uint32_t joint : touched_) {
      parts.emplace_back(joint, weight_[joint]);
      weight_[joint] = 0.0;
    }
    touched_.clear();
    return parts;
  }

 private:
  const rig::Character& character_;
  std::vector<double> weight_;
  std::vector<std::uint32_t> touched_;
};

bool is_above(const std::vector<rig::Joint>& skeleton, std::uint32_t above, std::uint32_t joint) {
  for (auto j = static_cast<std::int32_t>(joint); j >= 0; j = skeleton[static_cast<std::size_t>(j)].parent)
    if (j == static_cast<std::int32_t>(above)) return true;
  return false;
}

}  // namespace

SkinOfJoints skin_of_joints(const mesh::SurfaceMesh& surface, const rig::Character& character) {
  SkinOfJoints skin;
  const std::size_t vertices = surface.vertices.size(), joints = character.skeleton.size();
  skin.vertex_area.assign(vertices, 0.0);
  std::vector<Vector3d> normals(vertices, Vector3d::Zero());
  for (const auto& t : surface.triangles) {
    const Vector3d& a = surface.vertices[t[0]];
    const Vector3d normal = (surface.vertices[t[1]] - a).cross(surface.vertices[t[2]] - a) / 6.0;
    for (const std::uint32_t corner : t) {
      skin.vertex_area[corner] += normal.norm();
      normals[corner] += normal;
    }
  }
  skin.own.resize(joints);
  skin.below.resize(joints);
  Adder adder(character);
  for (std::size_t v = 0; v < vertices; ++v) {
    const double area = skin.vertex_area[v];
    skin.whole += area;
    const auto add = [&](const JointShares& parts, std::vector<SkinPiece>& pieces) {
      for (const auto& [joint, w] : parts) {
        pieces[joint].area += w * area;
        pieces[joint].normal += w * normals[v];
        pieces[joint].middle += w * area * surface.vertices[v];
      }
    };
    adder.add_vertex(v, 1.0, false);
    add(adder.take(), skin.own);
    adder.add_vertex(v, 1.0, true);
    skin.with_below.push_back(adder.take());
    add(skin.with_below.back(), skin.below);
  }
  for (auto* pieces : {&skin.own, &skin.below})
    for (SkinPiece& piece : *pieces)
      if (piece.area > 0.0) piece.middle /= piece.area;
  return skin;
}

std::vector<Meeting> meetings_of(const mesh::SurfaceMesh& surface, const rig::Character& character) {
  struct InCommon {
    double area = 0.0;
    Vector3d middle = Vector3d::Zero();
  };
  const std::vector<rig::Joint>& skeleton = character.skeleton;
  std::map<std::pair<std::uint32_t, std::uint32_t>, InCommon> common;  // of (whose skin with below, another)
  std::vector<double> own_area(skeleton.size(), 0.0);
  double whole = 0.0;
  Adder adder(character);
  for (const auto& t : surface.triangles) {
    for (const std::uint32_t corner : t) adder.add_vertex(corner, 1.0 / 3.0, false);
    const JointShares own = adder.take();
    const Vector3d& a = surface.vertices[t[0]];
    const Vector3d& b = surface.vertices[t[1]];
    const Vector3d& c = surface.vertices[t[2]];
    const double area = (b - a).cross(c - a).norm() / 2.0;
    whole += area;
    for (const auto& [joint, w] : own) own_area[joint] += w * area;
    if (own.size() < 2) continue;
    for (const std::uint32_t corner : t) adder.add_vertex(corner, 1.0 / 3.0, true);
    for (const auto& [joint, w] : adder.take())
      for (const auto& [other, share] : own) {
        InCommon& sum = common[{joint, other}];
        sum.area += area * std::min(w, share);
        sum.middle += area * std::min(w, share) * (a + b + c) / 3.0;
      }
  }
  std::vector<Meeting> meetings;
  for (auto entry = common.begin(); entry != common.end();) {
    const std::uint32_t joint = entry->first.first;
    double above = 0.0, most = 0.0;
    std::vector<Meeting> found;
    for (; entry != common.end() && entry->first.first == joint; ++entry) {
      const auto& [area, middle] = entry->second;
      const std::uint32_t other = entry->first.second;
      if (!(area > 0.0) || is_above(skeleton, joint, other)) continue;  // itself, or below
      if (is_above(skeleton, other, joint)) {
        if (own_area[other] >= least_share_above * whole) above += area;
      } else {
        found.push_back({other, joint, area, middle / area});
        most = std::max(most, area);
      }
    }
    if (above >= little_above * most) continue;
    std::erase_if(found, [&](const Meeting& meeting) { return meeting.area < least_of_most * most; });
    std::stable_sort(found.begin(), found.end(),
                     [](const Meeting& x, const Meeting& y) { return x.area > y.area; });
    meetings.insert(meetings.end(), found.begin(), found.end());
  }
  return meetings;
}

}  // namespace fascicle::build
