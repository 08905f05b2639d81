// [collider.NAME]
#include "host/scene/scene_keys.h"
#include "host/scene/scene_rows.h"

namespace fascicle::scene {

namespace {

const auto& collider_rows() {
  using namespace rows;
  static const std::tuple all{
      member("name", &Collider::name),
      key(&Collider::shape,
          {.name = "shape",
           .doc =
               "plane: flesh stays on the side of `normal`, as above a floor; sphere; capsule: all that is "
               "nearer to the line `from` `to` than `radius`; box.",
           .required = true}),
      key(&Collider::center, {.name = "center",
                              .doc = "Middle of a sphere or a box, or any point of a plane, m.",
                              .range = coordinate}),
      key(&Collider::normal, {.name = "normal",
                              .doc = "Plane: a direction to the side where the flesh is.",
                              .range = coordinate}),
      key(&Collider::from,
          {.name = "from", .doc = "Capsule, needed there: where its axis begins, m.", .range = coordinate},
          {.depends = true}),
      key(&Collider::to,
          {.name = "to", .doc = "Capsule, needed there: where its axis ends, m.", .range = coordinate},
          {.depends = true}),
      key(&Collider::size,
          {.name = "size", .doc = "Box, needed there: its three edges, m.", .range = positive(farthest)},
          {.depends = true}),
      key(&Collider::rotation,
          {.name = "rotation",
           .doc = "Box: how it is turned about its middle: an axis times degrees, [0, 30, 0] is 30 degrees "
                  "about Y.",
           .range = between(-1e5, 1e5)}),
      key(&Collider::radius,
          {.name = "radius",
           .doc = "Sphere and capsule, needed there; box: of its edges, which else are sharp, m.",
           .range = positive(farthest)},
          {.depends = true}),
      key(&Collider::thickness, {.name = "thickness",
                                 .doc = "How far from the solid flesh stays, m.",
                                 .range = between(0.0, farthest)}),
      key(&Collider::friction,
          {.name = "friction", .doc = "Coulomb's coefficient.", .range = between(0.0, 100.0)}),
      key(&Collider::joint,
          {.name = "joint",
           .doc =
               "The solid goes with this joint, and stands as said in the bind pose. Flesh that lies in it "
               "there, or within a tenth of its size of it, is not held by it."}),
      key(&Collider::times,
          {.name = "times",
           .doc =
               "Keys of the solid's own motion: their times of the clip, s, ascending. Between two keys it "
               "moves evenly; before the first and after the last it stands.",
           .range = between(-1e5, 1e5)}),
      key(&Collider::offsets, {.name = "offsets",
                               .doc = "At each key, how far it has moved, m: [[x, y, z], ...].",
                               .range = coordinate}),
      key(&Collider::turns, {.name = "turns",
                             .doc = "At each key, how it has turned about its middle: an axis times degrees.",
                             .range = between(-1e5, 1e5)})};
  static_assert(base::has_row_for_each_member<Collider, decltype(all)>,
                "a member of Collider has no row here");
  return all;
}

}  // namespace

const Table& collider_table() {
  static const Table table =
      with_keys({.name = "collider", .doc = "A solid that flesh does not enter: a floor, a chair, a prop."},
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
