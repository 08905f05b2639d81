#include "host/made/made_arm.h"

#include <cmath>

#include "host/made/made_motion.h"
#include "host/made/made_shape.h"

namespace fascicle::made {
namespace {

using Eigen::Matrix3d;

constexpr double arm_spacing = 0.014;  // m
constexpr double curl_keys_a_second = 60.0;
constexpr double curl_duration = 4.0;  // s

const Vector3d elbow_place(0.30, 0.0, 0.0), elbow_axis(0.0, 0.0, 1.0);

struct ArmJoints {
  std::uint32_t shoulder, upper_arm, forearm, hand;
};

// Palm up: the biceps is above the bone, the triceps below. `bend` rotates everything beyond the elbow.
Sculpture arm_sculpture(const ArmJoints& j, const Matrix3d& bend) {
  Sculpture arm;
  const auto cone = [&](std::uint32_t joint, double blend, Vector3d from, double from_radius, Vector3d to,
                        double to_radius) {
    if (joint == j.forearm || joint == j.hand) {
      from = elbow_place + bend * (from - elbow_place);
      to = elbow_place + bend * (to - elbow_place);
    }
    arm.parts.push_back({from, to, from_radius, to_radius, joint, blend});
  };
  cone(j.upper_arm, 0.0, {0.0, 0.0, 0.0}, 0.045, elbow_place, 0.04);
  cone(j.shoulder, 0.05, {-0.05, 0.0, 0.0}, 0.066, {-0.01, 0.006, 0.0}, 0.064);
  cone(j.upper_arm, 0.05, {0.01, 0.012, 0.0}, 0.056, {0.09, 0.004, 0.0}, 0.04);  // deltoid
  // Biceps and triceps, each thickest in the middle.
  cone(j.upper_arm, 0.04, {0.08, 0.014, 0.0}, 0.032, {0.165, 0.026, 0.0}, 0.039);
  cone(j.upper_arm, 0.03, {0.165, 0.026, 0.0}, 0.039, {0.275, 0.006, 0.0}, 0.028);
  cone(j.upper_arm, 0.04, {0.03, -0.018, 0.0}, 0.036, {0.13, -0.026, 0.0}, 0.038);
  cone(j.upper_arm, 0.03, {0.13, -0.026, 0.0}, 0.038, {0.28, -0.008, 0.0}, 0.03);
  cone(j.forearm, 0.02, elbow_place, 0.04, {0.375, 0.003, 0.0}, 0.045);
  cone(j.forearm, 0.02, {0.375, 0.003, 0.0}, 0.045, {0.555, 0.0, 0.0}, 0.028);
  cone(j.hand, 0.02, {0.56, 0.0, 0.0}, 0.03, {0.62, 0.0, -0.012}, 0.031);
  cone(j.hand, 0.02, {0.60, 0.0, 0.012}, 0.031, {0.66, 0.012, 0.012}, 0.026);
  cone(j.hand, 0.02, {0.62, 0.0, -0.014}, 0.029, {0.66, 0.012, -0.012}, 0.026);
  cone(j.hand, 0.015, {0.585, 0.01, 0.03}, 0.018, {0.615, 0.03, 0.055}, 0.016);  // thumb
  return arm;
}

// The elbow's angle, 0 when straight.
double curl_degrees(double time) {
  static const Curve curve{{{0.4, 0.0}, {1.8, 160.0}, {2.3, 160.0}, {3.6, 0.0}}};
  return curve.at(time);
}

rig::Clip curl(const rig::Character& arm, const ArmJoints& j, double bind_degrees) {
  std::vector<double> times;
  std::vector<WorldPose> poses;
  const auto keys = static_cast<int>(std::round(curl_duration * curl_keys_a_second));
  for (int k = 0; k <= keys; ++k) {
    times.push_back(k / curl_keys_a_second);
    WorldPose pose{bind_place(arm.skeleton[j.shoulder]),
                   std::vector<Matrix3d>(arm.skeleton.size(), Matrix3d::Identity())};
    pose.turns[j.forearm] = turn_about(elbow_axis, degree * (curl_degrees(times.back()) - bind_degrees));
    pose.turns[j.hand] = pose.turns[j.forearm];
    poses.push_back(pose);
  }
  return clip_of_poses(arm, "curl", times, poses);
}

}  // namespace

rig::Character make_arm(double bind_degrees) {
  const Matrix3d bend = turn_about(elbow_axis, degree * bind_degrees);
  rig::Character arm;
  ArmJoints j{};
  j.shoulder = add_joint(arm, "shoulder", -1, {-0.06, 0.0, 0.0});
  j.upper_arm = add_joint(arm, "upper_arm", static_cast<std::int32_t>(j.shoulder), {0.0, 0.0, 0.0});
  j.forearm = add_joint(arm, "forearm", static_cast<std::int32_t>(j.upper_arm), elbow_place);
  j.hand = add_joint(arm, "hand", static_cast<std::int32_t>(j.forearm),
                     elbow_place + bend * Vector3d(0.26, 0.0, 0.0));
  const Sculpture sculpture = arm_sculpture(j, bend);
  arm.surface = polygonise(sculpture, arm_spacing);
  bind_skin(sculpture, arm);
  arm.clips.push_back(curl(arm, j, bind_degrees));
  return arm;
}

}  // namespace fascicle::made
