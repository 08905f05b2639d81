// The bear's jump. The centre of mass is what is drawn: up and down by keys that give the ground's push its
// place in time, a parabola in the air. Spine and arms are posed by curves, feet stand where they stood or
// are lifted; the hips follow from the centre of mass, the legs reach from the hips to the feet.
#include <array>
#include <cmath>
#include <cstddef>

#include <Eigen/Geometry>

#include "host/made/made_bear.h"
#include "host/made/made_motion.h"

namespace fascicle::made {
namespace {

using Eigen::Matrix3d;

constexpr double jump_keys_a_second = 120.0;
constexpr double jump_duration = 3.2;
constexpr double landing = jump_take_off + jump_flight;
// Of the centre of mass over where it is in the bind pose, m: higher at take-off, because the arms are up.
constexpr double standing_height = -0.012, take_off_height = 0.075, landing_height = -0.022;
constexpr double take_off_speed =
    (landing_height - take_off_height) / jump_flight + jump_gravity * jump_flight / 2.0;  // m/s
constexpr double landing_speed = take_off_speed - jump_gravity * jump_flight;

const Vector3d right_to_left(1.0, 0.0, 0.0), upwards(0.0, 1.0, 0.0), forwards(0.0, 0.0, 1.0);

// Heights of the centre of mass over where it stands in the bind pose.
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

// All angles in degrees. Pitches lean forward, relative to the joint below.
struct Curves {
  Curve hips_pitch{{{0.20, 0},
                    {0.72, 26},
                    {0.98, 8},
                    {1.14, -6},
                    {1.40, 4},
                    {1.60, 8},
                    {1.92, 26},
                    {2.45, -1},
                    {2.85, 0}}};
  Curve spine_pitch{{{0.22, 0},
                     {0.70, 12},
                     {1.05, -6},
                     {1.20, -9},
                     {1.45, 3},
                     {1.62, 4},
                     {1.94, 13},
                     {2.44, -2},
                     {2.85, 0}}};
  Curve head_pitch{
      {{0.22, 0}, {0.68, -24}, {1.06, -10}, {1.30, -4}, {1.62, 2}, {1.98, -22}, {2.48, 3}, {2.95, 0}}};
  Curve clavicle{
      {{0.25, 0}, {0.72, -4}, {1.10, 26}, {1.35, 24}, {1.66, 8}, {1.96, -3}, {2.45, 2}, {2.85, 0}}};
  // Where the left upper arm points, in the chest's axes, by the hand on a clock: swing forward and up from
  // straight down, and how far it is spread from the body.
  Curve arm_swing{{{0.20, 8},
                   {0.66, -48},
                   {0.76, -46},
                   {1.12, 120},
                   {1.30, 140},
                   {1.66, 96},
                   {1.98, 14},
                   {2.20, -4},
                   {2.60, 11},
                   {3.00, 8}}};
  Curve arm_spread{{{0.22, 44},
                    {0.72, 40},
                    {0.95, 46},
                    {1.12, 30},
                    {1.38, 36},
                    {1.66, 60},
                    {2.00, 54},
                    {2.45, 43},
                    {2.90, 44}}};
  Curve elbow{{{0.22, 14},
               {0.72, 22},
               {0.95, 60},
               {1.14, 22},
               {1.40, 30},
               {1.66, 44},
               {1.98, 34},
               {2.45, 12},
               {2.95, 14}}};
  // The heel's lift, turning about the ball of the foot.
  Curve heel{{{0.86, 0},
              {jump_take_off, 40},
              {jump_take_off + 0.10, 48},
              {jump_take_off + 0.30, 22},
              {landing - 0.06, 26},
              {landing, 20},
              {landing + 0.07, 0}}};
};

// How far a foot is off the ground: with the body in the air, starting and ending without a jerk.
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

Vector3d centre_of_mass(const rig::Character& character, const WorldPose& pose,
                        const std::vector<PartMass>& masses) {
  const std::vector<Vector3d> places = places_of_joints(character, pose);
  Vector3d sum = Vector3d::Zero();
  double mass = 0.0;
  for (std::size_t j = 0; j < places.size(); ++j) {
    if (masses[j].mass <= 0.0) continue;
    sum +=
        masses[j].mass * (places[j] + pose.turns[j] * (masses[j].centre - bind_place(character.skeleton[j])));
    mass += masses[j].mass;
  }
  return sum / mass;
}

// The poses of one moment: everything above the hips first, then the hips' place, then the legs, and again,
// because the legs have a share in the centre of mass.
class BearPoser {
 public:
  BearPoser(const rig::Character& character, const BearJoints& joints, const std::vector<PartMass>& masses)
      : character_(character), joints_(joints), masses_(masses) {
    bind_.root = place(joints.hips);
    bind_.turns.assign(character.skeleton.size(), Matrix3d::Identity());
    bind_centre_ = centre_of_mass(character, bind_, masses);
  }

  WorldPose pose(double time) const {
    WorldPose pose = bind_;
    pose_trunk(time, pose);
    for (std::size_t side = 0; side < 2; ++side) pose_arm(time, side, pose);
    const Vector3d wanted = bind_centre_ + motion_at(heave(), time) * upwards;
    // Each round takes away most of what the last one left; see the test of the parabola.
    constexpr int rounds = 12;
    for (int round = 0; round < rounds; ++round) {
      for (std::size_t side = 0; side < 2; ++side) pose_leg(time, side, pose);
      pose.root += wanted - centre_of_mass(character_, pose, masses_);
    }
    for (std::size_t side = 0; side < 2; ++side) pose_leg(time, side, pose);
    return pose;
  }

 private:
  Vector3d place(std::uint32_t joint) const { return bind_place(character_.skeleton[joint]); }

  void pose_trunk(double time, WorldPose& pose) const {
    const auto pitch = [&](const Curve& curve) { return turn_about(right_to_left, degree * curve.at(time)); };
    const Matrix3d bend = pitch(curves_.spine_pitch);
    pose.turns[joints_.hips] = pitch(curves_.hips_pitch);
    pose.turns[joints_.spine] = pose.turns[joints_.hips] * bend;
    pose.turns[joints_.chest] = pose.turns[joints_.spine] * bend;
    const Matrix3d nod = turn_about(right_to_left, 0.5 * degree * curves_.head_pitch.at(time));
    pose.turns[joints_.neck] = pose.turns[joints_.chest] * nod;
    pose.turns[joints_.head] = pose.turns[joints_.neck] * nod;
  }

  void pose_arm(double time, std::size_t side, WorldPose& pose) const {
    const double sign = side == 0 ? 1.0 : -1.0;
    const std::uint32_t shoulder = joints_.shoulder[side], upper = joints_.upper_arm[side],
                        lower = joints_.forearm[side], hand = joints_.hand[side];
    pose.turns[shoulder] =
        pose.turns[joints_.chest] * turn_about(forwards, sign * degree * curves_.clavicle.at(time));
    const Matrix3d swing = turn_about(right_to_left, -degree * curves_.arm_swing.at(time));
    const Matrix3d spread = turn_about(forwards, sign * degree * curves_.arm_spread.at(time));
    const Vector3d bound = unit(place(lower) - place(upper));
    const Vector3d wanted = swing * (spread * Vector3d(0.0, -1.0, 0.0));
    pose.turns[upper] = pose.turns[joints_.chest] * shortest_turn(bound, wanted);
    const Vector3d elbow_hinge = unit(bound.cross(forwards));
    pose.turns[lower] = pose.turns[upper] * turn_about(elbow_hinge, degree * (curves_.elbow.at(time) - 14.0));
    pose.turns[hand] = pose.turns[lower];
  }

  void pose_leg(double time, std::size_t side, WorldPose& pose) const {
    const Vector3d hip = place(joints_.thigh[side]), knee = place(joints_.shin[side]),
                   ankle = place(joints_.foot[side]), ball = place(joints_.toe[side]);
    // The knee bends to where the foot points, and somewhat further out.
    const Vector3d foot(ball.x() - ankle.x(), 0.0, ball.z() - ankle.z());
    const Vector3d out = unit(unit(foot) + mirrored({0.35, 0.0, 0.0}, side));
    const Vector3d bind_side = unit(knee - 0.5 * (hip + ankle));
    const Matrix3d lift = turn_about(unit(upwards.cross(foot)), degree * curves_.heel.at(time));
    const Vector3d off_ground = foot_lift(time) * upwards;
    const Vector3d target = ball + lift * (ankle - ball) + off_ground;
    const Vector3d root = pose.root + pose.turns[joints_.hips] * (hip - place(joints_.hips));
    const LimbTurns turns = reach({hip, knee, ankle}, bind_side, root, target, out);
    pose.turns[joints_.thigh[side]] = turns.upper;
    pose.turns[joints_.shin[side]] = turns.lower;
    pose.turns[joints_.foot[side]] = lift;
    // On the ground the toes stay flat.
    pose.turns[joints_.toe[side]] = Matrix3d::Identity();
  }

  const rig::Character& character_;
  const BearJoints& joints_;
  const std::vector<PartMass>& masses_;
  Curves curves_;
  WorldPose bind_;
  Vector3d bind_centre_;
};

}  // namespace

rig::Clip bear_jump(const rig::Character& character, const BearJoints& joints,
                    const std::vector<PartMass>& masses) {
  const BearPoser poser(character, joints, masses);
  std::vector<double> times;
  std::vector<WorldPose> poses;
  const auto keys = static_cast<int>(std::round(jump_duration * jump_keys_a_second));
  for (int k = 0; k <= keys; ++k) {
    times.push_back(k / jump_keys_a_second);
    poses.push_back(poser.pose(times.back()));
  }
  return clip_of_poses(character, "jump", times, poses);
}

}  // namespace fascicle::made
