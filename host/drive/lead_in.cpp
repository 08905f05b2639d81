#include "host/drive/lead_in.h"

#include <algorithm>
#include <cmath>

namespace fascicle::drive {

namespace {

// m/s, root mean square over the free vertices; 0 if there are none.
double speed(const model::Model& model, const std::vector<float>& velocities) {
  double sum = 0.0;
  std::uint64_t count = 0;
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    if (model.is_kinematic(i)) continue;
    for (std::size_t c = 0; c < 3; ++c) {
      const double v = double{velocities[3 * std::size_t{i} + c]};
      sum += v * v;
    }
    ++count;
  }
  return count == 0 ? 0.0 : std::sqrt(sum / static_cast<double>(count)) * model.unit;
}

// m; for several characters the smallest of those with flesh.
double smallest_extent(const scene::Scene& scene, const model::Model& model) {
  const std::vector<double> extents = model::extents(model, scene::first_joints(scene));
  double smallest = INFINITY;
  for (const std::size_t k : scene::characters_with_flesh(scene))
    smallest = std::min(smallest, extents.at(k));
  return smallest;
}

}  // namespace

double largest_distance(const model::Model& model, const std::vector<float>& positions,
                        const std::array<double, 3>& origin, const model::State& state) {
  double largest = 0.0;
  for (std::size_t i = 0; i < positions.size(); i += 3) {
    double squared = 0.0;
    for (std::size_t c = 0; c < 3; ++c) {
      const double origins = (origin[c] - state.origin[c]) / model.unit;
      const double d = double{positions[i + c]} - double{state.positions[i + c]} + origins;
      squared += d * d;
    }
    largest = std::max(largest, squared);
  }
  return std::sqrt(largest) * model.unit;
}

LeadIn lead_in(const scene::Scene& scene, const model::Model& model, DriveSource& drives,
               model::Solver& solver, const std::function<bool()>& stop) {
  LeadIn result;
  const auto stopped = [&] { return result.stopped = result.stopped || (stop && stop()); };
  const auto step = [&](const model::Drive& drive, model::Read what) {
    solver.submit(drive, what);
    return solver.collect();
  };
  const scene::Motion& motion = scene.motion;
  model::State state = drives.preroll_state();
  solver.load(state);
  for (std::uint64_t k = 1; k <= drives.preroll_frames() && !stopped(); ++k) {
    step(drives.preroll_drive(k), {});
    result.summary.preroll_frames = k;
  }
  const auto most = static_cast<std::uint64_t>(std::llround(motion.settle * scene.fps));
  for (std::uint64_t k = 1; k <= most && !stopped(); ++k) {
    const model::Frame frame = step(drives.settle_drive(), {.velocities = true});
    result.summary.settle_frames = k;
    result.summary.settled_speed = speed(model, frame.velocities);
    if (*result.summary.settled_speed < scene::still_speed) break;
  }
  result.state = drives.started(solver.save());
  solver.load(result.state);
  if (!motion.seamless) return result;
  const double tolerance = motion.seamless_tolerance * smallest_extent(scene, model);
  const std::uint64_t frames = scene::cycle_frames(scene);
  for (std::uint64_t cycle = 1; cycle <= motion.seamless_cycles; ++cycle) {
    for (std::uint64_t k = 1; k <= frames; ++k) {
      if (stopped()) return result;
      step(drives.drive(k), {});
    }
    const model::State next = drives.begun_again(solver.save());
    result.summary.jump = largest_distance(model, result.state.positions, result.state.origin, next);
    result.summary.cycles = cycle;
    result.state = next;
    solver.load(next);
    if (*result.summary.jump <= tolerance) break;
  }
  return result;
}

}  // namespace fascicle::drive
