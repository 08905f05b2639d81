// The bear and its clips; see made_character.h.
#pragma once

#include <array>
#include <cstdint>

#include "host/made/made_shape.h"
#include "host/rig/character.h"

namespace fascicle::made {

// Indices of the bear's joints. In pairs, the first is the left one, on the side of +x.
struct BearJoints {
  std::uint32_t hips, spine, chest, neck, head;
  std::array<std::uint32_t, 2> shoulder, upper_arm, forearm, hand, thigh, shin, foot, toe;
};

// A point on the left side of the bear, or its mirror image: side 0 or 1.
Vector3d mirrored(const Vector3d& place, std::size_t side);

BearJoints add_bear_skeleton(rig::Character& character);
Sculpture bear_sculpture(const BearJoints& joints, const rig::Character& character);

// Gravity, and the start and length of the jump's flight: from take-off to landing the centre of mass follows
// a parabola.
inline constexpr double jump_gravity = 9.81;                       // m/s^2
inline constexpr double jump_take_off = 1.10, jump_flight = 0.56;  // s

// `masses`: one per joint.
rig::Clip bear_jump(const rig::Character& character, const BearJoints& joints,
                    const std::vector<PartMass>& masses);

// How far the belly bump moves the centre of mass forward, m.
inline constexpr double bump_reach = 0.15;
rig::Clip bear_bump(const rig::Character& character, const BearJoints& joints,
                    const std::vector<PartMass>& masses);

rig::Character make_bear();

}  // namespace fascicle::made
