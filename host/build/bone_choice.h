// Decides which joints of a skeleton are bones, by the skin they move and not by their names.
//
// There are two measures of a joint, both of the skin that it and the joints below it move. A patch of skin
// with area a and outward normal n counts by w, the part of its weights that these joints hold:
//   share     sum w a / sum a, its part of the whole skin.
//   openness  |sum w a n| / sum w a. By the divergence theorem the numerator is the area of the hole that is
//             left when this skin is cut from the rest. Skin that surrounds an axis faces all ways and
//             cancels: a limb has 0.05 to 0.3. A hemisphere has 1/2, and flesh that lies on a trunk has more
//             (breasts 0.8).
//
// A joint is a bone if its share is large, its openness is small, and its axis (the segment to the next bone
// below it) runs inside the skin for at least half its length; the axis of a root on the floor does not. Thin
// or oddly weighted skins are more open than limbs, so a joint with a large share is also a bone
//   - between two bones (a shoulder, a thigh), whatever its openness;
//   - if it continues a bone above it and moves at least half of that bone's skin (a head).
// Matching joints on both sides get the same result: a joint that is slightly too small or too open is a bone
// if its counterpart is. A short limb of two joints that are both too open ends in the lower one: that joint
// is a bone, and so is the one it hangs on. A root outside the skin that moves almost none of it is a
// control, not a bone. A joint that ends a chain in the skeleton continues in another joint if their skins
// merge (joint_skin.h, Meeting), as a shank does in a foot that is a separate IK target; that joint is then a
// bone whatever its share.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "host/build/body.h"

namespace fascicle::build {

// Skin surrounds its axis up to the first value, and lies on something from the second on. In between (ears)
// it does neither.
inline constexpr double most_open_limb = 1.0 / 3.0;
inline constexpr double least_open_flesh = 0.5;

struct BoneChoice {
  std::vector<JointReport> report;  // one for each joint of the skeleton
  std::vector<JointUse> joints;     // the same
  std::vector<Bone> bones;
  // If most of the skin follows the skeleton only because its joints are too small to be bones: says so and
  // how to change that. Else empty.
  std::string warning;
};

// Coordinates are multiplied by `scale`. Bones run from each chosen joint to each of the next chosen joints
// below it, or to where its skin merges into another's. A chosen joint that ends a chain gets a bone towards
// the middle of its skin, as far as most of that skin reaches. Every JointReport gets its reason.
//
// Ends (head, hand, foot) are kinematic: their flesh follows the skeleton. So are joints that are not bones,
// except those whose flesh lies on a trunk: openness of at least least_open_flesh, and either a bone above it
// that ends no chain, or a share that is large enough for a bone (jowls). A joint that a clip turns by more
// than 20 degrees against its parent (a pig's ear) carries no such flesh. A joint that ends a chain beside
// another bone of its parent, and whose skin lies around that bone (a twist joint), is part of that bone.
//
// Skin marked in `is_left_out`, one flag per vertex or empty, does not count: a floor below the body.
// `settings` can override all of this. Throws scene::SceneError for names that no joint has, and for a
// singular inverse bind matrix.
BoneChoice choose_bones(const rig::Character& character, const scene::SkeletonSettings& settings,
                        double scale, const std::string& source, const std::vector<char>& is_left_out = {});

}  // namespace fascicle::build
