// The bear's jump. The animated quantity is the centre of mass: keys move it up and down and so time the push
// off the ground; in the air it follows a parabola.
#include <cmath>
#include <cstddef>

#include "host/made/made_bear_poser.h"

namespace fascicle::made {
namespace {

constexpr double jump_duration = 3.2;
constexpr double landing = jump_take_off + jump_flight;
// Height of the centre of mass relative to the bind pose, m: higher at take-off, because the arms are up.
constexpr double standing_height = -0.012, take_off_height = 0.075, landing_height = -0.022;
constexpr double take_off_speed =
    (landing_height - take_off_height) / jump_flight + jump_gravity * jump_flight / 2.0;  // m/s
constexpr double landing_speed = take_off_speed - jump_gravity * jump_flight;

// Heights of the centre of mass relative to the bind pose.
const std::vector<MotionKey>& heave() {
  static const std::vector<MotionKey> keys{{0.20, standing_height, 0.0, 0.0},
                                           {0.87, -0.18, 0.0, 6.0},
                                           {jump_take_off, take_off_height, take_off_speed, -jump_gravity},
                                           {landing, landing_height, landing_speed, -jump_gravity},
                                           {landing + 0.23, -0.255, 0.0, 6.0},
                                           {landing + 0.85, -0.006, 0.0, -0.2},
                                           {landing + 1.20, standing_height, 0.0, 0.0}};
  return keys;
}

BearCurves jump_curves() {
  return {
      .hips_pitch = Curve({{0.20, 0},
                           {0.72, 26},
                           {0.98, 8},
                           {1.14, -6},
                           {1.40, 4},
                           {1.60, 8},
                           {1.92, 26},
                           {2.45, -1},
                           {2.85, 0}}),
      .spine_pitch = Curve({{0.22, 0},
                            {0.70, 12},
                            {1.05, -6},
                            {1.20, -9},
                            {1.45, 3},
                            {1.62, 4},
                            {1.94, 13},
                            {2.44, -2},
                            {2.85, 0}}),
      .head_pitch = Curve(
          {{0.22, 0}, {0.68, -24}, {1.06, -10}, {1.30, -4}, {1.62, 2}, {1.98, -22}, {2.48, 3}, {2.95, 0}}),
      .clavicle =
          Curve({{0.25, 0}, {0.72, -4}, {1.10, 26}, {1.35, 24}, {1.66, 8}, {1.96, -3}, {2.45, 2}, {2.85, 0}}),

      .arm_swing = Curve({{0.20, 8},
                          {0.66, -48},
                          {0.76, -46},
                          {1.12, 120},
                          {1.30, 140},
                          {1.66, 96},
                          {1.98, 14},
                          {2.20, -4},
                          {2.60, 11},
                          {3.00, 8}}),
      .arm_spread = Curve({{0.22, 44},
                           {0.72, 40},
                           {0.95, 46},
                           {1.12, 30},
                           {1.38, 36},
                           {1.66, 60},
                           {2.00, 54},
                           {2.45, 43},
                           {2.90, 44}}),
      .elbow = Curve({{0.22, 14},
                      {0.72, 22},
                      {0.95, 60},
                      {1.14, 22},
                      {1.40, 30},
                      {1.66, 44},
                      {1.98, 34},
                      {2.45, 12},
                      {2.95, 14}}),

      .heel = Curve({{0.86, 0},
                     {jump_take_off, 40},
                     {jump_take_off + 0.10, 48},
                     {jump_take_off + 0.30, 22},
                     {landing - 0.06, 26},
                     {landing, 20},
                     {landing + 0.07, 0}})};
}

// How far a foot is off the ground: rises with the body in the air, starting and ending smoothly.
double foot_lift(double time) {
  const double u = time - jump_take_off;
  if (u <= 0.0 || u >= jump_flight) return 0.0;
  const double height =
      take_off_speed * u - 0.5 * jump_gravity * u * u - (landing_height - take_off_height) * u / jump_flight;
  const double tucked = 0.06 * 16.0 * u * u * (jump_flight - u) * (jump_flight - u) /
                        (jump_flight * jump_flight * jump_flight * jump_flight);
  const auto ease = [](double s) { return s >= 1.0 ? 1.0 : s * s * (3.0 - 2.0 * s); };
  constexpr double ease_time = 0.06;
  return height * ease(u / ease_time) * ease((jump_flight - u) / ease_time) + tucked;
}

}  // namespace

rig::Clip bear_jump(const rig::Character& character, const BearJoints& joints,
                    const std::vector<PartMass>& masses) {
  const BearMoves moves{.curves = jump_curves(),
                        .centre = [](double time) { return Vector3d(0.0, motion_at(heave(), time), 0.0); },
                        .foot_lift = foot_lift};
  return clip_of_moves(character, joints, masses, moves, "jump", jump_duration);
}

}  // namespace fascicle::made
