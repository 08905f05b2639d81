#include "host/scene/scene_table_parts.h"

namespace fascicle::scene {
namespace {

// Owns the tables: they point at each other.
struct ShapeTables {
  Table box{.name = "box",
            .doc = "An axis-aligned box, faces included.",
            .keys = {point("minimum", "Lowest corner, m."), point("maximum", "Highest corner, m.")}};

  Table sphere{
      .name = "sphere",
      .doc = "A ball, surface included.",
      .keys = {point("center", "Middle, m."),
               {.name = "radius", .doc = "Radius, m.", .range = positive(farthest), .required = true}}};

  Table capsule{
      .name = "capsule",
      .doc = "All points within a radius of a segment.",
      .keys = {point("from", "One end of the segment, m."),
               point("to", "Its other end, m."),
               {.name = "radius", .doc = "Radius, m.", .range = positive(farthest), .required = true}}};

  Table half_space{
      .name = "half_space",
      .doc = "One side of a plane across an axis, the plane included.",
      .keys =
          {{.name = "axis",
            .type = KeyType::text,
            .doc = "Axis the plane stands across.",
            .fallback = "y",
            .allowed = {"x", "y", "z"}},
           {.name = "value", .doc = "Where the plane cuts the axis, m.", .range = coordinate},
           {.name = "fraction",
            .doc =
                "Where the plane cuts the axis, as a fraction of the mesh's bounding box from its low side.",
            .range = between(0.0, 1.0)}},
      .choices = {{"value", "fraction"}}};

  Key per_bone{.name = "per_bone",
               .type = KeyType::named_numbers,
               .doc = "Other maxima, by the name of the joint whose bone is the nearest.",
               .range = between(0.0, farthest)};

  Table bone_distance{
      .name = "bone_distance",
      .doc = "Points by their distance to the nearest bone: [bones.NAME], or the character's own.",
      .keys = {{.name = "minimum",
                .doc = "Smallest distance, m.",
                .range = between(0.0, farthest),
                .fallback = BoneDistance{}.minimum},
               {.name = "maximum",
                .doc = "Largest distance, m.",
                .range = between(0.0, farthest),
                .required = true},
               per_bone}};

  Table depth{
      .name = "depth",
      .doc = "Points by their relative depth: 0 at the nearest bone, 1 at the skin.",
      .keys = {{.name = "minimum",
                .doc = "Smallest depth.",
                .range = between(0.0, 1.0),
                .fallback = Depth{}.minimum},
               {.name = "maximum", .doc = "Largest depth.", .range = between(0.0, 1.0), .required = true},
               per_bone}};

  Table volume_share{
      .name = "volume_share",
      .doc =
          "Points by the share of the body's volume that lies nearer to the bones. Flesh that follows "
          "the skeleton by its joints (heads, hands, feet) is not counted.",
      .keys = {{.name = "minimum",
                .doc = "Share at the inner side.",
                .range = between(0.0, 1.0),
                .fallback = VolumeShare{}.minimum},
               {.name = "maximum",
                .doc = "Share at the outer side.",
                .range = between(0.0, 1.0),
                .required = true},
               {.name = "by",
                .type = KeyType::text,
                .doc = "What nearer means: relative depth, or distance from the bone.",
                .fallback = "depth",
                .allowed = {"depth", "distance"}}}};

  Table joint_set{.name = "joint_set",
                  .doc = "Points by the joints of a character that move them.",
                  .keys = {{.name = "names",
                            .type = KeyType::texts,
                            .doc = "The joints, with all below them unless below = false.",
                            .required = true},
                           {.name = "share",
                            .doc = "Least share of their weights that a point follows.",
                            .range = positive(1.0),
                            .fallback = JointSet{}.share},
                           {.name = "below",
                            .type = KeyType::boolean,
                            .doc = "Whether the joints below those named count too.",
                            .fallback = JointSet{}.below}}};

  Table part_set{
      .name = "part_set",
      .doc = "Points by what the nearest skin belongs to in the character's file.",
      .keys = {{.name = "names", .type = KeyType::texts, .doc = "As the file has them.", .required = true}}};

  Table painted{
      .name = "painted",
      .doc = "Points by a value painted on a character's vertices. Paint counts before all other shapes.",
      .keys = {{.name = "attribute",
                .type = KeyType::text,
                .doc = "The glTF attribute: _NAME, or COLOR_n with a channel, such as COLOR_0.r.",
                .required = true},
               {.name = "minimum", .doc = "Smallest value.", .range = coordinate, .required = true},
               {.name = "maximum", .doc = "Largest value.", .range = coordinate, .required = true}}};

  Table shape{
      .name = "shape",
      .doc = "A part of space; of several in an array, any.",
      .keys =
          {{.name = "box", .type = KeyType::table, .doc = "Inside a box.", .table = &box},
           {.name = "sphere", .type = KeyType::table, .doc = "Inside a ball.", .table = &sphere},
           {.name = "capsule", .type = KeyType::table, .doc = "Near a segment.", .table = &capsule},
           {.name = "below", .type = KeyType::table, .doc = "Below a plane.", .table = &half_space},
           {.name = "above", .type = KeyType::table, .doc = "Above a plane.", .table = &half_space},
           {.name = "bone_distance", .type = KeyType::table, .doc = "Near a bone.", .table = &bone_distance},
           {.name = "depth", .type = KeyType::table, .doc = "Deep or shallow.", .table = &depth},
           {.name = "volume_share",
            .type = KeyType::table,
            .doc = "A share of the volume.",
            .table = &volume_share},
           {.name = "joints", .type = KeyType::table, .doc = "What joints move.", .table = &joint_set},
           {.name = "material",
            .type = KeyType::table,
            .doc = "Below skin of these materials.",
            .table = &part_set},
           {.name = "object",
            .type = KeyType::table,
            .doc = "Below skin of these objects.",
            .table = &part_set},
           {.name = "painted", .type = KeyType::table, .doc = "Where it is painted.", .table = &painted},
           {.name = "everywhere", .type = KeyType::boolean, .doc = "All of space: everywhere = true."}},
      .choices = {{"box", "sphere", "capsule", "below", "above", "bone_distance", "depth", "volume_share",
                   "joints", "material", "object", "painted", "everywhere"}}};
};

}  // namespace

const Table& shape_table() {
  static const ShapeTables tables;
  return tables.shape;
}

}  // namespace fascicle::scene
