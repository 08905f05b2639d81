// What supports, holds and moves the body: [bones.NAME], [skeleton], [fibres.NAME], [muscle.NAME],
// [pin.NAME], [probe.NAME], [force.NAME].
#include "host/scene/scene_keys.h"
#include "host/scene/scene_rows.h"

namespace fascicle::scene {
namespace {

const auto& bone_rows() {
  using namespace rows;
  static const std::tuple all{
      member("name", &BoneSegment::name),
      key(&BoneSegment::from, {.name = "from", .doc = "One end, m.", .range = coordinate, .required = true}),
      key(&BoneSegment::to,
          {.name = "to", .doc = "The other end, m.", .range = coordinate, .required = true})};
  static_assert(base::has_row_for_each_member<BoneSegment, decltype(all)>,
                "a member of BoneSegment has no row here");
  return all;
}

const auto& skeleton_rows() {
  using namespace rows;
  static const std::tuple all{
      key(&SkeletonSettings::bones, {.name = "bones", .doc = "Joints that are bones."}),
      key(&SkeletonSettings::not_bones, {.name = "not_bones", .doc = "Joints that are not bones."}),
      key(&SkeletonSettings::kinematic,
          {.name = "kinematic",
           .doc = "Joints whose flesh follows the skeleton, including all joints below them."}),
      key(&SkeletonSettings::simulated, {.name = "simulated",
                                         .doc = "Joints whose flesh is simulated, including all joints below "
                                                "them; takes precedence over kinematic."}),
      key(&SkeletonSettings::rigid,
          {.name = "rigid",
           .doc = "Joints (including all below them), objects or materials whose skin, and the flesh below "
                  "it, follows its joints alone, in addition to the rigid parts found from the weights."}),
      key(&SkeletonSettings::only, {.name = "only",
                                    .doc = "Joints whose flesh is simulated, including all joints below "
                                           "them; all other flesh follows the skeleton."}),
      key(&SkeletonSettings::least_share,
          {.name = "least_share",
           .doc = "Smallest share of the skin's area that a bone and the joints below it must move.",
           .range = between(0.0, 1.0)}),
      key(&SkeletonSettings::connect,
          {.name = "connect",
           .doc =
               "Extend bone layers that are measured from the bones along them until they are connected."})};
  static_assert(base::has_row_for_each_member<SkeletonSettings, decltype(all)>,
                "a member of SkeletonSettings has no row here");
  return all;
}

const auto& fibre_curve_rows() {
  using namespace rows;
  static const std::tuple all{
      member("name", &FibreCurve::name),
      key(&FibreCurve::points,
          {.name = "points", .doc = "Points of the polyline, m.", .range = coordinate, .required = true}),
      key(&FibreCurve::radius,
          {.name = "radius",
           .doc = "Distance from the line within which it acts, m. Default: the mean edge length.",
           .range = positive(farthest)})};
  static_assert(base::has_row_for_each_member<FibreCurve, decltype(all)>,
                "a member of FibreCurve has no row here");
  return all;
}

const auto& muscle_rows() {
  using namespace rows;
  static const std::tuple all{
      member("name", &Muscle::name),
      key(&Muscle::joint, {.name = "joint", .doc = "Joint whose bending makes the muscle bulge."},
          {.depends = true}),
      key(&Muscle::parent,
          {.name = "parent",
           .doc = "Joint where the upper bone begins. Default: the next joint above `joint`."},
          {.depends = true}),
      key(&Muscle::child,
          {.name = "child",
           .doc = "Joint where the lower bone ends. Default: of the next joints below `joint`, the one that "
                  "moves the most skin."},
          {.depends = true}),
      key(&Muscle::bone,
          {.name = "bone", .doc = "Joint whose bone carries the muscle. Default: that of the upper bone."},
          {.depends = true}),
      key(&Muscle::layer,
          {.name = "layer",
           .doc = "Layer that the muscle is limited to. Default: all layers that are not kinematic."},
          {.depends = true}),
      where_key(&Muscle::where, false,
                "Region that the muscle is limited to. Default: the whole length of the bone."),
      key(&Muscle::gain,
          {.name = "gain", .doc = "Strength of the bulge, equation (17).", .range = between(-10.0, 10.0)}),
      key(&Muscle::axis,
          {.name = "axis",
           .doc = "Direction of the bulge. flexion: outwards on the side to which the joint folds, inwards "
                  "on the other; plane-normal: along the normal of the plane of the two bones."}),
      key(&Muscle::activation,
          {.name = "activation",
           .doc = "Activation by joint angle, less its value in the bind pose. cosine: (1 - cos)/2, which "
                  "rises up to 180 degrees; sine: as in the paper, which falls beyond 90 degrees."}),
      key(&Muscle::curve,
          {.name = "curve",
           .doc = "Activation by joint angle, in place of `activation`: [[degrees, value], ...].",
           .range = between(-1e3, 1e3)}),
      key(&Muscle::contraction,
          {.name = "contraction",
           .doc = "Activation by clip time, independent of the joint: [[seconds, value], ...].",
           .range = between(-1e5, 1e5)}),
      key(&Muscle::contraction_channel,
          {.name = "contraction_channel",
           .doc = "Activation from a channel of the clip: joint, translation or scale, and axis, such as "
                  "flex.translation.x; its rest value counts as 0."}),
      key(&Muscle::twist, {.name = "twist",
                           .doc = "Share of the bone's twist that winds the fibres around it.",
                           .range = between(-1.0, 1.0)}),
      key(&Muscle::twist_joint,
          {.name = "twist_joint",
           .doc = "Joint whose rotation about the bone, relative to its parent, is the twist. Default: the "
                  "joint where the bone ends."},
          {.depends = true})};
  static_assert(base::has_row_for_each_member<Muscle, decltype(all)>, "a member of Muscle has no row here");
  return all;
}

const auto& pin_rows() {
  using namespace rows;
  static const std::tuple all{member("name", &Pin::name), where_key(&Pin::where, true, "Pinned vertices.")};
  static_assert(base::has_row_for_each_member<Pin, decltype(all)>, "a member of Pin has no row here");
  return all;
}

const auto& probe_rows() {
  using namespace rows;
  static const std::tuple all{member("name", &ProbeSet::name),
                              where_key(&ProbeSet::where, true, "Vertices of the probe.")};
  static_assert(base::has_row_for_each_member<ProbeSet, decltype(all)>,
                "a member of ProbeSet has no row here");
  return all;
}

const auto& force_rows() {
  using namespace rows;
  static const std::tuple all{
      member("name", &Force::name),
      key(&Force::kind,
          {.name = "kind",
           .doc = "wind: a pressure on the whole surface; point: a force distributed over vertices by mass.",
           .required = true}),
      key(&Force::vector, {.name = "vector",
                           .doc = "Direction and magnitude: Pa for wind, N for point.",
                           .range = between(-1e9, 1e9),
                           .required = true}),
      where_key(&Force::where, false,
                "Vertices that a point force acts on; required for point, not allowed for wind."),
      key(&Force::start, {.name = "start",
                          .doc = "Time from which the force acts, s. By default it always has, in preroll, "
                                 "settling and handles too.",
                          .range = between(-1e30, 1e30)}),
      key(&Force::end,
          {.name = "end", .doc = "Time before which the force acts, s.", .range = between(-1e5, 1e30)})};
  static_assert(base::has_row_for_each_member<Force, decltype(all)>, "a member of Force has no row here");
  return all;
}

}  // namespace

const Table& bone_table() {
  static const Table table = with_keys(
      {.name = "bone",
       .doc = "A bone drawn as a segment, from which layers can be measured, for example in a mesh without a "
              "skeleton."},
      bone_rows());
  return table;
}
void read_keys(const toml::table& table, BoneSegment& bone) {
  read_rows(table, bone_rows(), bone);
}
Json json_of(const BoneSegment& bone) {
  return json_of_rows(bone_rows(), bone);
}

const Table& skeleton_table() {
  static const Table table = with_keys(
      {.name = "skeleton",
       .doc =
           "Which joints are bones, and which flesh follows them. By default, both are found from the skin."},
      skeleton_rows());
  return table;
}
void read_keys(const toml::table& table, SkeletonSettings& skeleton) {
  read_rows(table, skeleton_rows(), skeleton);
}
Json json_of(const SkeletonSettings& skeleton) {
  return json_of_rows(skeleton_rows(), skeleton);
}

const Table& fibre_curve_table() {
  static const Table table = with_keys(
      {.name = "fibre_curve", .doc = "A polyline from origin to insertion that the fibre field follows."},
      fibre_curve_rows());
  return table;
}
void read_keys(const toml::table& table, FibreCurve& fibre_curve) {
  read_rows(table, fibre_curve_rows(), fibre_curve);
}
Json json_of(const FibreCurve& fibre_curve) {
  return json_of_rows(fibre_curve_rows(), fibre_curve);
}

const Table& muscle_table() {
  static const Table table = with_keys({.name = "muscle",
                                        .doc = "A muscle on a bone that bulges as a joint bends, or by an "
                                               "animated contraction: equations (15) to (17)."},
                                       muscle_rows());
  return table;
}
void read_keys(const toml::table& table, Muscle& muscle) {
  read_rows(table, muscle_rows(), muscle);
}
Json json_of(const Muscle& muscle) {
  return json_of_rows(muscle_rows(), muscle);
}

const Table& pin_table() {
  static const Table table = with_keys(
      {.name = "pin", .doc = "Vertices that are held fixed; on a character, they follow the skeleton."},
      pin_rows());
  return table;
}
Json json_of(const Pin& pin) {
  return json_of_rows(pin_rows(), pin);
}

const Table& probe_table() {
  static const Table table = with_keys(
      {.name = "probe", .doc = "Vertices whose mean position is written for each frame."}, probe_rows());
  return table;
}
Json json_of(const ProbeSet& probe) {
  return json_of_rows(probe_rows(), probe);
}

const Table& force_table() {
  static const Table table =
      with_keys({.name = "force", .doc = "A force in addition to gravity."}, force_rows());
  return table;
}
void read_keys(const toml::table& table, Force& force) {
  read_rows(table, force_rows(), force);
}
Json json_of(const Force& force) {
  return json_of_rows(force_rows(), force);
}

}  // namespace fascicle::scene
