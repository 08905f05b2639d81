#include "host/made/made_bear.h"

#include "host/made/made_motion.h"

namespace fascicle::made {
namespace {

constexpr double bear_spacing = 0.03;  // m

}  // namespace

Vector3d mirrored(const Vector3d& place, std::size_t side) {
  return side == 0 ? place : Vector3d(-place.x(), place.y(), place.z());
}

BearJoints add_bear_skeleton(rig::Character& character) {
  BearJoints j{};
  const auto add = [&](const std::string& name, std::uint32_t parent, const Vector3d& place) {
    return add_joint(character, name, static_cast<std::int32_t>(parent), place);
  };
  j.hips = add_joint(character, "hips", -1, {0.0, 0.72, -0.02});
  j.spine = add("spine", j.hips, {0.0, 0.86, -0.04});
  j.chest = add("chest", j.spine, {0.0, 1.02, -0.04});
  j.neck = add("neck", j.chest, {0.0, 1.19, -0.01});
  j.head = add("head", j.neck, {0.0, 1.28, 0.01});
  for (std::size_t side = 0; side < 2; ++side) {
    const std::string end = side == 0 ? "_L" : "_R";
    const auto at = [&](double x, double y, double z) { return mirrored({x, y, z}, side); };
    j.shoulder[side] = add("shoulder" + end, j.chest, at(0.05, 1.13, -0.02));
    j.upper_arm[side] = add("upper_arm" + end, j.shoulder[side], at(0.20, 1.12, -0.02));
    j.forearm[side] = add("forearm" + end, j.upper_arm[side], at(0.395, 0.955, -0.02));
    j.hand[side] = add("hand" + end, j.forearm[side], at(0.56, 0.80, 0.01));
    j.thigh[side] = add("thigh" + end, j.hips, at(0.115, 0.67, -0.01));
    j.shin[side] = add("shin" + end, j.thigh[side], at(0.165, 0.385, 0.03));
    j.foot[side] = add("foot" + end, j.shin[side], at(0.195, 0.09, -0.02));
    j.toe[side] = add("toe" + end, j.foot[side], at(0.225, 0.035, 0.10));
  }
  return j;
}

Sculpture bear_sculpture(const BearJoints& j, const rig::Character& character) {
  Sculpture bear;
  bear.floor = 0.0;
  const auto at = [&](std::uint32_t joint) { return bind_place(character.skeleton[joint]); };
  const auto cone = [&](std::uint32_t joint, double blend, const Vector3d& from, double from_radius,
                        const Vector3d& to, double to_radius) {
    bear.parts.push_back({from, to, from_radius, to_radius, joint, blend});
  };
  const auto ball = [&](std::uint32_t joint, double blend, const Vector3d& place, double radius) {
    cone(joint, blend, place, radius, place, radius);
  };
  // Trunk, from the bottom: seat, belly, chest, and the yoke of the shoulders.
  cone(j.hips, 0.0, {-0.09, 0.70, -0.05}, 0.165, {0.09, 0.70, -0.05}, 0.165);
  cone(j.spine, 0.08, {-0.04, 0.81, 0.095}, 0.235, {0.04, 0.81, 0.095}, 0.235);
  cone(j.spine, 0.10, {0.0, 0.92, 0.06}, 0.225, {0.0, 0.99, 0.03}, 0.19);
  cone(j.chest, 0.10, {-0.08, 1.06, 0.0}, 0.16, {0.08, 1.06, 0.0}, 0.16);
  ball(j.hips, 0.03, {0.0, 0.74, -0.225}, 0.06);
  cone(j.neck, 0.08, {0.0, 1.15, 0.0}, 0.12, {0.0, 1.26, 0.01}, 0.11);
  // Head: skull, cheeks, muzzle, nose, brows, ears.
  cone(j.head, 0.05, {-0.035, 1.405, 0.02}, 0.172, {0.035, 1.405, 0.02}, 0.172);
  cone(j.head, 0.06, {-0.095, 1.335, 0.065}, 0.1, {0.095, 1.335, 0.065}, 0.1);
  cone(j.head, 0.04, {-0.012, 1.355, 0.15}, 0.095, {-0.008, 1.34, 0.215}, 0.076);
  cone(j.head, 0.04, {0.012, 1.355, 0.15}, 0.095, {0.008, 1.34, 0.215}, 0.076);
  cone(j.head, 0.01, {-0.012, 1.392, 0.275}, 0.034, {0.012, 1.392, 0.275}, 0.034);
  for (std::size_t side = 0; side < 2; ++side) {
    const auto mirror = [&](double x, double y, double z) { return mirrored({x, y, z}, side); };
    ball(j.head, 0.015, mirror(0.078, 1.462, 0.145), 0.046);
    cone(j.head, 0.03, mirror(0.14, 1.535, 0.0), 0.06, mirror(0.168, 1.575, -0.005), 0.066);
    cone(j.shoulder[side], 0.07, mirror(0.07, 1.12, -0.02), 0.115, mirror(0.17, 1.115, -0.02), 0.105);
    cone(j.upper_arm[side], 0.06, at(j.upper_arm[side]), 0.098, at(j.forearm[side]), 0.07);
    const Vector3d elbow = at(j.forearm[side]), wrist = at(j.hand[side]);
    const Vector3d thickest = elbow + 0.35 * (wrist - elbow);
    cone(j.forearm[side], 0.01, elbow, 0.07, thickest, 0.078);
    cone(j.forearm[side], 0.02, thickest, 0.078, wrist, 0.056);
    cone(j.hand[side], 0.03, wrist, 0.058, mirror(0.60, 0.755, 0.025), 0.068);
    cone(j.hand[side], 0.03, mirror(0.60, 0.755, 0.025), 0.068, mirror(0.635, 0.71, 0.04), 0.055);
    cone(j.hand[side], 0.02, mirror(0.575, 0.785, 0.06), 0.03, mirror(0.585, 0.755, 0.105), 0.03);
    cone(j.thigh[side], 0.07, mirror(0.125, 0.66, -0.015), 0.16, at(j.shin[side]), 0.098);
    const Vector3d knee = at(j.shin[side]), ankle = at(j.foot[side]);
    const Vector3d calf = knee + 0.3 * (ankle - knee) + Vector3d(0.0, 0.0, -0.02);
    cone(j.shin[side], 0.01, knee, 0.092, calf, 0.098);
    cone(j.shin[side], 0.01, calf, 0.098, ankle, 0.066);
    cone(j.foot[side], 0.04, mirror(0.192, 0.05, -0.05), 0.062, mirror(0.22, 0.045, 0.09), 0.072);
    cone(j.toe[side], 0.03, mirror(0.222, 0.045, 0.10), 0.072, mirror(0.235, 0.04, 0.155), 0.06);
  }
  return bear;
}

rig::Character make_bear() {
  rig::Character bear;
  const BearJoints joints = add_bear_skeleton(bear);
  const Sculpture sculpture = bear_sculpture(joints, bear);
  bear.surface = polygonise(sculpture, bear_spacing);
  bind_skin(sculpture, bear);
  const std::vector<PartMass> masses = masses_of_joints(sculpture, bear.skeleton.size(), 0.04);
  bear.clips.push_back(bear_jump(bear, joints, masses));
  bear.clips.push_back(bear_bump(bear, joints, masses));
  return bear;
}

}  // namespace fascicle::made
