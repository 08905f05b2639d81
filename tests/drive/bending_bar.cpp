#include "tests/drive/bending_bar.h"

#include <array>
#include <cmath>

#include "cpu_reference/solver/cpu_solver.h"
#include "host/drive/drive_source.h"
#include "host/drive/lead_in.h"
#include "tests/support/test_models.h"

namespace fascicle::tests {

using Eigen::Vector3d;

BendingBar bending_bar(double seconds) {
  BendingBar bar;
  const Mesh mesh = kuhn_bar(12, 4, 4, 0.05);
  BodyOptions options{.alpha = 0.3f, .damping = 6.0};
  options.kinematic = [](const Vector3d& p) { return std::abs(p.y() - 0.1) + std::abs(p.z() - 0.1) < 1e-9; };
  bar.model = make_model(mesh, options);
  add_skeleton(bar.model);

  rig::Character character;
  for (int j = 0; j < 2; ++j) {
    rig::Joint joint;
    joint.parent = j - 1;
    joint.rest_translation = Vector3d(0.3 * j, j == 0 ? 0.1 : 0.0, j == 0 ? 0.1 : 0.0);
    joint.rest_local.topRightCorner<3, 1>() = joint.rest_translation;
    joint.inverse_bind.topRightCorner<3, 1>() = -Vector3d(0.3 * j, 0.1, 0.1);
    joint.skins = true;
    character.skeleton.push_back(joint);
  }
  // Only used by file writers: the model has its own skinning.
  character.joints.assign(bar.model.surface_count(), {});
  character.weights.assign(bar.model.surface_count(), {1.0});
  bar.scene.geometry = character;
  bar.scene.fps = 60.0;
  bar.scene.end = seconds;
  bar.scene.solver.substeps = 8;
  bar.scene.motion.rest = scene::Rest::sculpted;
  return bar;
}

std::array<double, 2> about_z(double angle) {
  return {std::sin(angle / 2.0), std::cos(angle / 2.0)};
}

rig::Channel root_channel(const std::vector<RootKey>& keys, rig::Interpolation interpolation) {
  rig::Channel channel{0, rig::ChannelPath::translation, interpolation, {}, {}};
  for (const RootKey& key : keys) {
    channel.times.push_back(key.time);
    for (int c = 0; c < 3; ++c) channel.values.push_back(key.place[c] + (c > 0 ? 0.1 : 0.0));
  }
  return channel;
}

rig::Channel turn_channel(std::uint32_t joint, const std::vector<double>& times,
                          const std::vector<double>& angles) {
  rig::Channel channel{joint, rig::ChannelPath::rotation, rig::Interpolation::linear, times, {}};
  for (const double angle : angles) {
    const auto [z, w] = about_z(angle);
    channel.values.insert(channel.values.end(), {0.0, 0.0, z, w});
  }
  return channel;
}

namespace {

std::vector<Vector3d> world(const model::Model& model, const std::vector<float>& values,
                            const std::array<double, 3>& origin) {
  std::vector<Vector3d> points(values.size() / 3);
  for (std::size_t i = 0; i < points.size(); ++i)
    for (std::size_t c = 0; c < 3; ++c)
      points[i][static_cast<int>(c)] = origin[c] + model.unit * double{values[3 * i + c]};
  return points;
}

}  // namespace

Walked run(const BendingBar& bar, std::uint64_t frames) {
  Walked result;
  drive::DriveSource drives(bar.scene, bar.model);
  const auto integrator =
      bar.model.is_implicit() ? model::Integrator::implicit_step : model::Integrator::explicit_step;
  const auto solver = cpu_reference::make_cpu_solver(bar.model, {.integrator = integrator}, 2);
  const model::State start = drive::lead_in(bar.scene, bar.model, drives, *solver).state;
  solver->load(start);
  result.positions.push_back(world(bar.model, start.positions, start.origin));
  result.skinned.push_back(world(bar.model, start.skinned, start.origin));
  for (std::uint64_t k = 1; k <= frames; ++k) {
    solver->submit(drives.drive(k), {.positions = true, .skinned = true});
    const model::Frame frame = solver->collect();
    result.positions.push_back(world(bar.model, frame.positions, frame.origin));
    result.skinned.push_back(world(bar.model, frame.skinned, frame.origin));
  }
  result.last = solver->save();
  return result;
}

double furthest(const std::vector<Vector3d>& a, const std::vector<Vector3d>& b, const Vector3d& shift) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, (a[i] - b[i] - shift).norm());
  return largest;
}

}  // namespace fascicle::tests
