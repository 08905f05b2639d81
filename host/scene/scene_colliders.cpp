// [collider.NAME]: which keys belong to which shape, and their allowed values.
#include <algorithm>
#include <initializer_list>
#include <string_view>

#include "host/base/nearest_name.h"
#include "host/scene/scene_keys.h"
#include "host/scene/scene_values.h"

namespace fascicle::scene {

namespace {

struct KeysOfShape {
  ColliderShape shape;
  std::initializer_list<const char*> needed, optional;
};
constexpr KeysOfShape keys_of_shapes[] = {
    {ColliderShape::plane, {}, {"center", "normal"}},
    {ColliderShape::sphere, {"radius"}, {"center"}},
    {ColliderShape::capsule, {"from", "to", "radius"}, {}},
    {ColliderShape::box, {"size"}, {"center", "rotation", "radius"}},
};

class ColliderCheck {
 public:
  ColliderCheck(const toml::table& table, const std::string& path, const Collider& collider)
      : table_(table), path_(path), collider_(collider) {}

  void check_shape() const {
    const auto has = [](std::initializer_list<const char*> names, std::string_view name) {
      return std::any_of(names.begin(), names.end(), [&](const char* n) { return name == n; });
    };
    const KeysOfShape& keys = *std::find_if(std::begin(keys_of_shapes), std::end(keys_of_shapes),
                                            [&](const KeysOfShape& k) { return k.shape == collider_.shape; });
    const std::string shape = name_of(collider_.shape);
    for (const char* key : keys.needed)
      if (!table_.contains(key)) refuse(key, "is missing; a " + shape + " needs it");
    for (const char* key : {"center", "normal", "from", "to", "size", "rotation", "radius"})
      if (table_.contains(key) && !has(keys.needed, key) && !has(keys.optional, key))
        refuse(key, "does not apply to a " + shape + "; leave it out");
    if (collider_.normal.isZero(0.0)) refuse("normal", "has no length; give a direction");
    if (collider_.shape == ColliderShape::capsule && collider_.from == collider_.to)
      refuse("to", "is the same point as `from`; give a sphere instead");
    if (collider_.shape != ColliderShape::box) return;
    if (2.0 * collider_.radius > collider_.size.minCoeff())
      refuse("radius", "is more than half of the box's shortest edge, so it would be no box");
  }

  void check_motion() const {
    const std::size_t keys = collider_.times.size();
    if (keys > 0 && !collider_.joint.empty())
      refuse("times", "moves a solid that is attached to a joint; leave out `times` or `joint`");
    for (std::size_t k = 1; k < keys; ++k)
      if (!(collider_.times[k - 1] < collider_.times[k])) refuse("times", "must ascend");
    if (keys > 0 && collider_.offsets.empty() && collider_.turns.empty())
      refuse("times", "has neither `offsets` nor `turns`; give the solid's place at these times");
    check_count("offsets", collider_.offsets.size());
    check_count("turns", collider_.turns.size());
  }

 private:
  [[noreturn]] void refuse(const char* key, const std::string& what) const {
    fail(table_.contains(key) ? table_.get(key)->source() : table_.source(), join_path(path_, key), what);
  }
  void check_count(const char* key, std::size_t count) const {
    if (count != 0 && count != collider_.times.size())
      refuse(key, "has " + std::to_string(count) + " entries and `times` has " +
                      std::to_string(collider_.times.size()) + "; each key needs one");
  }

  const toml::table& table_;
  const std::string& path_;
  const Collider& collider_;
};

}  // namespace

void read_colliders(const toml::table& root, const Surroundings& surroundings, Scene& scene) {
  for_each_named(root, "collider",
                 [&](const std::string& name, const toml::table& table, const std::string& path) {
                   Collider collider;
                   collider.name = name;
                   read_keys(table, collider);
                   const ColliderCheck check(table, path, collider);
                   check.check_shape();
                   check.check_motion();
                   if (!collider.joint.empty() && !surroundings.has_joints)
                     fail(table.get("joint")->source(), join_path(path, "joint"),
                          "only a [character] has joints; leave it out");
                   scene.colliders.push_back(std::move(collider));
                   if (scene.colliders.size() > most_colliders)
                     fail(table.source(), path,
                          "is one collider too many; a scene has at most " + std::to_string(most_colliders));
                 });
}

void check_collider_joints(const toml::table& root, const Scene& scene) {
  const auto* character = std::get_if<rig::Character>(&scene.geometry);
  if (character == nullptr) return;
  std::vector<std::string> names;
  for (const auto& joint : character->skeleton) names.push_back(joint.name);
  for_each_named(
      root, "collider", [&](const std::string&, const toml::table& table, const std::string& path) {
        const toml::node* node = table.get("joint");
        if (node == nullptr) return;
        const std::string& joint = node->as_string()->get();
        if (joint.empty()) return;
        if (std::find(names.begin(), names.end(), joint) == names.end())
          fail(node->source(), join_path(path, "joint"),
               "there is no joint \"" + one_line(joint) + "\"" + base::nearest_name_hint(joint, names));
      });
}

}  // namespace fascicle::scene
