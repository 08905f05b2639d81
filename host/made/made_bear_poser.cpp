#include "host/made/made_bear_poser.h"

#include <cmath>
#include <cstddef>

#include <Eigen/Geometry>

namespace fascicle::made {
namespace {

using Eigen::Matrix3d;

constexpr double keys_a_second = 120.0;
const Vector3d right_to_left(1.0, 0.0, 0.0), upwards(0.0, 1.0, 0.0), forwards(0.0, 0.0, 1.0);

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

// Computes the pose at one time: first everything above the hips, then the hips' position, then the legs.
// This is iterated, because the legs contribute to the centre of mass.
class BearPoser {
 public:
  BearPoser(const rig::Character& character, const BearJoints& joints, const std::vector<PartMass>& masses,
            const BearMoves& moves)
      : character_(character), joints_(joints), masses_(masses), moves_(moves), curves_(moves.curves) {
    bind_.root = place(joints.hips);
    bind_.turns.assign(character.skeleton.size(), Matrix3d::Identity());
    bind_centre_ = centre_of_mass(character, bind_, masses);
  }

  WorldPose pose(double time) const {
    WorldPose pose = bind_;
    pose_trunk(time, pose);
    for (std::size_t side = 0; side < 2; ++side) pose_arm(time, side, pose);
    const Vector3d wanted = bind_centre_ + moves_.centre(time);
    // Each round removes most of the remaining error; see the test of the parabola.
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
    // The knee bends towards where the foot points, and somewhat outwards.
    const Vector3d foot(ball.x() - ankle.x(), 0.0, ball.z() - ankle.z());
    const Vector3d out = unit(unit(foot) + mirrored({0.35, 0.0, 0.0}, side));
    const Vector3d bind_side = unit(knee - 0.5 * (hip + ankle));
    const Matrix3d lift = turn_about(unit(upwards.cross(foot)), degree * curves_.heel.at(time));
    const Vector3d off_ground = moves_.foot_lift(time) * upwards;
    const Vector3d target = ball + lift * (ankle - ball) + off_ground;
    const Vector3d root = pose.root + pose.turns[joints_.hips] * (hip - place(joints_.hips));
    const LimbTurns turns = reach({hip, knee, ankle}, bind_side, root, target, out);
    pose.turns[joints_.thigh[side]] = turns.upper;
    pose.turns[joints_.shin[side]] = turns.lower;
    pose.turns[joints_.foot[side]] = lift;
    // The toes stay flat on the ground.
    pose.turns[joints_.toe[side]] = Matrix3d::Identity();
  }

  const rig::Character& character_;
  const BearJoints& joints_;
  const std::vector<PartMass>& masses_;
  const BearMoves& moves_;
  const BearCurves& curves_;
  WorldPose bind_;
  Vector3d bind_centre_;
};

}  // namespace

rig::Clip clip_of_moves(const rig::Character& character, const BearJoints& joints,
                        const std::vector<PartMass>& masses, const BearMoves& moves, const std::string& name,
                        double duration) {
  const BearPoser poser(character, joints, masses, moves);
  std::vector<double> times;
  std::vector<WorldPose> poses;
  const auto keys = static_cast<int>(std::round(duration * keys_a_second));
  for (int k = 0; k <= keys; ++k) {
    times.push_back(k / keys_a_second);
    poses.push_back(poser.pose(times.back()));
  }
  return clip_of_poses(character, name, times, poses);
}

}  // namespace fascicle::made
