#include "host/scene/scene_keys.h"
#include "host/scene/scene_values.h"

namespace fascicle::scene {
namespace {

template <class Range>
void check_bounds(const toml::table& table, const std::string& path, const Range& range) {
  if (range.minimum > range.maximum) fail(table.source(), path, "minimum is above maximum; swap them");
}

void need_bones(const toml::table& table, const Surroundings& surroundings, const std::string& path) {
  if (surroundings.has_bones) return;
  fail(table.source(), path,
       "the scene has no bones; add [bones.NAME] with from and to, or use a [character]");
}

void need_character(const toml::table& table, const Surroundings& surroundings, const std::string& path) {
  if (surroundings.has_joints) return;
  fail(table.source(), path, "only a [character] has these; use another shape");
}

// Reads a range of a quantity measured from the bones.
template <class Range>
Range read_from_bone(const toml::table& table, const Surroundings& surroundings, const std::string& path) {
  Range range;
  read_keys(table, range);
  check_bounds(table, path, range);
  if (const toml::node* node = table.get("per_bone"); node != nullptr && !surroundings.has_joints)
    fail(node->source(), join_path(path, "per_bone"), "names joints, and only a [character] has them");
  need_bones(table, surroundings, path);
  return range;
}

HalfSpace read_half_space(const toml::table& table, bool below) {
  HalfSpace half_space;
  half_space.below = below;
  read_keys(table, half_space);
  half_space.is_fraction = table.contains("fraction");
  read(table, half_space.is_fraction ? "fraction" : "value", half_space.value);
  return half_space;
}

Shape read_shape(const toml::table& table, const Surroundings& surroundings, const std::string& path) {
  const std::string kind(table.begin()->first.str());
  if (kind == "everywhere") {
    bool everywhere = false;
    read(table, "everywhere", everywhere);
    if (!everywhere) fail(table.source(), join_path(path, kind), "is false; set it to true, or leave it out");
    return Everywhere{};
  }
  const toml::table& inner = *table.begin()->second.as_table();
  const std::string inner_path = join_path(path, kind);
  if (kind == "box") {
    Box box;
    read_keys(inner, box);
    if ((box.minimum.array() > box.maximum.array()).any()) {
      fail(inner.source(), inner_path, "minimum is above maximum; swap them");
    }
    return box;
  }
  if (kind == "sphere") {
    Sphere sphere{Vector3d::Zero(), 0.0};
    read_keys(inner, sphere);
    return sphere;
  }
  if (kind == "capsule") {
    Capsule capsule{Vector3d::Zero(), Vector3d::Zero(), 0.0};
    read_keys(inner, capsule);
    return capsule;
  }
  if (kind == "bone_distance") return read_from_bone<BoneDistance>(inner, surroundings, inner_path);
  if (kind == "depth") return read_from_bone<Depth>(inner, surroundings, inner_path);
  if (kind == "volume_share") {
    VolumeShare share;
    read_keys(inner, share);
    check_bounds(inner, inner_path, share);
    need_bones(inner, surroundings, inner_path);
    return share;
  }
  if (kind == "joints") {
    JointSet set;
    read_keys(inner, set);
    need_character(inner, surroundings, inner_path);
    return set;
  }
  if (kind == "material" || kind == "object") {
    PartSet set;
    set.by_object = kind == "object";
    read_keys(inner, set);
    need_character(inner, surroundings, inner_path);
    return set;
  }
  if (kind == "painted") {
    Painted painted;
    read_keys(inner, painted);
    check_bounds(inner, inner_path, painted);
    need_character(inner, surroundings, inner_path);
    return painted;
  }
  return read_half_space(inner, kind == "below");
}

}  // namespace

Where read_where(const toml::table& owner, const Surroundings& surroundings, const std::string& path) {
  Where where;
  const toml::node* node = owner.get("where");
  if (node == nullptr) return where;
  const std::string where_path = join_path(path, "where");
  if (const toml::table* table = node->as_table()) {
    where.push_back(read_shape(*table, surroundings, where_path));
    return where;
  }
  const toml::array& array = *node->as_array();
  for (std::size_t i = 0; i < array.size(); ++i) {
    where.push_back(
        read_shape(*array[i].as_table(), surroundings, where_path + "[" + std::to_string(i) + "]"));
  }
  return where;
}

}  // namespace fascicle::scene
