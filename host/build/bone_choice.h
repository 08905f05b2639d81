// Which joints of a skeleton are bones, judged by the skin they move and not by their names.
//
// Two measures of a joint, both of the skin that it and the joints below it move, where a bit of skin of area
// a and outward normal n counts by w, the part of its weights that these joints hold:
//   share     sum w a / sum a, its part of the whole skin.
//   openness  |sum w a n| / sum w a. By the divergence theorem the numerator is the area of the hole that is
//             left where this skin is cut from the rest. Skin that surrounds an axis faces all ways and
//             cancels: a limb has 0.05 to 0.3; a half ball has 1/2, and flesh that lies on a trunk more
//             (breasts 0.8).
// A joint is a bone where the share is large, the openness small, and its axis (the segment to the next bone
// below it) runs inside the skin for half of its length or more: that of a root on the floor does not. Thin
// or oddly weighted skins are opener than limbs are, so that a joint of a large share is one, too,
//   - between two bones (a shoulder, a thigh), whatever its openness;
//   - where it goes on from a bone above with half of its skin or more (a head).
// Joints that are alike on both sides are alike in this too: one that is a little too small or too open is a
// bone where its like is one. A short limb of two joints, both too open, ends in the lower one: it is a bone,
// and so is what it hangs on. A root outside the skin that moves next to none of it is a control, and no
// bone. A joint that ends a chain in the skeleton leads on where its skin goes over into that of a joint
// elsewhere in it (joint_skin.h, Meeting): a shank to a foot that is an IK target of its own, which is a bone
// whatever its share.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "host/build/body.h"

namespace fascicle::build {

// Skin surrounds its axis up to the first, and lies on something from the second on. Between them (ears) it
// does neither.
inline constexpr double most_open_limb = 1.0 / 3.0;
inline constexpr double least_open_flesh = 0.5;

struct BoneChoice {
  std::vector<JointReport> report;  // one for each joint of the skeleton
  std::vector<JointUse> joints;     // the same
  std::vector<Bone> bones;
};

// Coordinates are multiplied by `scale`. The bones run from each chosen joint to each of the next chosen ones
// below it, or to where its skin goes over into another's. A chosen joint that ends a chain gives one towards
// the middle of its skin, as far as most of that reaches. Every JointReport gets its reason.
//
// Ends (head, hand, foot) are kinematic: their flesh follows the skeleton. So are joints that are no bones,
// but for flesh that lies on a trunk: openness of at least least_open_flesh, and above it a bone that ends no
// chain, or a share that a bone would have (jowls). A joint that a clip turns by more than 20 degrees against
// its parent (a pig's ear) bears no such flesh. A joint that ends a chain beside a bone of its parent's,
// around which its skin lies (a twist joint), is part of that bone.
//
// All of it can be overridden by `settings`. Throws scene::SceneError for names that no joint has, and for an
// inverse bind matrix that has no inverse.
BoneChoice choose_bones(const rig::Character& character, const scene::SkeletonSettings& settings,
                        double scale, const std::string& source);

}  // namespace fascicle::build
