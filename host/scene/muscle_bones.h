// Resolves a muscle's names against the skeleton: which joint bends, which bone carries the muscle, what
// twists it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host/scene/scene.h"

namespace fascicle::scene {

// Two bones that meet at a joint, as joint indices.
struct BendingJoint {
  std::uint32_t upper = 0;  // where the upper bone starts
  std::uint32_t joint = 0;
  std::optional<std::uint32_t> lower_end;  // where the lower bone ends; nullopt: at `tip`
  Vector3d tip = Vector3d::Zero();         // the lower bone's end in the bind pose, metres of the file
};

struct MuscleBones {
  std::optional<BendingJoint> bend;
  std::uint32_t carrier = 0;         // the joint whose frame the muscle uses: the last one along its bone
  Vector3d from = Vector3d::Zero();  // the bone that carries it, in the bind pose, metres of the file
  Vector3d to = Vector3d::Zero();
  std::vector<char> moves;               // per joint: whether it moves flesh of that bone
  std::uint32_t twisted = 0;             // the joint whose rotation about the bone twists it
  std::optional<std::uint32_t> against;  // relative to this one; nullopt: to the file's axes
};

// A joint's position in the bind pose, in metres of the file.
Vector3d joint_place(const rig::Joint& joint);

// Throws SceneError, "muscle.NAME.KEY: ...", if a joint does not exist, if bones do not follow each other, or
// if a bone has no length.
MuscleBones muscle_bones(const rig::Character& character, const Muscle& muscle);

// The clip channel that drives a muscle's contraction. Throws SceneError if the text cannot name a channel.
struct ContractionChannel {
  std::uint32_t joint = 0;
  rig::ChannelPath path = rig::ChannelPath::translation;
  std::uint32_t axis = 0;
};
ContractionChannel contraction_channel(const rig::Character& character, const Muscle& muscle);
// Null if there is no clip, or it does not key the channel.
const rig::Channel* find_channel(const rig::Clip* clip, const ContractionChannel& wanted);

// A curve's value: linear between keys, constant before the first and after the last. At least one key.
double value_at(const KeyedCurve& curve, double x);

}  // namespace fascicle::scene
