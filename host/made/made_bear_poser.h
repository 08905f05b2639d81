// How a clip of the bear is animated. Curves pose spine and arms, feet stay in place or are lifted; the hips
// follow from the centre of mass, and the legs reach from the hips to the feet.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "host/made/made_bear.h"
#include "host/made/made_motion.h"

namespace fascicle::made {

// All angles in degrees. Pitches lean forward, relative to the joint below.
struct BearCurves {
  Curve hips_pitch, spine_pitch, head_pitch, clavicle;
  // Direction of the left upper arm in the chest's axes: swing forward and up from straight down, and spread
  // away from the body.
  Curve arm_swing, arm_spread, elbow;
  Curve heel;  // the lift of the heel, rotating about the ball of the foot
};

struct BearMoves {
  BearCurves curves;
  std::function<Vector3d(double time)> centre;   // m; the centre of mass relative to the bind pose
  std::function<double(double time)> foot_lift;  // m; height of the feet above the ground
};

// `masses`: one per joint.
rig::Clip clip_of_moves(const rig::Character& character, const BearJoints& joints,
                        const std::vector<PartMass>& masses, const BearMoves& moves, const std::string& name,
                        double duration);

}  // namespace fascicle::made
