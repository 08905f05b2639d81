#include "host/build/where.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "host/build/message.h"

namespace fascicle::build {

namespace {

constexpr double slack_of_diagonal = 1e-9;
constexpr double own_share = 0.02;
constexpr std::array<std::int32_t, 3> no_owners{-1, -1, -1};
// A vertex with this much of its weight on joints that end a chain is part of a head, a hand or a foot.
constexpr double leaf_share = 0.5;

struct PointTest {
  const Vector3d& point;
  double bone_distance;
  const Vector3d& low;
  const Vector3d& high;
  double slack;

  bool operator()(const scene::Box& box) const {
    return ((point - box.minimum).array() >= -slack).all() && ((box.maximum - point).array() >= -slack).all();
  }
  bool operator()(const scene::Sphere& sphere) const {
    return (point - sphere.center).norm() <= sphere.radius + slack;
  }
  bool operator()(const scene::Capsule& capsule) const {
    return segment_distance(point, capsule.from, capsule.to) <= capsule.radius + slack;
  }
  bool operator()(const scene::HalfSpace& half) const {
    const int axis = static_cast<int>(half.axis);
    const double bound = half.is_fraction ? low[axis] + half.value * (high[axis] - low[axis]) : half.value;
    return half.below ? point[axis] <= bound + slack : point[axis] >= bound - slack;
  }
  bool operator()(const scene::BoneDistance& range) const {
    return bone_distance >= range.minimum - slack && bone_distance <= range.maximum + slack;
  }
  bool operator()(const scene::Everywhere&) const { return true; }
};

// The share of a vertex's weights that joint `joint` holds.
double share_of(const SkinWeights& skin, std::size_t vertex, std::int32_t joint) {
  double share = 0.0;
  for (std::uint32_t k = skin.offset[vertex]; k < skin.offset[vertex + 1]; ++k)
    if (static_cast<std::int32_t>(skin.joint[k]) == joint) share += skin.weight[k];
  return share;
}

// A bone the scene draws has no owner and is everybody's.
bool is_own_bone(const Body& body, std::size_t vertex, const Bone& bone) {
  if (body.skin.offset.empty() || bone.owners == no_owners) return true;
  return std::any_of(bone.owners.begin(), bone.owners.end(), [&](std::int32_t owner) {
    return owner >= 0 && share_of(body.skin, vertex, owner) >= own_share;
  });
}

// The weight of a vertex on joints that end a chain: point bones of one owner and no next joint.
double leaf_weight(const Body& body, std::size_t vertex) {
  if (body.skin.offset.empty()) return 0.0;
  double sum = 0.0;
  for (const Bone& bone : body.bones)
    if (bone.owners != no_owners && bone.owners[2] < 0) sum += share_of(body.skin, vertex, bone.owners[0]);
  return sum;
}

}  // namespace

double segment_distance(const Vector3d& point, const Vector3d& from, const Vector3d& to) {
  const Vector3d along = to - from;
  const double length2 = along.squaredNorm();
  const double u = length2 > 0.0 ? std::clamp((point - from).dot(along) / length2, 0.0, 1.0) : 0.0;
  return (point - (from + u * along)).norm();
}

WhereTest::WhereTest(const Body& body) : body_(body), low_(body.mesh.vertices[0]), high_(low_) {
  for (const Vector3d& p : body.mesh.vertices) {
    low_ = low_.cwiseMin(p);
    high_ = high_.cwiseMax(p);
  }
  slack_ = slack_of_diagonal * (high_ - low_).norm();
}

std::vector<char> WhereTest::contains(const scene::Where& where, const std::string& key,
                                      const std::string& source) {
  const bool asks_for_bones = std::any_of(where.begin(), where.end(), [](const scene::Shape& shape) {
    return std::holds_alternative<scene::BoneDistance>(shape);
  });
  if (asks_for_bones && body_.bones.empty())
    fail(source,
         key +
             ": a distance from the bones is asked for, but there are none; add bones, or use another shape");
  std::vector<char> inside(body_.mesh.vertices.size(), 0);
  for (std::size_t i = 0; i < inside.size(); ++i) {
    const PointTest test{body_.mesh.vertices[i], asks_for_bones ? bone_distances()[i] : 0.0, low_, high_,
                         slack_};
    inside[i] = std::any_of(where.begin(), where.end(),
                            [&](const scene::Shape& shape) { return std::visit(test, shape); });
  }
  return inside;
}

const std::vector<double>& WhereTest::bone_distances() {
  if (!bone_distances_.empty()) return bone_distances_;
  constexpr double far = std::numeric_limits<double>::infinity();
  bone_distances_.resize(body_.mesh.vertices.size());
  for (std::size_t i = 0; i < bone_distances_.size(); ++i) {
    if (leaf_weight(body_, i) >= leaf_share) {
      bone_distances_[i] = 0.0;
      continue;
    }
    double own = far, any = far;
    for (const Bone& bone : body_.bones) {
      const double distance = segment_distance(body_.mesh.vertices[i], bone.from, bone.to);
      any = std::min(any, distance);
      // The weights are looked through only where the answer can matter.
      if (distance < own && is_own_bone(body_, i, bone)) own = distance;
    }
    bone_distances_[i] = own < far ? own : any;
  }
  return bone_distances_;
}

}  // namespace fascicle::build
