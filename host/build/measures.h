// The measures that define layers: how far each vertex of a body lies from the bones and from the skin, how
// much of the volume lies nearer to the bones, which joints move it and what is painted on it.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "host/build/body.h"

namespace fascicle::build {

struct NearestBone {
  std::uint32_t bone = 0;  // index into Body::bones
  double distance = 0.0;   // m
};

// Each measure is computed on first use. The body must outlive this object and must not change.
class Measures {
 public:
  explicit Measures(const Body& body);

  const Body& body() const { return body_; }

  // Whether a vertex is held by a rigid part, or most of its weights are on joints that are kinematic or
  // whose bones are farther away than the body is thick there. Heads, hands, feet and jaws have no bone
  // inside from which a distance could be measured, so they follow the skeleton.
  const std::vector<char>& follows_joints();

  // The nearest of each vertex's own bones: bones with an owner that has at least 2 % of the vertex's
  // weights, bones drawn in the scene, or all bones if there are none of these. Needs a bone.
  const std::vector<NearestBone>& nearest_bones();

  // Whether a skin's vertex follows its joints by its own weights, at a point where the body has that local
  // radius.
  bool follows(const SkinWeights& skin, std::size_t vertex, const Vector3d& point, double radius) const;

  // Half the body's thickness at each vertex, m (local_radius.h).
  const std::vector<double>& radii();

  // The distance from the boundary of the tetrahedra, m; 0 for a carrier's vertices.
  const std::vector<double>& skin_distances();

  // The distance to the nearest bone, m; 0 for a vertex that follows joints.
  const std::vector<double>& bone_distances();

  // Relative depth d_b / (d_b + d_s), from the distances to the bone and to the boundary of the tetrahedra: 0
  // at the bone, 1 at the skin. 0 for a vertex that follows joints.
  const std::vector<double>& depths();

  // The share of the volume that lies nearer to the bones than the vertex, including half of its own volume.
  // Vertices are ordered by depth, or by distance, and ties by the other of the two. Vertices that follow
  // joints do not count and get 0. Each of several characters has its own shares.
  const std::vector<double>& inner_shares(bool by_distance);

  // A painted value at each vertex, interpolated at its nearest place on the skin; for _LAYER, the value at
  // that place's nearest corner. `name` is the attribute's, followed by .r .g .b or .a (or .x .y .z .w) if it
  // has several components. Throws scene::SceneError, naming `key`, if the character has no such attribute.
  const std::vector<double>& painted(const std::string& name, const std::string& key,
                                     const std::string& source);

  // For each vertex, the entry of Body::parts at its nearest place on the skin. Needs parts.
  const std::vector<std::uint32_t>& nearest_parts();

  // The share of each vertex's weights on a set of joints: one flag per joint.
  std::vector<double> shares_of(const std::vector<char>& joints) const;

 private:
  const Body& body_;
  std::vector<char> follows_;
  std::vector<NearestBone> nearest_;
  std::vector<double> bone_distances_, skin_distances_, radii_, depths_;
  std::map<bool, std::vector<double>> inner_shares_;
  std::map<std::string, std::vector<double>> painted_;
  std::vector<std::uint32_t> parts_;
};

// Distance from a point to a segment, m.
double segment_distance(const Vector3d& point, const Vector3d& from, const Vector3d& to);

// The joints with these names, one flag per joint; with all their descendants if `and_below`. Throws
// scene::SceneError, naming `key`, for a name that no joint has.
std::vector<char> joints_named(const Body& body, const std::vector<std::string>& names, bool and_below,
                               const std::string& key, const std::string& source);

}  // namespace fascicle::build
