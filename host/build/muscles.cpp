#include "host/build/muscles.h"

#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

#include "host/base/trigonometry.h"
#include "host/build/message.h"
#include "host/rig/pose.h"
#include "host/scene/muscle_bones.h"

namespace fascicle::build {

namespace {

// The remainder of a unit direction after a projection; shorter than this it is undefined (sine of 3
// degrees).
constexpr double least_direction = 0.05;

// A muscle's bone, in metres.
struct Carrier {
  Vector3d from, along;  // `along`: to the other end
  double length;
  std::vector<double> share;  // of each vertex's weights
};

Carrier carrier_of(const scene::MuscleBones& bones, double scale, const Measures& measures) {
  const Vector3d from = scale * bones.from, along = scale * (bones.to - bones.from);
  return {from, along, std::sqrt(along.squaredNorm()), measures.shares_of(bones.moves)};
}

Vector3d unit_or_zero(const Vector3d& v, double least) {
  const double length = std::sqrt(v.squaredNorm());
  return length > least ? Vector3d(v / length) : Vector3d(Vector3d::Zero());
}

// n_r (away from the bone and across the fibre), the bone's axis, and the direction around it.
shader::RegionFrame frame_at(const Vector3d& place, const Vector3d& fibre, const Carrier& carrier) {
  const Vector3d axis = carrier.along / carrier.length;
  const Vector3d offset = place - carrier.from;
  const Vector3d radial = unit_or_zero(offset - offset.dot(axis) * axis, 0.0);
  const Vector3d normal = unit_or_zero(radial - radial.dot(fibre) * fibre, least_direction);
  const Vector3d around = axis.cross(radial);
  using model::as_factor;
  return {as_factor(normal[0]), as_factor(normal[1]), as_factor(normal[2]),
          as_factor(axis[0]),   as_factor(axis[1]),   as_factor(axis[2]),
          as_factor(around[0]), as_factor(around[1]), as_factor(around[2])};
}

}  // namespace

double muscle_profile(double s) {
  const double x = std::numbers::pi * s;
  return (base::exact_sin(x) - base::exact_sin(3.0 * x)) / 2.0;
}

void write_muscles(const scene::Scene& scene, const Body& body, WhereTest& test, model::Model& model,
                   Report& report) {
  const auto* character = std::get_if<rig::Character>(&scene.geometry);
  if (character == nullptr || scene.muscles.empty()) return;
  const std::size_t n = model.vertex_count;
  model.muscle_count = static_cast<std::uint32_t>(scene.muscles.size());
  std::vector<std::vector<shader::RegionMuscle>> of_region(n);
  std::vector<double> nearest(n, -1.0);
  model.region_frame.assign(n, shader::RegionFrame{});
  for (std::uint32_t m = 0; m < model.muscle_count; ++m) {
    const scene::Muscle& muscle = scene.muscles[m];
    const std::string key = "muscle." + muscle.name;
    const Carrier carrier = carrier_of(scene::muscle_bones(*character, muscle), scene.scale, test.measures());
    std::vector<char> here(n, 1);
    if (!muscle.where.empty()) here = test.contains(muscle.where, key, scene.source);
    std::size_t count = 0, with_fibre = 0;
    for (std::uint32_t r = 0; r < n; ++r) {
      const scene::Layer& layer = scene.layers[model.layer_of(r)];
      if (!here[r] || layer.kinematic || model.is_kinematic(r) || carrier.share[r] < least_muscle_share)
        continue;
      if (!muscle.layer.empty() && layer.name != muscle.layer) continue;
      const Vector3d offset = body.mesh.vertices[r] - carrier.from;
      const double s = offset.dot(carrier.along) / (carrier.length * carrier.length);
      if (!(s > 0.0 && s < 1.0)) continue;
      const double from_axis = std::sqrt((offset - s * carrier.along).squaredNorm());
      const auto beta = static_cast<double>(model.beta[r]);
      of_region[r].push_back({m, model::as_factor(muscle.gain * muscle_profile(s) * beta),
                              model::as_factor(muscle.twist * from_axis / carrier.length)});
      ++count;
      with_fibre += beta > 0.0 ? 1u : 0u;
      // If several bones apply, the nearest gives the directions.
      if (nearest[r] >= 0.0 && nearest[r] <= from_axis) continue;
      nearest[r] = from_axis;
      const float* fibre = &model.fibre[3 * std::size_t{r}];
      model.region_frame[r] =
          frame_at(body.mesh.vertices[r], Vector3d(fibre[0], fibre[1], fibre[2]), carrier);
    }
    if (count == 0)
      fail(scene.source,
           key +
               ": holds no vertex; its bone's joints must move flesh beside the bone, inside `where` "
               "and `layer`");
    if (!muscle.contraction_channel.empty() &&
        scene::find_channel(rig::find_clip(*character, scene.clip),
                            scene::contraction_channel(*character, muscle)) == nullptr)
      warn(report, key + ": the clip does not move its contraction_channel \"" + muscle.contraction_channel +
                       "\", so it does not contract");
    if (with_fibre == 0 && muscle.gain != 0.0)
      warn(report, key + ": none of its flesh has a fibre with beta above 0, so it does not bulge");
  }
  model.muscle_offset.push_back(0);
  for (const auto& entries : of_region) {
    model.region_muscle.insert(model.region_muscle.end(), entries.begin(), entries.end());
    model.muscle_offset.push_back(static_cast<std::uint32_t>(model.region_muscle.size()));
  }
}

}  // namespace fascicle::build
