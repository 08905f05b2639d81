#include "host/scene/muscle_bones.h"

#include <algorithm>

#include <Eigen/LU>

#include "host/base/nearest_name.h"
#include "host/scene/scene_table.h"

namespace fascicle::scene {
namespace {

// Joints nearer to each other than this fraction of the skeleton's extent count as coincident.
constexpr double same_place = 1e-4;

class Finder {
 public:
  Finder(const rig::Character& character, const Muscle& muscle)
      : joints_(character.skeleton), muscle_(muscle) {
    std::optional<Vector3d> low, high;
    for (const rig::Joint& joint : joints_) {
      place_.push_back(joint.skins ? joint_place(joint) : Vector3d(Vector3d::Zero()));
      if (!joint.skins) continue;
      low = low ? Vector3d(low->cwiseMin(place_.back())) : place_.back();
      high = high ? Vector3d(high->cwiseMax(place_.back())) : place_.back();
    }
    if (low) shortest_ = same_place * (*high - *low).norm();
    // Skin weight of each joint and all joints below it.
    skin_.assign(joints_.size(), 0.0);
    for (std::size_t v = 0; v < character.joints.size(); ++v)
      for (std::size_t k = 0; k < 8; ++k) skin_[character.joints[v][k]] += character.weights[v][k];
    middle_.assign(joints_.size(), Vector3d::Zero());
    for (std::size_t v = 0; v < character.joints.size(); ++v)
      for (std::size_t k = 0; k < 8; ++k)
        middle_[character.joints[v][k]] += character.weights[v][k] * character.surface.vertices[v];
    for (std::size_t j = 0; j < joints_.size(); ++j)
      if (skin_[j] > 0.0) middle_[j] /= skin_[j];
    for (std::size_t j = joints_.size(); j-- > 0;)
      if (joints_[j].parent >= 0) skin_[static_cast<std::size_t>(joints_[j].parent)] += skin_[j];
  }

  MuscleBones find() {
    MuscleBones bones;
    bones.moves.assign(joints_.size(), 0);
    if (!muscle_.joint.empty()) bones.bend = bend();
    const std::uint32_t bone = muscle_.bone.empty() ? bones.bend->upper : named("bone", muscle_.bone);
    if (bones.bend && is_between(bones.bend->upper, bone, bones.bend->joint)) {
      carry(bones, bones.bend->upper, bones.bend->joint);
    } else if (bones.bend && is_lower(*bones.bend, bone)) {
      carry(bones, bones.bend->joint, bones.bend->lower_end);
      if (!bones.bend->lower_end) bones.to = bones.bend->tip;
    } else if (bones.bend) {
      refuse("bone", "\"" + muscle_.bone + "\" belongs neither to the upper bone (from " +
                         quoted(bones.bend->upper) + ") nor to the lower one (from " +
                         quoted(bones.bend->joint) + ") of the joint");
    } else {
      const std::optional<std::uint32_t> end = next_below(bone);
      carry(bones, bone, end);
      if (!end) bones.to = tip_of(bone);
    }
    if ((bones.to - bones.from).norm() <= shortest_) refuse("bone", "has no length");
    if (!muscle_.twist_joint.empty()) bones.twisted = named("twist_joint", muscle_.twist_joint);
    for (std::int32_t j = joints_[bones.twisted].parent; j >= 0 && !bones.against;
         j = joints_[static_cast<std::size_t>(j)].parent)
      if (joints_[static_cast<std::size_t>(j)].skins) bones.against = static_cast<std::uint32_t>(j);
    return bones;
  }

  std::uint32_t named(const char* key, const std::string& name) const {
    std::vector<std::string> names;
    for (std::uint32_t j = 0; j < joints_.size(); ++j) {
      // A node that skins nothing has no position in the bind pose. A channel does not need one.
      if (joints_[j].name == name && !joints_[j].skins && std::string_view(key) != "contraction_channel")
        refuse(key, "no vertex follows " + quoted(j) +
                        ", so it has no place in the bind pose; name another joint");
      if (joints_[j].name == name) return j;
      names.push_back(joints_[j].name);
    }
    refuse(key, "no joint is called \"" + name + "\"" + base::nearest_name_hint(name, names) +
                    "; `fascicle inspect` lists them");
  }

  [[noreturn]] void refuse(const char* key, const std::string& what) const {
    throw SceneError("muscle." + muscle_.name + "." + key + ": " + what);
  }

 private:
  std::string quoted(std::uint32_t joint) const { return '"' + joints_[joint].name + '"'; }
  bool is_elsewhere(std::uint32_t a, std::uint32_t b) const {
    return joints_[a].skins && joints_[b].skins && (place_[a] - place_[b]).norm() > shortest_;
  }

  // Whether `joint` is `top` or below it, and above `bottom`.
  bool is_between(std::uint32_t top, std::uint32_t joint, std::uint32_t bottom) const {
    return joint != bottom && is_at_or_below(joint, top) && is_at_or_below(bottom, joint);
  }
  bool is_at_or_below(std::uint32_t joint, std::uint32_t top) const {
    for (auto j = static_cast<std::int32_t>(joint); j >= 0; j = joints_[static_cast<std::size_t>(j)].parent)
      if (static_cast<std::uint32_t>(j) == top) return true;
    return false;
  }
  bool is_lower(const BendingJoint& bend, std::uint32_t joint) const {
    return bend.lower_end ? is_between(bend.joint, joint, *bend.lower_end) : joint == bend.joint;
  }

  // The nearest ancestor at a different position.
  std::optional<std::uint32_t> next_above(std::uint32_t joint) const {
    for (std::int32_t j = joints_[joint].parent; j >= 0; j = joints_[static_cast<std::size_t>(j)].parent)
      if (is_elsewhere(static_cast<std::uint32_t>(j), joint)) return static_cast<std::uint32_t>(j);
    return std::nullopt;
  }

  // Among the nearest descendants at a different position, the one that moves the most skin.
  std::optional<std::uint32_t> next_below(std::uint32_t joint) const {
    std::optional<std::uint32_t> best;
    for (std::uint32_t j = joint + 1; j < joints_.size(); ++j) {
      if (!is_elsewhere(j, joint) || !is_at_or_below(j, joint) || next_above(j) != joint) continue;
      if (!best || skin_[j] > skin_[*best]) best = j;
    }
    return best;
  }

  // A terminal bone ends at twice the distance from its joint to the centre of its skin.
  Vector3d tip_of(std::uint32_t joint) const { return 2.0 * middle_[joint] - place_[joint]; }

  BendingJoint bend() const {
    BendingJoint bend;
    bend.joint = named("joint", muscle_.joint);
    if (!muscle_.parent.empty()) {
      bend.upper = named("parent", muscle_.parent);
      if (bend.upper == bend.joint || !is_at_or_below(bend.joint, bend.upper))
        refuse("parent", quoted(bend.upper) + " is not above the joint " + quoted(bend.joint));
    } else {
      const std::optional<std::uint32_t> above = next_above(bend.joint);
      if (!above)
        refuse("joint", "above " + quoted(bend.joint) + " there is no joint, so it has no upper bone");
      bend.upper = *above;
    }
    if (!muscle_.child.empty()) {
      bend.lower_end = named("child", muscle_.child);
      if (*bend.lower_end == bend.joint || !is_at_or_below(*bend.lower_end, bend.joint))
        refuse("child", quoted(*bend.lower_end) + " is not below the joint " + quoted(bend.joint));
    } else {
      bend.lower_end = next_below(bend.joint);
    }
    bend.tip = bend.lower_end ? place_[*bend.lower_end] : tip_of(bend.joint);
    if (!is_elsewhere(bend.upper, bend.joint)) refuse("parent", "the upper bone has no length");
    if ((bend.tip - place_[bend.joint]).norm() <= shortest_) refuse("child", "the lower bone has no length");
    return bend;
  }

  // Fills in the bone from joint `top` to `end`, or from `top` to the end of the chain.
  void carry(MuscleBones& bones, std::uint32_t top, std::optional<std::uint32_t> end) const {
    bones.from = place_[top];
    bones.to = end ? place_[*end] : place_[top];
    bones.twisted = end.value_or(top);
    bones.carrier = top;
    bones.moves[top] = 1;
    if (!end) return;
    for (std::int32_t j = joints_[*end].parent; j >= 0; j = joints_[static_cast<std::size_t>(j)].parent) {
      const auto joint = static_cast<std::uint32_t>(j);
      if (bones.carrier == top && joints_[joint].skins) bones.carrier = joint;
      bones.moves[joint] = 1;
      if (joint == top) break;
    }
  }

  const std::vector<rig::Joint>& joints_;
  const Muscle& muscle_;
  std::vector<Vector3d> place_;
  std::vector<double> skin_;
  std::vector<Vector3d> middle_;
  double shortest_ = 0.0;
};

}  // namespace

Vector3d joint_place(const rig::Joint& joint) {
  // The point p that the inverse bind matrix maps to the joint's origin: L p + t = 0.
  const Eigen::Matrix3d linear = joint.inverse_bind.topLeftCorner<3, 3>();
  return -(linear.inverse() * joint.inverse_bind.topRightCorner<3, 1>());
}

MuscleBones muscle_bones(const rig::Character& character, const Muscle& muscle) {
  return Finder(character, muscle).find();
}

ContractionChannel contraction_channel(const rig::Character& character, const Muscle& muscle) {
  const Finder finder(character, muscle);
  const std::string& text = muscle.contraction_channel;
  const auto refuse = [&] {
    finder.refuse("contraction_channel",
                  "\"" + text +
                      "\" is not a channel; take a joint, translation or scale, and an axis, as "
                      "\"flex.translation.x\"");
  };
  const std::size_t axis = text.rfind('.');
  const std::size_t path =
      axis == std::string::npos || axis == 0 ? std::string::npos : text.rfind('.', axis - 1);
  if (path == std::string::npos || axis + 2 != text.size()) refuse();
  const std::string part = text.substr(path + 1, axis - path - 1);
  const char letter = text[axis + 1];
  if ((part != "translation" && part != "scale") || letter < 'x' || letter > 'z') refuse();
  return {finder.named("contraction_channel", text.substr(0, path)),
          part == "scale" ? rig::ChannelPath::scale : rig::ChannelPath::translation,
          static_cast<std::uint32_t>(letter - 'x')};
}

const rig::Channel* find_channel(const rig::Clip* clip, const ContractionChannel& wanted) {
  if (clip == nullptr) return nullptr;
  const auto found =
      std::find_if(clip->channels.begin(), clip->channels.end(), [&](const rig::Channel& channel) {
        return channel.joint == wanted.joint && channel.path == wanted.path;
      });
  return found == clip->channels.end() ? nullptr : &*found;
}

double value_at(const KeyedCurve& curve, double x) {
  const auto after = std::find_if(curve.begin(), curve.end(), [&](const auto& key) { return key.first > x; });
  if (after == curve.begin()) return curve.front().second;
  if (after == curve.end()) return curve.back().second;
  const auto& [x0, y0] = *(after - 1);
  const auto& [x1, y1] = *after;
  return y0 + (y1 - y0) * ((x - x0) / (x1 - x0));
}

}  // namespace fascicle::scene
