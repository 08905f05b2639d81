// What layers are cut by: how far each vertex of a body lies from the bones and from the skin, how much of
// the volume lies nearer to the bones, which joints move it and what is painted on it.
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

// Each measure is computed on first use. The body must outlive it and stay as it is.
class Measures {
 public:
  explicit Measures(const Body& body);

  const Body& body() const { return body_; }

  // Whether a rigid part holds the vertex, or most of its weights are of joints that are kinematic or whose
  // bones lie further from it than the body is thick there: heads, hands, feet and jaws have no bone inside
  // that a distance could be measured from, and follow the skeleton.
  const std::vector<char>& follows_joints();

  // The nearest of each vertex's own bones: those that an owner with at least 2 % of the vertex's weights
  // moves, those the scene draws, or all where there is none. Needs a bone.
  const std::vector<NearestBone>& nearest_bones();

  // Whether a vertex of a skin follows them by its own weights, at a point where the body has that local
  // radius.
  bool follows(const SkinWeights& skin, std::size_t vertex, const Vector3d& point, double radius) const;

  // Half the body's thickness at each vertex, m (local_radius.h).
  const std::vector<double>& radii();

  // The distance from the boundary of the tetrahedra, m; 0 for a carrier's vertices.
  const std::vector<double>& skin_distances();

  // The distance of that bone, m; 0 for a vertex that follows joints.
  const std::vector<double>& bone_distances();

  // Relative depth d_b / (d_b + d_s) of the distances from the bone and from the boundary of the tetrahedra:
  // 0 at the bone, 1 at the skin. 0 for a vertex that follows joints.
  const std::vector<double>& depths();

  // The share of the volume that lies nearer to the bones than the vertex, half of its own included: ordered
  // by depth, or by distance, then by the other of the two. What follows joints is not counted, and 0. Of
  // several characters each has its own.
  const std::vector<double>& inner_shares(bool by_distance);

  // A painted value at each vertex, interpolated on the skin at the vertex's nearest place there; of _LAYER
  // the value of the corner that is nearest to that. `name` is the attribute's, with .r .g .b or .a (or .x .y
  // .z .w) where it has several numbers. Throws scene::SceneError, naming `key`, where the character has none
  // of that name.
  const std::vector<double>& painted(const std::string& name, const std::string& key,
                                     const std::string& source);

  // Of each vertex, the entry of Body::parts that its nearest place on the skin belongs to. Needs parts.
  const std::vector<std::uint32_t>& nearest_parts();

  // The share of each vertex's weights on joints of a set: one flag a joint.
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

// The joints of these names, one flag a joint; with all below them if `and_below`. Throws scene::SceneError,
// naming `key`, for a name that no joint has.
std::vector<char> joints_named(const Body& body, const std::vector<std::string>& names, bool and_below,
                               const std::string& key, const std::string& source);

}  // namespace fascicle::build
