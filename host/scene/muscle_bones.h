// From a muscle's words to the skeleton: which joint bends, which bone carries the muscle, what twists it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host/scene/scene.h"

namespace fascicle::scene {

// Two bones that meet in a joint, as numbers of joints.
struct BendingJoint {
  std::uint32_t upper = 0;  // where the upper bone begins
  std::uint32_t joint = 0;
  std::optional<std::uint32_t> lower_end;  // where the lower bone ends; nothing: at `tip`
  Vector3d tip = Vector3d::Zero();         // the lower bone's end in the bind pose, metres of the file
};

struct MuscleBones {
  std::optional<BendingJoint> bend;
  std::uint32_t carrier = 0;         // the joint whose frame is the muscle's: the last one along its bone
  Vector3d from = Vector3d::Zero();  // the bone that carries it, in the bind pose, metres of the file
  Vector3d to = Vector3d::Zero();
  std::vector<char> moves;               // one flag a joint: moves flesh of that bone
  std::uint32_t twisted = 0;             // the joint whose turn about the bone twists it
  std::optional<std::uint32_t> against;  // relative to this one; nothing: to the file's axes
};

// Where a joint stands in the bind pose, metres of the file.
Vector3d joint_place(const rig::Joint& joint);

// Throws SceneError, "muscle.NAME.KEY: ...", for a joint there is not, bones that do not follow each other,
// and bones without length.
MuscleBones muscle_bones(const rig::Character& character, const Muscle& muscle);

// The clip's channel for a muscle's contraction. Throws SceneError where the text names none that could be.
struct ContractionChannel {
  std::uint32_t joint = 0;
  rig::ChannelPath path = rig::ChannelPath::translation;
  std::uint32_t axis = 0;
};
ContractionChannel contraction_channel(const rig::Character& character, const Muscle& muscle);
// Null where the clip does not key it, or there is no clip.
const rig::Channel* find_channel(const rig::Clip* clip, const ContractionChannel& wanted);

// A curve's value: straight between keys, held before the first and after the last. At least one key.
double value_at(const KeyedCurve& curve, double x);

}  // namespace fascicle::scene
