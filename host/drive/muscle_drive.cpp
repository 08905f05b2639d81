#include "host/drive/muscle_drive.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "host/base/trigonometry.h"
#include "host/drive/pose_blend.h"
#include "host/model/rotation.h"
#include "host/rig/pose.h"
#include "host/rig/pose_interpolation.h"

namespace fascicle::drive {

using scene::Vector3d;

namespace {

// Sines of 5 and 10 degrees: below the first, a joint's bend has no well-defined direction, and tau is that
// of the clip's hinge; up to the second, tau is blended.
constexpr double sine_without_side = 0.08715574274765817, sine_with_side = 0.17364817766693036;

double activation_of(const scene::Muscle& muscle, double cosine, double sine) {
  if (!muscle.curve.empty()) {
    // pi/180 as a quotient of doubles, not from the library.
    constexpr double degrees = 180.0 / std::numbers::pi;
    return scene::value_at(muscle.curve, base::exact_acos(cosine) * degrees);
  }
  return muscle.activation == scene::Activation::sine ? sine : (1.0 - cosine) / 2.0;
}

model::Matrix3 rotation_of(const Eigen::Matrix4d& from_bind) {
  return model::nearest_rotation(rows_of(from_bind));
}

Vector3d vector_of(const std::array<double, 3>& v) {
  return {v[0], v[1], v[2]};
}

}  // namespace

std::uint64_t clamped_regions(const model::Model& model, std::span<const shader::Muscle> muscles) {
  std::uint64_t clamped = 0;
  for (std::uint32_t r = 0; r < model.vertex_count && model.muscle_count > 0; ++r) {
    const shader::RegionFrame& frame = model.region_frame[r];
    double c = 1.0;
    for (std::uint32_t e = model.muscle_offset[r]; e < model.muscle_offset[r + 1]; ++e) {
      const shader::Muscle& m = muscles[model.region_muscle[e].muscle];
      c += static_cast<double>(model.region_muscle[e].bulge) *
           (static_cast<double>(frame.normal_x * m.tau_x + frame.normal_y * m.tau_y +
                                frame.normal_z * m.tau_z) +
            static_cast<double>(m.swell));
    }
    clamped += c < 0.25 || c > 4.0 ? 1u : 0u;
  }
  return clamped;
}

MuscleDrive::MuscleDrive(const scene::Scene& scene, const rig::Character& character)
    : scene_(scene), character_(character) {
  const rig::Clip* clip = rig::find_clip(character, scene.clip);
  for (std::size_t m = 0; m < scene.muscles.size(); ++m) {
    const scene::Muscle& muscle = scene.muscles[m];
    Prepared prepared;
    prepared.bones = scene::muscle_bones(character, muscle);
    if (prepared.bones.bend) {
      const scene::BendingJoint& joint = *prepared.bones.bend;
      const Bend bound = bend_of(muscle, prepared.bones, scene::joint_place(character.skeleton[joint.upper]),
                                 scene::joint_place(character.skeleton[joint.joint]), joint.tip);
      prepared.resting = activation_of(muscle, bound.cosine, bound.sine);
    }
    if (!muscle.contraction_channel.empty()) {
      const scene::ContractionChannel wanted = scene::contraction_channel(character, muscle);
      const rig::Joint& joint = character.skeleton[wanted.joint];
      prepared.axis = wanted.axis;
      prepared.at_rest =
          (wanted.path == rig::ChannelPath::scale ? joint.rest_scale : joint.rest_translation)[wanted.axis];
      prepared.channel = scene::find_channel(clip, wanted);
    }
    prepared_.push_back(std::move(prepared));
  }
  find_hinges(clip);
}

MuscleDrive::Bend MuscleDrive::bend_of(const scene::Muscle& muscle, const scene::MuscleBones& bones,
                                       const Vector3d& upper, const Vector3d& joint,
                                       const Vector3d& end) const {
  const Vector3d above = joint - upper, below = end - joint;
  const double lengths = std::sqrt(above.squaredNorm() * below.squaredNorm());
  if (!(lengths > 0.0)) return {};
  const Vector3d u = above / std::sqrt(above.squaredNorm()), l = below / std::sqrt(below.squaredNorm());
  Bend bend;
  bend.cosine = std::clamp(u.dot(l), -1.0, 1.0);
  const Vector3d normal(u[1] * l[2] - u[2] * l[1], u[2] * l[0] - u[0] * l[2], u[0] * l[1] - u[1] * l[0]);
  bend.sine = std::sqrt(normal.squaredNorm());
  // Perpendicular to the bone that carries the muscle, towards the other bone.
  const bool is_on_lower = bones.moves[bones.bend->joint] != 0;
  bend.tau = muscle.axis == scene::BulgeAxis::plane_normal ? normal
             : is_on_lower                                 ? Vector3d(u.dot(l) * l - u)
                                                           : Vector3d(l - u.dot(l) * u);
  return bend;
}

MuscleDrive::Bend MuscleDrive::bend_in(std::size_t m, const Pose& pose) const {
  const scene::BendingJoint& bend = *prepared_[m].bones.bend;
  const auto place = [&](std::uint32_t joint) -> Vector3d { return pose[joint].topRightCorner<3, 1>(); };
  Vector3d end;
  if (bend.lower_end) {
    end = place(*bend.lower_end);
  } else {
    const Eigen::Matrix4d map = pose[bend.joint] * character_.skeleton[bend.joint].inverse_bind;
    end = map.topLeftCorner<3, 3>() * bend.tip + map.topRightCorner<3, 1>();
  }
  return bend_of(scene_.muscles[m], prepared_[m].bones, place(bend.upper), place(bend.joint), end);
}

// A world direction in the bind pose of the muscle's bone.
Vector3d MuscleDrive::at_rest(std::size_t m, const Pose& pose, const Vector3d& direction) const {
  const std::uint32_t carrier = prepared_[m].bones.carrier;
  const model::Matrix3 turn = rotation_of(pose[carrier] * character_.skeleton[carrier].inverse_bind);
  return vector_of(
      model::multiply(model::transposed(turn), std::array{direction[0], direction[1], direction[2]}));
}

void MuscleDrive::find_hinges(const rig::Clip* clip) {
  if (std::none_of(prepared_.begin(), prepared_.end(), [](const Prepared& p) { return p.bones.bend; }))
    return;
  std::vector<double> most(prepared_.size(), sine_without_side);
  const auto frames = std::max<std::uint64_t>(scene::cycle_frames(scene_), 1);
  for (std::uint64_t k = 0; k <= frames; ++k) {
    const double time = scene_.start + static_cast<double>(k) / scene_.fps;
    const Pose pose = rig::joint_transforms_at(character_, clip, time);
    for (std::size_t m = 0; m < prepared_.size(); ++m) {
      if (!prepared_[m].bones.bend) continue;
      const Bend bend = bend_in(m, pose);
      if (!(bend.sine > most[m])) continue;
      most[m] = bend.sine;
      prepared_[m].hinge = at_rest(m, pose, bend.tau / bend.sine);
    }
  }
}

// The angle of the twisted joint about the bone, in (-pi, pi].
double MuscleDrive::twist_in(std::size_t m, const Pose& pose) const {
  const scene::MuscleBones& bones = prepared_[m].bones;
  const auto turn_of = [&](std::uint32_t joint) {
    return rotation_of(pose[joint] * character_.skeleton[joint].inverse_bind);
  };
  model::Matrix3 turn = turn_of(bones.twisted);
  if (bones.against) turn = model::multiply(model::transposed(turn_of(*bones.against)), turn);
  const model::Quaternion q = model::quaternion_of(turn);
  const Vector3d along = bones.to - bones.from;
  const double p = (q[1] * along[0] + q[2] * along[1] + q[3] * along[2]) / std::sqrt(along.squaredNorm());
  const double length = std::sqrt(q[0] * q[0] + p * p);
  if (!(length > 0.0)) return 0.0;
  const double angle = 2.0 * base::exact_acos(std::abs(q[0]) / length);
  return p * q[0] < 0.0 ? -angle : angle;
}

void MuscleDrive::append(const Pose& pose, double time, std::vector<shader::Muscle>& to) const {
  for (std::size_t m = 0; m < prepared_.size(); ++m) {
    const scene::Muscle& muscle = scene_.muscles[m];
    const Prepared& prepared = prepared_[m];
    Vector3d tau = Vector3d::Zero();
    if (prepared.bones.bend) {
      const Bend bend = bend_in(m, pose);
      const double side =
          std::clamp((bend.sine - sine_without_side) / (sine_with_side - sine_without_side), 0.0, 1.0);
      tau = (1.0 - side) * prepared.hinge;
      double agreement = 1.0;
      if (side > 0.0) {
        const Vector3d now = at_rest(m, pose, bend.tau / bend.sine);
        tau += side * now;
        agreement = std::clamp(1.0 + now.dot(prepared.hinge), 0.0, 1.0);
      }
      // A joint that bends past straight turns tau around. On the way it passes through 0: at unit length it
      // would jump from one side to the other.
      const double length = (1.0 - agreement) + agreement * std::sqrt(tau.squaredNorm());
      if (length > 0.0) tau *= (activation_of(muscle, bend.cosine, bend.sine) - prepared.resting) / length;
    }
    double swell = 0.0;
    if (!muscle.contraction.empty()) swell = scene::value_at(muscle.contraction, time);
    if (prepared.channel != nullptr)
      swell = rig::sample(*prepared.channel, time)[prepared.axis] - prepared.at_rest;
    const double twist = muscle.twist != 0.0 ? twist_in(m, pose) : 0.0;
    using model::as_factor;
    to.push_back(
        {as_factor(tau[0]), as_factor(tau[1]), as_factor(tau[2]), as_factor(swell), as_factor(twist)});
  }
}

}  // namespace fascicle::drive
