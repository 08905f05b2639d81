#include "host/build/where.h"

#include <algorithm>
#include <cmath>

#include "host/base/nearest_name.h"
#include "host/build/message.h"
#include "host/scene/scene_table.h"

namespace fascicle::build {

namespace {

constexpr double slack_of_diagonal = 1e-9;

// One flag per vertex for one shape.
struct ShapeTest {
  Measures& measures;
  const std::vector<Vector3d>& low;  // of each member
  const std::vector<Vector3d>& high;
  double slack;
  const std::string& key;
  const std::string& source;

  const std::vector<Vector3d>& vertices() const { return measures.body().mesh.vertices; }

  template <class Holds>
  std::vector<char> each_point(Holds holds) const {
    std::vector<char> inside;
    inside.reserve(vertices().size());
    for (std::size_t i = 0; i < vertices().size(); ++i)
      inside.push_back(holds(own_place(measures.body(), i)) ? 1 : 0);
    return inside;
  }

  static std::vector<char> between(const std::vector<double>& values, double minimum, double maximum,
                                   double tolerance) {
    std::vector<char> inside;
    inside.reserve(values.size());
    for (const double value : values)
      inside.push_back(value >= minimum - tolerance && value <= maximum + tolerance ? 1 : 0);
    return inside;
  }

  void need_bones() const {
    if (measures.body().bones.empty())
      fail(source,
           key +
               ": needs bones to measure distances from, but there are none; add bones (of a character, name "
               "joints in [skeleton] bones), or use another shape");
  }

  // For the named joints, each vertex's maximum depends on its nearest bone.
  std::vector<char> within(const std::vector<double>& values, double minimum, double maximum,
                           const scene::PerBone& per_bone, double tolerance) const {
    std::vector<char> inside = between(values, minimum, maximum, tolerance);
    const Body& body = measures.body();
    for (const auto& [name, other] : per_bone) {
      std::vector<char> is_its_bone;
      for (const Bone& bone : body.bones)
        is_its_bone.push_back(bone.owners[0] >= 0 && !body.joints.empty() &&
                              body.joints[static_cast<std::size_t>(bone.owners[0])].name == name);
      if (std::none_of(is_its_bone.begin(), is_its_bone.end(), [](char c) { return c != 0; }))
        fail(source, key + ": per_bone: no bone belongs to a joint called \"" + name +
                         "\"; `fascicle inspect` lists the bones");
      for (std::size_t i = 0; i < values.size(); ++i)
        if (is_its_bone[measures.nearest_bones()[i].bone])
          inside[i] = values[i] >= minimum - tolerance && values[i] <= other + tolerance;
    }
    return inside;
  }

  std::vector<char> operator()(const scene::Box& box) const {
    return each_point([&](const Vector3d& p) {
      return ((p - box.minimum).array() >= -slack).all() && ((box.maximum - p).array() >= -slack).all();
    });
  }
  std::vector<char> operator()(const scene::Sphere& sphere) const {
    return each_point([&](const Vector3d& p) { return (p - sphere.center).norm() <= sphere.radius + slack; });
  }
  std::vector<char> operator()(const scene::Capsule& capsule) const {
    return each_point([&](const Vector3d& p) {
      return segment_distance(p, capsule.from, capsule.to) <= capsule.radius + slack;
    });
  }
  std::vector<char> operator()(const scene::HalfSpace& half) const {
    const int axis = static_cast<int>(half.axis);
    std::vector<double> bound(low.size(), half.value);
    for (std::size_t k = 0; k < low.size(); ++k)
      if (half.is_fraction) bound[k] = low[k][axis] + half.value * (high[k][axis] - low[k][axis]);
    std::vector<char> inside;
    inside.reserve(vertices().size());
    for (std::size_t i = 0; i < vertices().size(); ++i) {
      const double place = own_place(measures.body(), i)[axis], limit = bound[member_of(measures.body(), i)];
      inside.push_back((half.below ? place <= limit + slack : place >= limit - slack) ? 1 : 0);
    }
    return inside;
  }
  std::vector<char> operator()(const scene::BoneDistance& range) const {
    need_bones();
    return within(measures.bone_distances(), range.minimum, range.maximum, range.per_bone, slack);
  }
  std::vector<char> operator()(const scene::Depth& range) const {
    need_bones();
    return within(measures.depths(), range.minimum, range.maximum, range.per_bone, slack_of_diagonal);
  }
  std::vector<char> operator()(const scene::VolumeShare& range) const {
    need_bones();
    return between(measures.inner_shares(range.by_distance), range.minimum, range.maximum, 0.0);
  }
  std::vector<char> operator()(const scene::JointSet& set) const {
    const std::vector<char> joints =
        joints_named(measures.body(), set.names, set.below, key + ".joints.names", source);
    return between(measures.shares_of(joints), set.share, 2.0, slack_of_diagonal);
  }
  std::vector<char> operator()(const scene::PartSet& set) const {
    const std::vector<rig::SurfacePart>& parts = measures.body().parts;
    const auto name_of = [&](const rig::SurfacePart& part) -> const std::string& {
      return set.by_object ? part.object : part.material;
    };
    const std::string kind = set.by_object ? "object" : "material";
    std::vector<char> is_named(parts.size(), 0);
    for (const std::string& name : set.names) {
      bool found = false;
      std::vector<std::string> names;
      for (std::size_t k = 0; k < parts.size(); ++k) {
        names.push_back(name_of(parts[k]));
        if (name_of(parts[k]) == name) is_named[k] = 1, found = true;
      }
      if (!found)
        fail(source, key + "." + kind + ".names: no " + kind + " is called \"" + name + "\"" +
                         base::nearest_name_hint(name, names) + "; `fascicle scenes FILE` lists them");
    }
    std::vector<char> inside;
    inside.reserve(vertices().size());
    for (const std::uint32_t part : measures.nearest_parts()) inside.push_back(is_named[part]);
    return inside;
  }
  std::vector<char> operator()(const scene::Painted& painted) const {
    return between(measures.painted(painted.attribute, key + ".painted", source), painted.minimum,
                   painted.maximum, 0.0);
  }
  std::vector<char> operator()(const scene::Everywhere&) const {
    return std::vector<char>(vertices().size(), 1);
  }
};

}  // namespace

WhereTest::WhereTest(Measures& measures) : measures_(measures) {
  const Body& body = measures.body();
  low_.assign(std::max<std::size_t>(body.members.size(), 1), Vector3d::Constant(INFINITY));
  high_.assign(low_.size(), Vector3d::Constant(-INFINITY));
  for (std::size_t i = 0; i < body.mesh.vertices.size(); ++i) {
    const std::size_t k = member_of(body, i);
    const Vector3d p = own_place(body, i);
    low_[k] = low_[k].cwiseMin(p);
    high_[k] = high_[k].cwiseMax(p);
  }
  slack_ = slack_of_diagonal * diagonal_of_member(body);
}

std::vector<char> WhereTest::contains(const scene::Where& where, const std::string& key,
                                      const std::string& source) {
  const ShapeTest test{measures_, low_, high_, slack_, key, source};
  std::vector<char> inside(measures_.body().mesh.vertices.size(), 0);
  for (const scene::Shape& shape : where) {
    const std::vector<char> in_shape = std::visit(test, shape);
    for (std::size_t i = 0; i < inside.size(); ++i) inside[i] = inside[i] || in_shape[i];
  }
  return inside;
}

}  // namespace fascicle::build
