// The bear bumps into someone with its belly: it crouches and draws back, throws hips and belly forward, and
// sways back. Its feet stay on the ground.
#include "host/made/made_bear_poser.h"

namespace fascicle::made {
namespace {

constexpr double bump_duration = 2.2;  // s

BearCurves bump_curves() {
  return {.hips_pitch = Curve({{0.10, 0}, {0.55, 14}, {0.95, -13}, {1.10, -13}, {1.55, 5}, {2.10, 0}}),
          .spine_pitch = Curve({{0.10, 0}, {0.55, 6}, {0.97, -7}, {1.12, -7}, {1.58, 3}, {2.10, 0}}),
          .head_pitch = Curve({{0.10, 0}, {0.55, -14}, {1.00, 12}, {1.15, 12}, {1.60, -4}, {2.10, 0}}),
          .clavicle = Curve({{0.10, 0}, {0.60, -3}, {1.00, 6}, {1.20, 6}, {1.70, 0}}),
          .arm_swing = Curve({{0.10, 8}, {0.55, 2}, {0.98, -34}, {1.15, -34}, {1.60, 16}, {2.15, 8}}),
          .arm_spread = Curve({{0.10, 44}, {0.55, 40}, {1.00, 62}, {1.20, 62}, {1.70, 42}, {2.15, 44}}),
          .elbow = Curve({{0.10, 14}, {0.55, 34}, {1.00, 24}, {1.20, 24}, {1.70, 18}, {2.15, 14}}),
          .heel = Curve({{0.58, 0}, {0.90, 20}, {1.14, 20}, {1.46, 0}})};
}

}  // namespace

rig::Clip bear_bump(const rig::Character& character, const BearJoints& joints,
                    const std::vector<PartMass>& masses) {
  const Curve forward(
      {{0.10, 0}, {0.55, -0.07}, {0.98, bump_reach}, {1.10, bump_reach}, {1.60, -0.04}, {2.10, 0}});
  const Curve up({{0.10, 0}, {0.55, -0.075}, {0.98, 0.0}, {1.12, 0.0}, {1.60, -0.03}, {2.10, 0}});
  const BearMoves moves{.curves = bump_curves(),
                        .centre = [&](double time) { return Vector3d(0.0, up.at(time), forward.at(time)); },
                        .foot_lift = [](double) { return 0.0; }};
  return clip_of_moves(character, joints, masses, moves, "bump", bump_duration);
}

}  // namespace fascicle::made
