// How a clip of the bear is drawn. Spine and arms are posed by curves, feet stand where they stood or are
// lifted; the hips follow from the centre of mass, the legs reach from the hips to the feet.
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
  // Where the left upper arm points, in the chest's axes, by the hand on a clock: swing forward and up from
  // straight down, and how far it is spread from the body.
  Curve arm_swing, arm_spread, elbow;
  Curve heel;  // the heel's lift, turning about the ball of the foot
};

struct BearMoves {
  BearCurves curves;
  std::function<Vector3d(double time)> centre;   // m: the centre of mass from where the bind pose has it
  std::function<double(double time)> foot_lift;  // m: how far the feet are off the ground
};

// `masses` are the joints'.
rig::Clip clip_of_moves(const rig::Character& character, const BearJoints& joints,
                        const std::vector<PartMass>& masses, const BearMoves& moves, const std::string& name,
                        double duration);

}  // namespace fascicle::made
