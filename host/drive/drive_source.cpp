#include "host/drive/drive_source.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "host/base/trigonometry.h"
#include "host/drive/collider_drive.h"
#include "host/drive/felt_acceleration.h"
#include "host/drive/motion_breaks.h"
#include "host/drive/muscle_drive.h"
#include "host/drive/pose_bones.h"
#include "host/drive/timeline.h"

namespace fascicle::drive {

using scene::Vector3d;

struct DriveSource::Impl {
  Impl(const scene::Scene& scene, const model::Model& model, std::uint32_t substeps);

  double h() const { return 1.0 / (static_cast<double>(substeps) * scene.fps); }
  Vector3d rest_origin() const { return {model.rest_origin[0], model.rest_origin[1], model.rest_origin[2]}; }
  Vector3d origin(std::uint64_t count);  // for the pose at the end of substep `count`
  void append_bones(const Pose& pose, const Vector3d& origin, std::vector<shader::Bone>& to) const {
    if (timeline) drive::append_bones(scene, model, pose, origin, to);
  }
  void append_pose(const Pose& pose, const Vector3d& origin, double time);
  void append_forces(double time);
  void append_colliders(std::uint64_t count, const Vector3d& origin);
  void append_standing_colliders(const Pose* before, const Pose* at, const Vector3d& origin);
  double time_of(std::uint64_t count) const;
  void clear();
  void append_break(std::uint32_t substep, std::uint64_t count, const Vector3d& before,
                    const Vector3d& after);
  std::vector<shader::Bone> start_after(const Vector3d& origin);
  model::Drive drive_to(const Vector3d& end);

  const scene::Scene& scene;
  const model::Model& model;
  std::uint64_t substeps;
  std::optional<Timeline> timeline;         // empty without a skeleton
  std::optional<FeltAcceleration> felt;     // likewise
  std::vector<std::size_t> character_of;    // per joint
  std::optional<MotionBreaks> breaks;       // empty without a skeleton
  std::optional<MuscleDrive> muscle_drive;  // empty without muscles
  std::vector<shader::Bone> bones;
  std::vector<shader::Muscle> muscles;
  ColliderDrive collider_drive;
  std::vector<shader::Collider> colliders;
  std::vector<shader::Force> forces;
  std::vector<float> decay;
  std::vector<std::vector<shader::Bone>> cut_poses;  // four per cut
  std::vector<model::Cut> cuts;
};

DriveSource::Impl::Impl(const scene::Scene& s, const model::Model& m, std::uint32_t substeps_of_frame)
    : scene(s),
      model(m),
      substeps(substeps_of_frame),
      collider_drive(s, m, 1.0 / (static_cast<double>(substeps_of_frame) * s.fps)) {
  const auto must_fit = [](const char* what, std::size_t of_scene, std::size_t of_model) {
    if (of_scene != of_model) {
      throw std::invalid_argument("DriveSource: the scene has " + std::to_string(of_scene) + " " + what +
                                  ", the model " + std::to_string(of_model));
    }
  };
  const auto* character = std::get_if<rig::Character>(&scene.geometry);
  if (character != nullptr && character->skeleton.empty()) character = nullptr;
  must_fit("joints", character == nullptr ? 0 : character->skeleton.size(), model.joint_count);
  must_fit("forces", scene.forces.size(), model.force_count);
  must_fit("colliders", scene.colliders.size(), model.collider_count);
  must_fit("muscles", character == nullptr ? 0 : scene.muscles.size(), model.muscle_count);
  if (character != nullptr)
    timeline.emplace(scene, *character, model::extents(model, scene::first_joints(scene)), substeps);
  if (character != nullptr) felt.emplace(scene, *character, model);
  for (std::size_t j = 0; j < model.joint_count; ++j)
    character_of.push_back(scene::character_of_joint(scene, j));
  if (character != nullptr) breaks.emplace(*timeline, *felt, character_of, h());
  if (model.muscle_count > 0) muscle_drive.emplace(scene, *character);
  for (const model::Layer& layer : model.layers)
    decay.push_back(static_cast<float>(base::exact_exp(-layer.damping * h())));
}

Vector3d DriveSource::Impl::origin(std::uint64_t count) {
  if (!timeline) return rest_origin();
  return whole_units(timeline->root(timeline->pose(count)), model.unit);
}

// Appends a substep's end: the bones, and the muscles for this pose and time of the clip.
void DriveSource::Impl::append_pose(const Pose& pose, const Vector3d& origin, double time) {
  append_bones(pose, origin, bones);
  if (muscle_drive) muscle_drive->append(pose, time, muscles);
}

void DriveSource::Impl::clear() {
  bones.clear();
  muscles.clear();
  forces.clear();
  colliders.clear();
  cut_poses.clear();
  cuts.clear();
}

void DriveSource::Impl::append_forces(double time) {
  for (const scene::Force& force : scene.forces) {
    const bool acts = force.start <= time && time < force.end;
    const Vector3d f = acts ? Vector3d(force.vector / model.unit) : Vector3d(Vector3d::Zero());
    forces.push_back({static_cast<float>(f[0]), static_cast<float>(f[1]), static_cast<float>(f[2]), 0.0f});
  }
}

// The time at the end of substep `count`: clip time, so that solids repeat with the clip.
double DriveSource::Impl::time_of(std::uint64_t count) const {
  if (timeline) return timeline->clip_time(count);
  return scene.start + static_cast<double>(count) / (static_cast<double>(substeps) * scene.fps);
}

// Appends the solids' motion through substep `count`; at a cut they stay at its new pose.
void DriveSource::Impl::append_colliders(std::uint64_t count, const Vector3d& origin) {
  if (scene.colliders.empty()) return;
  if (!timeline) return collider_drive.append({time_of(count - 1)}, {time_of(count)}, origin, colliders);
  // Copies: the timeline may drop one pose when it computes another.
  Pose before = timeline->pose(count - 1);
  const Pose at = timeline->pose(count);
  for (std::size_t j = 0; j < at.size(); ++j)
    if (timeline->is_cut_of(character_of[j], count)) before[j] = at[j];
  double time = time_of(timeline->is_cut_of_all(count) ? count : count - 1);
  if (time > time_of(count)) time = scene.start;  // a new cycle begins
  collider_drive.append({time, &before}, {time_of(count), &at}, origin, colliders);
}

// The same before the scene's time begins.
void DriveSource::Impl::append_standing_colliders(const Pose* before, const Pose* at,
                                                  const Vector3d& origin) {
  collider_drive.append({scene.start, before}, {scene.start, at}, origin, colliders);
}

// Appends the break between the ends of substeps count - 1 and count, which is substep number `substep` of
// its frame.
void DriveSource::Impl::append_break(std::uint32_t substep, std::uint64_t count, const Vector3d& before,
                                     const Vector3d& after) {
  const BreakPoses poses = breaks->poses(count);
  const std::size_t first = cut_poses.size();
  cut_poses.resize(first + 4);
  append_bones(poses.ended, before, cut_poses[first]);
  append_bones(poses.at, before, cut_poses[first + 1]);
  append_bones(poses.begun, after, cut_poses[first + 2]);
  append_bones(poses.given, after, cut_poses[first + 3]);
  cuts.push_back({substep, array_of(after), {}, {}, {}, {}});
}

// The pose after the clip's first substep, which gives the initial velocity; the first pose if there is a
// cut.
std::vector<shader::Bone> DriveSource::Impl::start_after(const Vector3d& origin) {
  std::vector<shader::Bone> after;
  append_bones(timeline->pose(timeline->is_cut(1) ? 0 : 1), origin, after);
  return after;
}

// Makes a drive from the collected bones, forces and cuts, with the origin `end`.
model::Drive DriveSource::Impl::drive_to(const Vector3d& end) {
  model::Drive drive;
  drive.substeps = static_cast<std::uint32_t>(substeps);
  drive.h = h();
  drive.origin = array_of(end);
  // If the rest shape already sags under gravity, only the bones' change of gravity acts.
  const bool hangs = timeline && scene.motion.rest == scene::Rest::sculpted;
  for (int a = 0; a < 3; ++a)
    drive.gravity[static_cast<std::size_t>(a)] =
        hangs ? 0.0f : static_cast<float>(scene.gravity[a] / model.unit);
  for (std::size_t k = 0; k < cuts.size(); ++k) {
    cuts[k].before = cut_poses[4 * k];
    cuts[k].at = cut_poses[4 * k + 1];
    cuts[k].to = cut_poses[4 * k + 2];
    cuts[k].after = cut_poses[4 * k + 3];
  }
  drive.bones = bones;
  drive.muscles = muscles;
  drive.forces = forces;
  drive.colliders = colliders;
  drive.decay = decay;
  drive.cuts = cuts;
  return drive;
}

DriveSource::DriveSource(const scene::Scene& scene, const model::Model& model)
    : DriveSource(scene, model, scene::stated_substeps(scene)) {}

DriveSource::DriveSource(const scene::Scene& scene, const model::Model& model, std::uint32_t substeps)
    : impl_(std::make_unique<Impl>(scene, model, substeps)) {}

DriveSource::~DriveSource() = default;

std::uint32_t DriveSource::substeps() const {
  return static_cast<std::uint32_t>(impl_->substeps);
}

model::Drive DriveSource::drive(std::uint64_t frame) {
  if (frame == 0)
    throw std::invalid_argument("DriveSource: frame 0 is the initial state; drives begin with frame 1");
  Impl& impl = *impl_;
  impl.clear();
  const std::uint64_t substeps = impl.substeps, first = (frame - 1) * substeps;
  const Vector3d before = impl.origin(first), end = impl.origin(first + substeps);
  // Without a cut, the frame is relative to the origin at its end; with one, the first cut moves the body
  // there.
  bool cut_ahead = false;
  for (std::uint64_t s = 1; impl.timeline && s <= substeps; ++s)
    cut_ahead = cut_ahead || impl.timeline->is_cut(first + s) || impl.breaks->is_bounded(first + s);
  const Vector3d shift = cut_ahead ? Vector3d(Vector3d::Zero()) : Vector3d((end - before) / impl.model.unit);
  Vector3d origin = cut_ahead ? before : end;
  for (std::uint64_t s = 0; s < substeps; ++s) {
    const std::uint64_t count = first + s + 1;
    if (impl.timeline && (impl.timeline->is_cut(count) || impl.breaks->is_bounded(count))) {
      impl.append_break(static_cast<std::uint32_t>(s), count, origin, end);
      origin = end;
    }
    if (impl.timeline) impl.append_pose(impl.timeline->pose(count), origin, impl.timeline->clip_time(count));
    // A force acts through a whole substep or not at all, depending on the substep's beginning.
    impl.append_forces(impl.scene.start +
                       static_cast<double>(count - 1) / (static_cast<double>(substeps) * impl.scene.fps));
    impl.append_colliders(count, origin);
  }
  model::Drive drive = impl.drive_to(end);
  for (int a = 0; a < 3; ++a) drive.origin_shift[static_cast<std::size_t>(a)] = static_cast<float>(shift[a]);
  return drive;
}

model::State DriveSource::initial_state() const {
  Impl& impl = *impl_;
  if (!impl.timeline) return model::initial_state(impl.model, {}, impl.model.rest_origin);
  const Vector3d origin = impl.origin(0);
  std::vector<shader::Bone> bones;
  impl.append_bones(impl.timeline->pose(0), origin, bones);
  return started(model::initial_state(impl.model, bones, array_of(origin)));
}

model::State DriveSource::state_on_skeleton(std::uint64_t frame) const {
  Impl& impl = *impl_;
  if (!impl.timeline) return initial_state();
  const Vector3d origin = impl.origin(frame * impl.substeps);
  std::vector<shader::Bone> at, after;
  impl.append_bones(impl.timeline->pose(frame * impl.substeps), origin, at);
  impl.append_bones(impl.timeline->pose(frame * impl.substeps + 1), origin, after);
  model::State state = model::initial_state(impl.model, at, array_of(origin));
  state = model::carried(impl.model, state, impl.h(), {0, array_of(origin), at, at, at, after});
  state.frame = frame;
  return state;
}

std::vector<DriveSource::Thrown> DriveSource::thrown(const GoesOn& goes_on) {
  Impl& impl = *impl_;
  std::vector<Thrown> worst;
  if (!impl.timeline) return worst;
  const std::uint64_t substeps = impl.substeps, last = scene::cycle_frames(impl.scene) * substeps;
  std::vector<Thrown> of_joint(impl.model.joint_count);
  for (std::uint64_t count = 2; count <= last; ++count) {
    if (goes_on && count % substeps == 0 && !goes_on()) break;
    // A clip that ends between two frames stops there, and no key is to blame.
    if (impl.timeline->is_over(count)) break;
    for (std::size_t j = 0; j < of_joint.size(); ++j) {
      const double a = impl.breaks->accelerates(j, count) ? impl.breaks->acceleration_of(j, count) : 0.0;
      if (a > std::max(impl.felt->limit(j), of_joint[j].acceleration))
        of_joint[j] = {j, a, impl.timeline->clip_time(count - 1), (count - 2 + substeps) / substeps};
    }
  }
  for (const Thrown& joint : of_joint)
    if (joint.acceleration > 0.0) worst.push_back(joint);
  std::stable_sort(worst.begin(), worst.end(),
                   [](const Thrown& a, const Thrown& b) { return a.acceleration > b.acceleration; });
  return worst;
}

std::vector<Timeline::Jump> DriveSource::jumps() {
  return impl_->timeline ? impl_->timeline->jumps() : std::vector<Timeline::Jump>();
}

double DriveSource::acceleration_limit(std::size_t joint) const {
  return impl_->felt ? impl_->felt->limit(joint) : 0.0;
}

void DriveSource::for_each_throw(const std::function<void(const std::vector<Throw>& of_joint)>& visit,
                                 const GoesOn& goes_on) {
  Impl& impl = *impl_;
  if (!impl.timeline) return;
  const auto& skeleton = std::get<rig::Character>(impl.scene.geometry).skeleton;
  const std::uint64_t last = scene::cycle_frames(impl.scene) * impl.substeps;
  std::vector<Throw> thrown(skeleton.size());
  for (std::uint64_t count = 1; count <= last; ++count) {
    if (goes_on && count % impl.substeps == 0 && !goes_on()) return;
    const Pose& to = impl.timeline->pose(count);
    for (std::size_t j = 0; j < thrown.size(); ++j) {
      thrown[j] = {};
      if (!impl.felt->has_flesh(j)) continue;
      thrown[j].gravity = impl.scene.motion.rest == scene::Rest::sculpted
                              ? change_of_gravity(to[j] * skeleton[j].inverse_bind, impl.scene.gravity)
                              : impl.scene.gravity;
      if (!impl.breaks->accelerates(j, count)) continue;
      const Pose &before = impl.timeline->pose(count - 2), &at = impl.timeline->pose(count - 1);
      const double most = impl.breaks->acceleration_of(j, count);
      const double felt = most > impl.felt->limit(j) ? impl.felt->limit(j) / most : 1.0;
      thrown[j].inertia = -felt * impl.felt->in_middle(j, before, at, to, impl.h());
    }
    visit(thrown);
  }
}

std::vector<Eigen::Matrix4d> DriveSource::joints(std::uint64_t frame) {
  if (!impl_->timeline) return {};
  return impl_->timeline->pose(frame * impl_->substeps);
}

std::vector<scene::Solid> DriveSource::solids(std::uint64_t frame) {
  Impl& impl = *impl_;
  const std::uint64_t count = frame * impl.substeps;
  const Pose pose = impl.timeline ? impl.timeline->pose(count) : Pose();
  return impl.collider_drive.solids({impl.time_of(count), &pose});
}

double DriveSource::clip_time(std::uint64_t frame) const {
  return impl_->timeline ? impl_->timeline->clip_time(frame * impl_->substeps) : 0.0;
}

std::uint64_t DriveSource::preroll_frames() const {
  if (!impl_->timeline) return 0;
  return static_cast<std::uint64_t>(std::llround(impl_->scene.motion.preroll * impl_->scene.fps));
}

model::State DriveSource::preroll_state() const {
  Impl& impl = *impl_;
  if (!impl.timeline) return initial_state();
  const Pose pose = preroll_frames() > 0 ? impl.timeline->preroll_pose(0.0) : impl.timeline->pose(0);
  const Vector3d origin = impl.origin(0);
  std::vector<shader::Bone> bones;
  impl.append_bones(pose, origin, bones);
  return model::initial_state(impl.model, bones, array_of(origin));
}

model::Drive DriveSource::preroll_drive(std::uint64_t frame) {
  Impl& impl = *impl_;
  impl.clear();
  const Vector3d origin = impl.origin(0);
  const double last = static_cast<double>(preroll_frames() * impl.substeps);
  const auto pose_at = [&](std::uint64_t s) {
    const double x = static_cast<double>((frame - 1) * impl.substeps + s) / last;
    // Begins and ends at zero speed.
    return impl.timeline ? impl.timeline->preroll_pose(x * x * (3.0 - 2.0 * x)) : Pose();
  };
  Pose before = pose_at(0);
  for (std::uint64_t s = 1; s <= impl.substeps; ++s) {
    Pose at = pose_at(s);
    if (impl.timeline) impl.append_pose(at, origin, impl.scene.start);
    impl.append_forces(impl.scene.start);
    impl.append_standing_colliders(&before, &at, origin);
    before = std::move(at);
  }
  return impl.drive_to(origin);
}

model::Drive DriveSource::settle_drive() {
  Impl& impl = *impl_;
  impl.clear();
  const Vector3d origin = impl.origin(0);
  for (std::uint64_t s = 0; s < impl.substeps; ++s) {
    const Pose pose = impl.timeline ? impl.timeline->pose(0) : Pose();
    if (impl.timeline) impl.append_pose(pose, origin, impl.scene.start);
    impl.append_forces(impl.scene.start);
    impl.append_standing_colliders(&pose, &pose, origin);
  }
  return impl.drive_to(origin);
}

model::State DriveSource::started(const model::State& resting) const {
  Impl& impl = *impl_;
  model::State state = resting;
  state.frame = 0;
  if (!impl.timeline) return state;
  const Vector3d origin(resting.origin[0], resting.origin[1], resting.origin[2]);
  std::vector<shader::Bone> first;
  impl.append_bones(impl.timeline->pose(0), origin, first);
  const std::vector<shader::Bone> after = impl.start_after(origin);
  return model::carried(impl.model, state, impl.h(), {0, resting.origin, first, first, first, after});
}

model::State DriveSource::begun_again(const model::State& cycled) const {
  Impl& impl = *impl_;
  model::State state = cycled;
  state.frame = 0;
  if (!impl.timeline) return state;
  const std::uint64_t last = scene::cycle_frames(impl.scene) * impl.substeps;
  const Vector3d ended(cycled.origin[0], cycled.origin[1], cycled.origin[2]);
  const Vector3d origin = impl.origin(0);
  if (impl.timeline->returns()) {
    // A step of the root's rounded position, however little the root itself moved.
    if (origin == ended) return state;
    const Vector3d shift = (ended - origin) / impl.model.unit;
    for (std::vector<float>* places : {&state.positions, &state.skinned, &state.positions_before})
      for (std::size_t i = 0; i < places->size(); ++i)
        (*places)[i] += static_cast<float>(shift[static_cast<Eigen::Index>(i % 3)]);
    state.origin = array_of(origin);
    return state;
  }
  std::vector<shader::Bone> before, at, to;
  impl.append_bones(impl.timeline->pose(last - 1), ended, before);
  impl.append_bones(impl.timeline->pose(last), ended, at);
  impl.append_bones(impl.timeline->pose(0), origin, to);
  const std::vector<shader::Bone> after = impl.start_after(origin);
  return model::carried(impl.model, state, impl.h(), {0, array_of(origin), before, at, to, after});
}

}  // namespace fascicle::drive
