// The shapes of `where`.
#include <type_traits>
#include <variant>

#include "host/scene/scene_keys.h"
#include "host/scene/scene_rows.h"

namespace fascicle::scene {
namespace {

const auto& box_rows() {
  using namespace rows;
  static const std::tuple all{
      key(&Box::minimum,
          {.name = "minimum", .doc = "Minimum corner, m.", .range = coordinate, .required = true}),
      key(&Box::maximum,
          {.name = "maximum", .doc = "Maximum corner, m.", .range = coordinate, .required = true})};
  static_assert(base::has_row_for_each_member<Box, decltype(all)>, "a member of Box has no row here");
  return all;
}

const auto& sphere_rows() {
  using namespace rows;
  static const std::tuple all{
      key(&Sphere::center, {.name = "center", .doc = "Centre, m.", .range = coordinate, .required = true}),
      key(&Sphere::radius,
          {.name = "radius", .doc = "Radius, m.", .range = positive(farthest), .required = true})};
  static_assert(base::has_row_for_each_member<Sphere, decltype(all)>, "a member of Sphere has no row here");
  return all;
}

const auto& capsule_rows() {
  using namespace rows;
  static const std::tuple all{
      key(&Capsule::from,
          {.name = "from", .doc = "One end of the segment, m.", .range = coordinate, .required = true}),
      key(&Capsule::to,
          {.name = "to", .doc = "Other end of the segment, m.", .range = coordinate, .required = true}),
      key(&Capsule::radius,
          {.name = "radius", .doc = "Radius, m.", .range = positive(farthest), .required = true})};
  static_assert(base::has_row_for_each_member<Capsule, decltype(all)>, "a member of Capsule has no row here");
  return all;
}

const auto& half_space_rows() {
  using namespace rows;
  static const std::tuple all{
      key(&HalfSpace::axis, {.name = "axis", .doc = "Axis perpendicular to the plane."}),
      loose_key({.name = "value", .doc = "Position of the plane on the axis, m.", .range = coordinate}),
      loose_key({.name = "fraction",
                 .doc = "Position of the plane on the axis, as a fraction of the body's bounding box from "
                        "its low side.",
                 .range = between(0.0, 1.0)}),
      member("below", &HalfSpace::below, Shown::never),
      member("is_fraction", &HalfSpace::is_fraction, Shown::never),
      member("value", &HalfSpace::value, Shown::never)};
  static_assert(base::has_row_for_each_member<HalfSpace, decltype(all)>,
                "a member of HalfSpace has no row here");
  return all;
}

const auto& bone_distance_rows() {
  using namespace rows;
  static const std::tuple all{
      key(&BoneDistance::minimum,
          {.name = "minimum", .doc = "Smallest distance, m.", .range = between(0.0, farthest)}),
      key(&BoneDistance::maximum, {.name = "maximum",
                                   .doc = "Largest distance, m.",
                                   .range = between(0.0, farthest),
                                   .required = true}),
      key(&BoneDistance::per_bone,
          {.name = "per_bone",
           .doc = "Maxima for the points nearest to individual bones, by joint name.",
           .range = between(0.0, farthest)})};
  static_assert(base::has_row_for_each_member<BoneDistance, decltype(all)>,
                "a member of BoneDistance has no row here");
  return all;
}

const auto& depth_rows() {
  using namespace rows;
  static const std::tuple all{
      key(&Depth::minimum, {.name = "minimum", .doc = "Smallest depth.", .range = between(0.0, 1.0)}),
      key(&Depth::maximum,
          {.name = "maximum", .doc = "Largest depth.", .range = between(0.0, 1.0), .required = true}),
      key(&Depth::per_bone, {.name = "per_bone",
                             .doc = "Maxima for the points nearest to individual bones, by joint name.",
                             .range = between(0.0, farthest)})};
  static_assert(base::has_row_for_each_member<Depth, decltype(all)>, "a member of Depth has no row here");
  return all;
}

const auto& volume_share_rows() {
  using namespace rows;
  static const std::tuple all{
      key(&VolumeShare::minimum,
          {.name = "minimum", .doc = "Share at the inner side.", .range = between(0.0, 1.0)}),
      key(&VolumeShare::maximum, {.name = "maximum",
                                  .doc = "Share at the outer side.",
                                  .range = between(0.0, 1.0),
                                  .required = true}),
      key(&VolumeShare::by_distance,
          {.name = "by",
           .doc = "Measure of nearness: relative depth, or distance from the bone.",
           .allowed = {"depth", "distance"}})};
  static_assert(base::has_row_for_each_member<VolumeShare, decltype(all)>,
                "a member of VolumeShare has no row here");
  return all;
}

const auto& joint_set_rows() {
  using namespace rows;
  static const std::tuple all{
      key(&JointSet::names, {.name = "names",
                             .doc = "Joints, including all below them unless below = false.",
                             .required = true}),
      key(&JointSet::share, {.name = "share",
                             .doc = "Smallest share of a point's skin weights that these joints must hold.",
                             .range = positive(1.0)}),
      key(&JointSet::below, {.name = "below", .doc = "Whether the joints below those named are included."})};
  static_assert(base::has_row_for_each_member<JointSet, decltype(all)>,
                "a member of JointSet has no row here");
  return all;
}

const auto& part_set_rows() {
  using namespace rows;
  static const std::tuple all{
      key(&PartSet::names, {.name = "names", .doc = "Names as in the character's file.", .required = true}),
      member("by_object", &PartSet::by_object, Shown::never)};
  static_assert(base::has_row_for_each_member<PartSet, decltype(all)>, "a member of PartSet has no row here");
  return all;
}

const auto& painted_rows() {
  using namespace rows;
  static const std::tuple all{
      key(&Painted::attribute, {.name = "attribute",
                                .doc = "glTF attribute: _NAME, or COLOR_n with a channel, such as COLOR_0.r.",
                                .required = true}),
      key(&Painted::minimum,
          {.name = "minimum", .doc = "Smallest value.", .range = coordinate, .required = true}),
      key(&Painted::maximum,
          {.name = "maximum", .doc = "Largest value.", .range = coordinate, .required = true})};
  static_assert(base::has_row_for_each_member<Painted, decltype(all)>, "a member of Painted has no row here");
  return all;
}

const Table& box_table() {
  static const Table table =
      with_keys({.name = "box", .doc = "An axis-aligned box, faces included."}, box_rows());
  return table;
}

const Table& sphere_table() {
  static const Table table =
      with_keys({.name = "sphere", .doc = "A sphere, surface included."}, sphere_rows());
  return table;
}

const Table& capsule_table() {
  static const Table table =
      with_keys({.name = "capsule", .doc = "All points within a radius of a segment."}, capsule_rows());
  return table;
}

const Table& half_space_table() {
  static const Table table =
      with_keys({.name = "half_space",
                 .doc = "One side of a plane perpendicular to an axis, the plane included.",
                 .choices = {{"value", "fraction"}}},
                half_space_rows());
  return table;
}

const Table& bone_distance_table() {
  static const Table table = with_keys(
      {.name = "bone_distance",
       .doc = "Points by their distance from the nearest bone: [bones.NAME], or the character's own."},
      bone_distance_rows());
  return table;
}

const Table& depth_table() {
  static const Table table = with_keys(
      {.name = "depth", .doc = "Points by their relative depth: 0 at the nearest bone, 1 at the skin."},
      depth_rows());
  return table;
}

const Table& volume_share_table() {
  static const Table table =
      with_keys({.name = "volume_share",
                 .doc = "Points by the share of the body's volume that lies nearer to the bones. Flesh that "
                        "follows the skeleton (heads, hands, feet) is not counted."},
                volume_share_rows());
  return table;
}

const Table& joint_set_table() {
  static const Table table = with_keys(
      {.name = "joint_set", .doc = "Points by the joints of a character that move them."}, joint_set_rows());
  return table;
}

const Table& part_set_table() {
  static const Table table = with_keys(
      {.name = "part_set", .doc = "Points by the material or object of the nearest skin."}, part_set_rows());
  return table;
}

const Table& painted_table() {
  static const Table table = with_keys({.name = "painted",
                                        .doc = "Points by a value painted on a character's vertices. In "
                                               "layers, paint takes precedence over all other shapes."},
                                       painted_rows());
  return table;
}

}  // namespace

const Table& shape_table() {
  static const Table table{
      .name = "shape",
      .doc = "A region of space; an array is the union of its shapes.",
      .keys =
          {{.name = "box", .type = KeyType::table, .doc = "Inside a box.", .table = &box_table()},
           {.name = "sphere", .type = KeyType::table, .doc = "Inside a sphere.", .table = &sphere_table()},
           {.name = "capsule", .type = KeyType::table, .doc = "Inside a capsule.", .table = &capsule_table()},
           {.name = "below", .type = KeyType::table, .doc = "Below a plane.", .table = &half_space_table()},
           {.name = "above", .type = KeyType::table, .doc = "Above a plane.", .table = &half_space_table()},
           {.name = "bone_distance",
            .type = KeyType::table,
            .doc = "By distance from the nearest bone.",
            .table = &bone_distance_table()},
           {.name = "depth", .type = KeyType::table, .doc = "By relative depth.", .table = &depth_table()},
           {.name = "volume_share",
            .type = KeyType::table,
            .doc = "By share of the volume.",
            .table = &volume_share_table()},
           {.name = "joints",
            .type = KeyType::table,
            .doc = "By the joints that move it.",
            .table = &joint_set_table()},
           {.name = "material",
            .type = KeyType::table,
            .doc = "Below skin of these materials.",
            .table = &part_set_table()},
           {.name = "object",
            .type = KeyType::table,
            .doc = "Below skin of these objects.",
            .table = &part_set_table()},
           {.name = "painted",
            .type = KeyType::table,
            .doc = "By a painted value.",
            .table = &painted_table()},
           {.name = "everywhere", .type = KeyType::boolean, .doc = "All of space: everywhere = true."}},
      .choices = {{"box", "sphere", "capsule", "below", "above", "bone_distance", "depth", "volume_share",
                   "joints", "material", "object", "painted", "everywhere"}}};
  return table;
}

void read_keys(const toml::table& table, Box& box) {
  read_rows(table, box_rows(), box);
}
Json json_of(const Box& box) {
  return json_of_rows(box_rows(), box);
}

void read_keys(const toml::table& table, Sphere& sphere) {
  read_rows(table, sphere_rows(), sphere);
}
Json json_of(const Sphere& sphere) {
  return json_of_rows(sphere_rows(), sphere);
}

void read_keys(const toml::table& table, Capsule& capsule) {
  read_rows(table, capsule_rows(), capsule);
}
Json json_of(const Capsule& capsule) {
  return json_of_rows(capsule_rows(), capsule);
}

void read_keys(const toml::table& table, HalfSpace& half_space) {
  read_rows(table, half_space_rows(), half_space);
}
Json json_of(const HalfSpace& half_space) {
  Json object = json_of_rows(half_space_rows(), half_space);
  object[half_space.is_fraction ? "fraction" : "value"] = half_space.value;
  return object;
}

void read_keys(const toml::table& table, BoneDistance& bone_distance) {
  read_rows(table, bone_distance_rows(), bone_distance);
}
Json json_of(const BoneDistance& bone_distance) {
  return json_of_rows(bone_distance_rows(), bone_distance);
}

void read_keys(const toml::table& table, Depth& depth) {
  read_rows(table, depth_rows(), depth);
}
Json json_of(const Depth& depth) {
  return json_of_rows(depth_rows(), depth);
}

void read_keys(const toml::table& table, VolumeShare& volume_share) {
  read_rows(table, volume_share_rows(), volume_share);
}
Json json_of(const VolumeShare& volume_share) {
  return json_of_rows(volume_share_rows(), volume_share);
}

void read_keys(const toml::table& table, JointSet& joint_set) {
  read_rows(table, joint_set_rows(), joint_set);
}
Json json_of(const JointSet& joint_set) {
  return json_of_rows(joint_set_rows(), joint_set);
}

void read_keys(const toml::table& table, PartSet& part_set) {
  read_rows(table, part_set_rows(), part_set);
}
Json json_of(const PartSet& part_set) {
  return json_of_rows(part_set_rows(), part_set);
}

void read_keys(const toml::table& table, Painted& painted) {
  read_rows(table, painted_rows(), painted);
}
Json json_of(const Painted& painted) {
  return json_of_rows(painted_rows(), painted);
}

}  // namespace fascicle::scene
