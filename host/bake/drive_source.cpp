#include "host/bake/drive_source.h"

#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "host/scene/pose.h"
#include "host/scene/trigonometry.h"

namespace fascicle::bake {

using scene::Vector3d;

struct DriveSource::Impl {
  Impl(const scene::Scene& scene, const model::Model& model);

  std::uint64_t substeps() const { return scene.solver.substeps; }
  // When substep number `count`, counted from `start` on, begins. One rounding, so that times that are whole
  // frames or tenths of a second come out as written.
  double time(std::uint64_t count) const {
    return scene.start + static_cast<double>(count) / (static_cast<double>(substeps()) * scene.fps);
  }
  Vector3d origin(double time) const;
  void append_bones(double time, const Vector3d& origin, std::vector<shader::Bone>& to) const;
  void append_forces(double time);

  const scene::Scene& scene;
  const model::Model& model;
  const scene::Character* character = nullptr;  // null without a skeleton
  const scene::Clip* clip = nullptr;
  std::size_t root = 0;  // the joint that the origin follows
  std::vector<shader::Bone> bones;
  std::vector<shader::Force> forces;
  std::vector<float> decay;
};

DriveSource::Impl::Impl(const scene::Scene& s, const model::Model& m) : scene(s), model(m) {
  const auto must_fit = [](const char* what, std::size_t of_scene, std::size_t of_model) {
    if (of_scene != of_model) {
      throw std::invalid_argument("DriveSource: the scene has " + std::to_string(of_scene) + " " + what +
                                  ", the model " + std::to_string(of_model));
    }
  };
  if (model.has_skeleton()) character = std::get_if<scene::Character>(&scene.geometry);
  must_fit("joints", character == nullptr ? 0 : character->skeleton.size(), model.joint_count);
  must_fit("forces", scene.forces.size(), model.force_count);
  must_fit("muscles", 0, model.muscle_count);
  if (character != nullptr) {
    clip = scene::find_clip(*character, scene.clip);
    while (root + 1 < character->skeleton.size() && !character->skeleton[root].skins) ++root;
  }
  const double h = 1.0 / (static_cast<double>(substeps()) * scene.fps);
  for (const model::Layer& layer : model.layers) {
    decay.push_back(static_cast<float>(scene::exact_exp(-layer.damping * h)));
  }
}

Vector3d DriveSource::Impl::origin(double time) const {
  if (character == nullptr) return {model.rest_origin[0], model.rest_origin[1], model.rest_origin[2]};
  const Vector3d place =
      scene::joint_transforms_at(*character, clip, time)[root].topRightCorner<3, 1>() * scene.scale;
  // The unit is a power of two: rounding to it is exact, and so are differences of origins.
  return (place / model.unit + Vector3d::Constant(0.5)).array().floor().matrix() * model.unit;
}

// pose_at's maps are in the file's metres; scale makes them the scene's, unit and origin the solver's. With
// rest positions x = (p - rest_origin) / unit a map p -> L p + t becomes x -> L x + (L rest_origin + t -
// origin) / unit.
void DriveSource::Impl::append_bones(double time, const Vector3d& origin,
                                     std::vector<shader::Bone>& to) const {
  if (character == nullptr) return;
  const Vector3d rest_origin(model.rest_origin[0], model.rest_origin[1], model.rest_origin[2]);
  for (const Eigen::Matrix4d& map : scene::pose_at(*character, clip, time)) {
    const Eigen::Matrix3d l = map.topLeftCorner<3, 3>();
    const Vector3d t = (l * rest_origin + map.topRightCorner<3, 1>() * scene.scale - origin) / model.unit;
    const auto f = [](double x) { return static_cast<float>(x); };
    to.push_back({f(l(0, 0)), f(l(0, 1)), f(l(0, 2)), f(t[0]),  //
                  f(l(1, 0)), f(l(1, 1)), f(l(1, 2)), f(t[1]),  //
                  f(l(2, 0)), f(l(2, 1)), f(l(2, 2)), f(t[2])});
  }
}

void DriveSource::Impl::append_forces(double time) {
  for (const scene::Force& force : scene.forces) {
    const bool acts = force.start <= time && time < force.end;
    const Vector3d f = acts ? Vector3d(force.vector / model.unit) : Vector3d(Vector3d::Zero());
    forces.push_back({static_cast<float>(f[0]), static_cast<float>(f[1]), static_cast<float>(f[2]), 0.0f});
  }
}

DriveSource::DriveSource(const scene::Scene& scene, const model::Model& model)
    : impl_(std::make_unique<Impl>(scene, model)) {}

DriveSource::~DriveSource() = default;

model::State DriveSource::initial_state() const {
  const Impl& impl = *impl_;
  const Vector3d origin = impl.origin(impl.scene.start);
  std::vector<shader::Bone> bones;
  impl.append_bones(impl.scene.start, origin, bones);
  return model::initial_state(impl.model, bones, {origin[0], origin[1], origin[2]});
}

model::Drive DriveSource::drive(std::uint64_t frame) {
  if (frame == 0)
    throw std::invalid_argument("DriveSource: frame 0 is the initial state; drives begin with frame 1");
  Impl& impl = *impl_;
  const std::uint64_t substeps = impl.substeps(), first = (frame - 1) * substeps;
  const Vector3d origin = impl.origin(impl.time(first + substeps));
  const Vector3d shift = (origin - impl.origin(impl.time(first))) / impl.model.unit;
  impl.bones.clear();
  impl.forces.clear();
  for (std::uint64_t s = 0; s < substeps; ++s) {
    impl.append_bones(impl.time(first + s + 1), origin, impl.bones);
    // A force acts through a substep or not at all: whether it does is settled where the substep begins.
    impl.append_forces(impl.time(first + s));
  }
  model::Drive drive;
  drive.substeps = static_cast<std::uint32_t>(substeps);
  drive.h = 1.0 / (static_cast<double>(substeps) * impl.scene.fps);
  for (int a = 0; a < 3; ++a) {
    const auto i = static_cast<std::size_t>(a);
    drive.origin[i] = origin[a];
    drive.origin_shift[i] = static_cast<float>(shift[a]);
    drive.gravity[i] = static_cast<float>(impl.scene.gravity[a] / impl.model.unit);
  }
  drive.bones = impl.bones;
  drive.forces = impl.forces;
  drive.decay = impl.decay;
  return drive;
}

}  // namespace fascicle::bake
