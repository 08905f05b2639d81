#include "host/build/measures.h"

#include <algorithm>
#include <array>
#include <limits>
#include <numeric>
#include <tuple>

#include "host/build/boundary.h"
#include "host/build/local_radius.h"
#include "host/build/mass.h"
#include "host/build/message.h"
#include "host/build/surface_search.h"

namespace fascicle::build {

namespace {

constexpr double least_own_share = 0.02;
constexpr std::array<std::int32_t, 3> no_owners{-1, -1, -1};
// A vertex with this share of its weight on joints that are kinematic, or whose bones are far away, is part
// of a head, a hand, a foot or a jaw.
constexpr double following_share = 0.5;
// Flesh lies within one local radius of a bone in the middle of a limb, and within two of a bone on the far
// side, as a belly does of the spine. Anything farther away (a jaw, a hand beyond its last joint) has no bone
// in it.
constexpr double furthest_in_radii = 2.0;

// The share of a vertex's weights on joints whose bone is `joint`.
double share_of(const Body& body, std::size_t vertex, std::int32_t joint) {
  double share = 0.0;
  for (std::uint32_t k = body.skin.offset[vertex]; k < body.skin.offset[vertex + 1]; ++k) {
    const std::uint32_t follows = body.skin.joint[k];
    const auto bone = body.joints.empty() ? static_cast<std::int32_t>(follows) : body.joints[follows].bone;
    if (bone == joint) share += body.skin.weight[k];
  }
  return share;
}

// A bone drawn in the scene has no owner and belongs to all vertices.
bool is_own_bone(const Body& body, std::size_t vertex, const Bone& bone) {
  if (body.skin.offset.empty() || bone.owners == no_owners) return true;
  return std::any_of(bone.owners.begin(), bone.owners.end(), [&](std::int32_t owner) {
    return owner >= 0 && share_of(body, vertex, owner) >= least_own_share;
  });
}

NearestBone nearest_bone(const Body& body, std::size_t vertex) {
  constexpr double far = std::numeric_limits<double>::infinity();
  NearestBone own{0, far}, any{0, far};
  for (std::uint32_t b = 0; b < body.bones.size(); ++b) {
    const Bone& bone = body.bones[b];
    const double distance = segment_distance(body.mesh.vertices[vertex], bone.from, bone.to);
    if (distance < any.distance) any = {b, distance};
    // The weights are read only if they can matter.
    if (distance < own.distance && is_own_bone(body, vertex, bone)) own = {b, distance};
  }
  return own.distance < far ? own : any;
}

// The distance of a point to the nearest bone that begins or ends at a joint, m; 0 if there is none.
double distance_of_joint(const Body& body, const Vector3d& point, std::int32_t joint) {
  constexpr double far = std::numeric_limits<double>::infinity();
  double least = far;
  for (const Bone& bone : body.bones)
    if (bone.owners[0] == joint || bone.owners[2] == joint)
      least = std::min(least, segment_distance(point, bone.from, bone.to));
  return least < far ? least : 0.0;
}

const rig::PaintedAttribute* find_painted(const Body& body, const std::string& name, std::size_t& channel) {
  channel = 0;
  for (const rig::PaintedAttribute& attribute : body.painted) {
    if (attribute.name == name && attribute.width == 1) return &attribute;
    if (name.size() != attribute.name.size() + 2 || !name.starts_with(attribute.name + ".")) continue;
    for (const std::string letters : {"rgba", "xyzw"}) {
      const std::size_t found = letters.find(name.back());
      if (found == std::string::npos || found >= attribute.width) continue;
      channel = found;
      return &attribute;
    }
  }
  return nullptr;
}

std::string painted_names(const Body& body) {
  std::string names;
  for (const rig::PaintedAttribute& attribute : body.painted)
    names +=
        (names.empty() ? "" : ", ") + attribute.name + " of " + counted(attribute.width, "number", "numbers");
  return names.empty() ? "it has none" : "it has " + names;
}

}  // namespace

double segment_distance(const Vector3d& point, const Vector3d& from, const Vector3d& to) {
  const Vector3d along = to - from;
  const double length2 = along.squaredNorm();
  const double u = length2 > 0.0 ? std::clamp((point - from).dot(along) / length2, 0.0, 1.0) : 0.0;
  return (point - (from + u * along)).norm();
}

std::vector<char> joints_named(const Body& body, const std::vector<std::string>& names, bool and_below,
                               const std::string& key, const std::string& source) {
  std::vector<char> is(body.joints.size(), 0);
  for (const std::string& name : names) {
    bool found = false;
    for (std::size_t j = 0; j < is.size(); ++j)
      if (body.joints[j].name == name) is[j] = 1, found = true;
    if (!found) fail(source, key + ": no joint is called \"" + name + "\"; `fascicle inspect` lists them");
  }
  for (std::size_t j = 0; and_below && j < is.size(); ++j)
    if (body.joints[j].parent >= 0 && is[static_cast<std::size_t>(body.joints[j].parent)]) is[j] = 1;
  return is;
}

Measures::Measures(const Body& body) : body_(body) {}

std::vector<double> Measures::shares_of(const std::vector<char>& joints) const {
  std::vector<double> share(body_.mesh.vertices.size(), 0.0);
  if (body_.skin.offset.empty()) return share;
  for (std::size_t i = 0; i < share.size(); ++i)
    for (std::uint32_t k = body_.skin.offset[i]; k < body_.skin.offset[i + 1]; ++k)
      if (joints[body_.skin.joint[k]]) share[i] += body_.skin.weight[k];
  return share;
}

bool Measures::follows(const SkinWeights& skin, std::size_t vertex, const Vector3d& point,
                       double radius) const {
  double share = 0.0;
  for (std::uint32_t k = skin.offset[vertex]; k < skin.offset[vertex + 1]; ++k) {
    const JointUse& joint = body_.joints[skin.joint[k]];
    const auto is_far = [&] {
      return distance_of_joint(body_, point, joint.bone) > furthest_in_radii * radius;
    };
    if (joint.is_kinematic || (!joint.is_free && is_far())) share += skin.weight[k];
  }
  return share >= following_share;
}

const std::vector<char>& Measures::follows_joints() {
  if (!follows_.empty()) return follows_;
  follows_.assign(body_.mesh.vertices.size(), 0);
  for (std::size_t i = 0; i < follows_.size(); ++i)
    if (holding_of(body_, i) != Holding::none) follows_[i] = 1;
  if (body_.joints.empty()) return follows_;
  const std::vector<double>& radius = radii();
  for (std::size_t i = 0; i < follows_.size(); ++i)
    if (follows(body_.skin, i, body_.mesh.vertices[i], radius[i])) follows_[i] = 1;
  return follows_;
}

const std::vector<double>& Measures::radii() {
  if (radii_.empty()) radii_ = local_radii(body_.mesh, skin_distances());
  return radii_;
}

const std::vector<double>& Measures::skin_distances() {
  if (!skin_distances_.empty()) return skin_distances_;
  mesh::SurfaceMesh skin{body_.mesh.vertices, boundary_triangles(body_.mesh, "mesh")};
  // A carrier inside the flesh is not part of its skin.
  std::erase_if(skin.triangles, [&](const auto& t) { return holding_of(body_, t[0]) == Holding::carrier; });
  std::vector<char> is_inside(skin.vertices.size(), 1);
  for (const auto& t : skin.triangles)
    for (const std::uint32_t corner : t) is_inside[corner] = 0;
  const SurfaceSearch search(skin);
  for (std::size_t i = 0; i < is_inside.size(); ++i)
    skin_distances_.push_back(is_inside[i] && holding_of(body_, i) != Holding::carrier
                                  ? search.nearest(skin.vertices[i]).distance
                                  : 0.0);
  return skin_distances_;
}

const std::vector<NearestBone>& Measures::nearest_bones() {
  if (!nearest_.empty()) return nearest_;
  nearest_.reserve(body_.mesh.vertices.size());
  for (std::size_t i = 0; i < body_.mesh.vertices.size(); ++i) nearest_.push_back(nearest_bone(body_, i));
  return nearest_;
}

const std::vector<double>& Measures::bone_distances() {
  if (!bone_distances_.empty()) return bone_distances_;
  const std::vector<NearestBone>& nearest = nearest_bones();
  const std::vector<char>& follows = follows_joints();
  for (std::size_t i = 0; i < nearest.size(); ++i)
    bone_distances_.push_back(follows[i] ? 0.0 : nearest[i].distance);
  return bone_distances_;
}

const std::vector<double>& Measures::depths() {
  if (!depths_.empty()) return depths_;
  const std::vector<double>& from_bone = bone_distances();
  const std::vector<double>& from_skin = skin_distances();
  for (std::size_t i = 0; i < from_bone.size(); ++i) {
    const double b = from_bone[i];
    depths_.push_back(b > 0.0 ? b / (b + from_skin[i]) : 0.0);
  }
  return depths_;
}

const std::vector<double>& Measures::inner_shares(bool by_distance) {
  std::vector<double>& shares = inner_shares_[by_distance];
  if (!shares.empty()) return shares;
  const std::vector<double>& first = by_distance ? bone_distances() : depths();
  const std::vector<double>& second = by_distance ? depths() : bone_distances();
  const std::vector<char>& follows = follows_joints();
  const std::vector<double> volume = lumped_volumes(body_.mesh);
  std::vector<std::uint32_t> order;
  const std::size_t members = std::max<std::size_t>(body_.members.size(), 1);
  std::vector<double> whole(members, 0.0), inside(members, 0.0);
  for (std::uint32_t i = 0; i < volume.size(); ++i) {
    if (follows[i]) continue;
    order.push_back(i);
    whole[member_of(body_, i)] += volume[i];
  }
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return std::tuple(first[a], second[a], a) < std::tuple(first[b], second[b], b);
  });
  shares.assign(volume.size(), 0.0);
  for (const std::uint32_t i : order) {
    const std::size_t k = member_of(body_, i);
    shares[i] = (inside[k] + volume[i] / 2.0) / whole[k];
    inside[k] += volume[i];
  }
  return shares;
}

namespace {

// Layer numbers are names: there is no 2 or 1 between 3 and 0.
constexpr const char* attribute_of_names = "_LAYER";

double painted_at(const SurfacePoint& place, const std::array<double, 3>& of_corners, bool are_names) {
  if (are_names)
    return of_corners[static_cast<std::size_t>(std::max_element(place.weights.begin(), place.weights.end()) -
                                               place.weights.begin())];
  double value = 0.0;
  for (std::size_t c = 0; c < 3; ++c) value += place.weights[c] * of_corners[c];
  return value;
}

}  // namespace

const std::vector<double>& Measures::painted(const std::string& name, const std::string& key,
                                             const std::string& source) {
  std::vector<double>& values = painted_[name];
  if (!values.empty()) return values;
  std::size_t channel = 0;
  const rig::PaintedAttribute* attribute = find_painted(body_, name, channel);
  if (attribute == nullptr)
    fail(source, key + ": the character has no painted attribute \"" + name + "\" (" + painted_names(body_) +
                     "); select one of several numbers with .r .g .b .a or .x .y .z .w");
  const SurfaceSearch search(body_.skin_surface);
  for (const Vector3d& p : body_.mesh.vertices) {
    const SurfacePoint place = search.nearest(p);
    std::array<double, 3> of_corners{};
    for (std::size_t c = 0; c < 3; ++c) {
      const std::size_t vertex = body_.skin_surface.triangles[place.triangle][c];
      of_corners[c] = attribute->values[attribute->width * vertex + channel];
    }
    values.push_back(painted_at(place, of_corners, attribute->name == attribute_of_names));
  }
  return values;
}

const std::vector<std::uint32_t>& Measures::nearest_parts() {
  if (!parts_.empty()) return parts_;
  const SurfaceSearch search(body_.skin_surface);
  for (const Vector3d& p : body_.mesh.vertices) {
    const std::uint32_t triangle = search.nearest(p).triangle;
    const auto after = std::upper_bound(
        body_.parts.begin(), body_.parts.end(), triangle,
        [](std::uint32_t t, const rig::SurfacePart& part) { return t < part.first_triangle; });
    parts_.push_back(static_cast<std::uint32_t>(after - body_.parts.begin()) - 1);
  }
  return parts_;
}

}  // namespace fascicle::build
