#include "host/drive/pose_drive.h"

#include <stdexcept>
#include <string>
#include <variant>

#include "host/base/trigonometry.h"
#include "host/drive/pose_bones.h"

namespace fascicle::drive {

using scene::Vector3d;

PoseDrive::PoseDrive(const scene::Scene& scene, const model::Model& model, std::uint32_t substeps)
    : scene_(scene),
      model_(model),
      substeps_(substeps),
      collider_drive_(scene, model, 1.0 / (static_cast<double>(substeps) * scene.fps)) {
  const double h = 1.0 / (static_cast<double>(substeps) * scene.fps);
  if (model.has_skeleton()) {
    const auto& character = std::get<rig::Character>(scene.geometry);
    timeline_.emplace(scene, character, model::extents(model, scene::first_joints(scene)), substeps);
    if (model.muscle_count > 0) muscles_.emplace(scene, character);
  }
  for (const model::Layer& layer : model.layers)
    decay_.push_back(static_cast<float>(base::exact_exp(-layer.damping * h)));
}

Vector3d PoseDrive::origin_of(const Pose& pose) const {
  if (!timeline_) return {model_.rest_origin[0], model_.rest_origin[1], model_.rest_origin[2]};
  return whole_units(timeline_->root(pose), model_.unit);
}

model::State PoseDrive::start(const Pose& pose) {
  if (pose.size() != model_.joint_count)
    throw std::invalid_argument("a pose of " + std::to_string(pose.size()) + " joints; the model has " +
                                std::to_string(model_.joint_count));
  last_ = pose;
  const Vector3d origin = origin_of(pose);
  bones_.clear();
  if (timeline_) append_bones(scene_, model_, pose, origin, bones_);
  return model::initial_state(model_, bones_, array_of(origin));
}

model::Drive PoseDrive::drive(std::span<const Pose> poses, double time, bool jumps) {
  const std::size_t substeps = substeps_;
  for (const Pose& pose : poses)
    if (pose.size() != model_.joint_count)
      throw std::invalid_argument("a pose of " + std::to_string(pose.size()) + " joints; the model has " +
                                  std::to_string(model_.joint_count));
  if (timeline_ && poses.size() != 1 && poses.size() != substeps)
    throw std::invalid_argument(std::to_string(poses.size()) + " poses for a frame of " +
                                std::to_string(substeps) + " substeps; give one, or one for each substep");
  if (timeline_ && last_.empty())
    throw std::invalid_argument("drive() was called before start() gave a first pose");
  bones_.clear();
  before_.clear();
  after_.clear();
  muscle_values_.clear();
  forces_.clear();
  colliders_.clear();
  cuts_.clear();
  const Vector3d before = origin_of(last_);
  const Vector3d end = timeline_ ? origin_of(poses.back()) : before;
  const double h = 1.0 / (static_cast<double>(substeps) * scene_.fps);
  if (timeline_ && jumps) {
    append_bones(scene_, model_, last_, before, before_);
    append_bones(scene_, model_, poses.front(), end, after_);
    cuts_.push_back({0, array_of(end), before_, before_, after_, after_});
  }
  Pose stood = timeline_ ? (jumps ? poses.front() : last_) : Pose();
  for (std::size_t s = 1; s <= substeps; ++s) {
    const double left = static_cast<double>(substeps - s) * h;
    Pose pose;
    if (timeline_) {
      if (poses.size() == substeps) {
        pose = poses[s - 1];
      } else if (jumps || s == substeps) {
        pose = poses.back();
      } else {
        const double share = static_cast<double>(s) / static_cast<double>(substeps);
        pose.resize(last_.size());
        for (std::size_t j = 0; j < pose.size(); ++j)
          pose[j] = (1.0 - share) * last_[j] + share * poses.back()[j];
      }
      append_bones(scene_, model_, pose, end, bones_);
      if (muscles_) muscles_->append(pose, time - left, muscle_values_);
    }
    // A force acts through a whole substep or not at all, depending on the substep's beginning.
    const double begins = time - left - h;
    collider_drive_.append({begins, &stood}, {time - left, &pose}, end, colliders_);
    stood = std::move(pose);
    for (const scene::Force& force : scene_.forces) {
      const bool acts = force.start <= begins && begins < force.end;
      const Vector3d f = acts ? Vector3d(force.vector / model_.unit) : Vector3d(Vector3d::Zero());
      forces_.push_back({static_cast<float>(f[0]), static_cast<float>(f[1]), static_cast<float>(f[2]), 0.0f});
    }
  }
  if (timeline_) last_ = poses.back();

  model::Drive drive;
  drive.substeps = static_cast<std::uint32_t>(substeps);
  drive.h = h;
  drive.origin = array_of(end);
  const bool hangs = timeline_ && scene_.motion.rest == scene::Rest::sculpted;
  for (std::size_t a = 0; a < 3; ++a) {
    const auto axis = static_cast<Eigen::Index>(a);
    drive.gravity[a] = hangs ? 0.0f : static_cast<float>(scene_.gravity[axis] / model_.unit);
    drive.origin_shift[a] =
        cuts_.empty() ? static_cast<float>((end[axis] - before[axis]) / model_.unit) : 0.0f;
  }
  drive.bones = bones_;
  drive.muscles = muscle_values_;
  drive.forces = forces_;
  drive.colliders = colliders_;
  drive.decay = decay_;
  drive.cuts = cuts_;
  return drive;
}

}  // namespace fascicle::drive
