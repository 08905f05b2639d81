// [collider.NAME]
#include "host/scene/scene_keys.h"
#include "host/scene/scene_rows.h"

namespace fascicle::scene {

namespace {

const auto& collider_rows() {
  using namespace rows;
  static const std::tuple all{
      member("name", &Collider::name),
      key(&Collider::shape, {.name = "shape",
                             .doc = "plane: flesh stays on the side of `normal`, as above a floor; sphere; "
                                    "capsule: all points within `radius` of the segment `from` to `to`; box.",
                             .required = true}),
      key(&Collider::center, {.name = "center",
                              .doc = "Centre of a sphere or a box, or any point on a plane, m.",
                              .range = coordinate}),
      key(&Collider::normal,
          {.name = "normal", .doc = "Plane: direction to the side where the flesh is.", .range = coordinate}),
      key(&Collider::from,
          {.name = "from", .doc = "Capsule (required): start of its axis, m.", .range = coordinate},
          {.depends = true}),
      key(&Collider::to,
          {.name = "to", .doc = "Capsule (required): end of its axis, m.", .range = coordinate},
          {.depends = true}),
      key(&Collider::size,
          {.name = "size", .doc = "Box (required): lengths of its edges, m.", .range = positive(farthest)},
          {.depends = true}),
      key(&Collider::rotation,
          {.name = "rotation",
           .doc =
               "Box: rotation about its centre, as an axis times degrees: [0, 30, 0] is 30 degrees about Y.",
           .range = between(-1e5, 1e5)}),
      key(&Collider::radius,
          {.name = "radius",
           .doc =
               "Sphere and capsule (required): radius, m; box: radius of its rounded edges, sharp if absent.",
           .range = positive(farthest)},
          {.depends = true}),
      key(&Collider::thickness, {.name = "thickness",
                                 .doc = "Distance that flesh keeps from the solid, m.",
                                 .range = between(0.0, farthest)}),
      key(&Collider::friction,
          {.name = "friction", .doc = "Coulomb friction coefficient.", .range = between(0.0, 100.0)}),
      key(&Collider::joint, {.name = "joint",
                             .doc = "Joint to which the solid is attached; its placement is then given in "
                                    "the bind pose. Flesh inside it in that pose, or nearer than a tenth of "
                                    "its largest half-extent, does not collide with it."}),
      key(&Collider::times, {.name = "times",
                             .doc = "Key times of the solid's own motion, s of the clip, ascending. Linear "
                                    "between keys; at rest before the first and after the last.",
                             .range = between(-1e5, 1e5)}),
      key(&Collider::offsets,
          {.name = "offsets", .doc = "Displacement at each key, m: [[x, y, z], ...].", .range = coordinate}),
      key(&Collider::turns, {.name = "turns",
                             .doc = "Rotation about its centre at each key, as an axis times degrees.",
                             .range = between(-1e5, 1e5)})};
  static_assert(base::has_row_for_each_member<Collider, decltype(all)>,
                "a member of Collider has no row here");
  return all;
}

}  // namespace

const Table& collider_table() {
  static const Table table =
      with_keys({.name = "collider", .doc = "A solid that flesh cannot enter: a floor, a chair, a prop."},
                collider_rows());
  return table;
}
void read_keys(const toml::table& table, Collider& collider) {
  read_rows(table, collider_rows(), collider);
}
Json json_of(const Collider& collider) {
  return json_of_rows(collider_rows(), collider);
}

}  // namespace fascicle::scene
