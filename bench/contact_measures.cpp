#include "bench/contact_measures.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

#include <Eigen/Geometry>

#include "host/model/overlap.h"
#include "host/scene/solids.h"

namespace fascicle::bench {
namespace {

using Eigen::Vector3d;

Vector3d vertex(const std::vector<float>& values, std::size_t i) {
  return {double{values[3 * i]}, double{values[3 * i + 1]}, double{values[3 * i + 2]}};
}

// In metres, in the world.
Vector3d place(const model::Model& model, const model::Frame& frame, std::size_t i) {
  return Vector3d(frame.origin[0], frame.origin[1], frame.origin[2]) +
         model.unit * vertex(frame.positions, i);
}

Vector3d mean_by_mass(const model::Model& model, const std::function<Vector3d(std::size_t)>& of) {
  Vector3d sum = Vector3d::Zero();
  for (std::size_t i = 0; i < model.vertex_count; ++i) sum += model.mass[i] * of(i);
  return sum / std::accumulate(model.mass.begin(), model.mass.end(), 0.0);
}

// m; how far the deepest vertex of any frame is below the surfaces of the scene's solids.
double deepest_in_solids(const model::Model& model, drive::DriveSource& drives, const Frames& frames) {
  double deepest = 0.0;
  for (const model::Frame& frame : frames)
    for (const scene::Solid& solid : drives.solids(frame.index))
      for (std::size_t i = 0; i < model.vertex_count; ++i)
        deepest = std::max(deepest, -scene::distance_to(solid, place(model, frame, i)));
  return deepest;
}

// m/s; of a set of vertices over the last frames.
struct Speed {
  double mean_square_root = 0.0, fastest = 0.0;
};
Speed last_speed(const model::Model& model, const std::vector<std::uint32_t>& vertices, const Frames& frames,
                 double seconds, double fps) {
  const auto count = std::min(frames.size(), static_cast<std::size_t>(std::lround(seconds * fps)));
  double sum = 0.0, number = 0.0, most = 0.0;
  for (std::size_t k = frames.size() - count; k < frames.size(); ++k)
    for (const std::uint32_t i : vertices) {
      const double square = (model.unit * vertex(frames[k].velocities, i)).squaredNorm();
      sum += square;
      most = std::max(most, square);
      number += 1.0;
    }
  return {std::sqrt(sum / number), std::sqrt(most)};
}

std::vector<std::uint32_t> free_vertices(const model::Model& model) {
  std::vector<std::uint32_t> vertices;
  for (std::uint32_t i = 0; i < model.vertex_count; ++i)
    if (!model.is_kinematic(i)) vertices.push_back(i);
  return vertices;
}

// m/s; from the distance these vertices move between frames, so that faster vibration does not count.
Speed last_way(const model::Model& model, const std::vector<std::uint32_t>& vertices, const Frames& frames,
               double seconds, double fps) {
  const auto count = std::min(frames.size() - 1, static_cast<std::size_t>(std::lround(seconds * fps)));
  double sum = 0.0, most = 0.0;
  for (std::size_t k = frames.size() - count; k < frames.size(); ++k)
    for (const std::uint32_t i : vertices) {
      const double square =
          (fps * (place(model, frames[k], i) - place(model, frames[k - 1], i))).squaredNorm();
      sum += square;
      most = std::max(most, square);
    }
  return {std::sqrt(sum / static_cast<double>(count * vertices.size())), std::sqrt(most)};
}

// Surface vertices that may touch flesh.
std::vector<std::uint32_t> free_skin(const model::Model& model) {
  std::vector<std::uint32_t> vertices;
  for (const shader::ContactPoint& point : model.contact)
    if (!model.is_kinematic(point.vertex)) vertices.push_back(point.vertex);
  return vertices;
}

std::size_t inverted(const model::Model& model, const std::vector<float>& positions) {
  std::size_t count = 0;
  for (std::size_t t = 0; t < model.tetrahedron.size(); t += 4) {
    const auto edge = [&](std::size_t k) -> Vector3d {
      return vertex(positions, model.tetrahedron[t + k]) - vertex(positions, model.tetrahedron[t]);
    };
    if (!(edge(1).cross(edge(2)).dot(edge(3)) > 0.0)) ++count;
  }
  return count;
}

double volume(const model::Model& model, const std::vector<float>& positions) {
  double six = 0.0;
  for (std::size_t t = 0; t < model.tetrahedron.size(); t += 4) {
    const auto edge = [&](std::size_t k) -> Vector3d {
      return vertex(positions, model.tetrahedron[t + k]) - vertex(positions, model.tetrahedron[t]);
    };
    six += edge(1).cross(edge(2)).dot(edge(3));
  }
  return six;
}

// Keeps the goals of the last iteration.
struct GoalProbe : model::Probe {
  void on_stage(const model::Where& where, std::span<const float> values) override {
    if (where.stage == model::Stage::goal) goals.assign(values.begin(), values.end());
  }
  std::vector<float> goals;
};

}  // namespace

std::vector<double> flesh_forces(const model::Model& model, model::Solver& solver,
                                 const model::Drive& drive) {
  GoalProbe probe;
  solver.submit(drive, {.positions = true}, &probe);
  const model::Frame frame = solver.collect();
  std::vector<double> forces;
  for (std::size_t k = 0; k < frame.positions.size(); ++k)
    forces.push_back(model.unit * model.mass[k / 3] * model.stiffness[k / 3] *
                     (double{probe.goals[k]} - double{frame.positions[k]}));
  return forces;
}

double force_on_top(const model::Model& model, const std::vector<double>& forces) {
  float top = model.rest[1];
  for (std::size_t i = 0; i < model.vertex_count; ++i) top = std::max(top, model.rest[3 * i + 1]);
  double sum = 0.0;
  for (std::size_t i = 0; i < model.vertex_count; ++i)
    if (model.rest[3 * i + 1] > top - 1e-4f) sum += forces[3 * i + 1];
  return sum;
}

double rod_force(const scene::Scene& scene) {
  const auto& bar = std::get<scene::Bar>(scene.geometry);
  double pressed = 0.0;
  for (const scene::Collider& collider : scene.colliders)
    if (!collider.offsets.empty()) pressed -= collider.offsets.back().y();
  return scene.layers.front().youngs_modulus.value() * bar.size.x() * bar.size.z() * pressed / bar.size.y();
}

Measures measure_squeeze(const scene::Scene& scene, const model::Model& model, drive::DriveSource& drives,
                         const Frames& frames, double force) {
  return {{force_name, force},
          {"deepest vertex behind a plane, um", 1e6 * deepest_in_solids(model, drives, frames)},
          {"RMS speed, last half second, mm/s",
           1e3 * last_speed(model, free_vertices(model), frames, 0.5, scene.fps).mean_square_root}};
}

Measures measure_drop(const scene::Scene& scene, const model::Model& model, drive::DriveSource& drives,
                      const Frames& frames) {
  const scene::Solid floor = drives.solids(frames.back().index).front();
  std::vector<double> heights;
  for (const model::Frame& frame : frames)
    heights.push_back(scene::distance_to(
        floor, mean_by_mass(model, [&](std::size_t i) { return place(model, frame, i); })));
  std::size_t landed = 1;
  while (landed + 1 < heights.size() && heights[landed + 1] < heights[landed]) ++landed;
  const auto rest = static_cast<std::size_t>(std::lround(scene.fps / 2.0));
  const double at_rest =
      std::accumulate(heights.end() - static_cast<std::ptrdiff_t>(rest), heights.end(), 0.0) /
      static_cast<double>(rest);
  const double highest =
      *std::max_element(heights.begin() + static_cast<std::ptrdiff_t>(landed), heights.end());
  const Speed speed = last_speed(model, free_vertices(model), frames, 0.5, scene.fps);
  const Vector3d creep = mean_by_mass(
      model, [&](std::size_t i) -> Vector3d { return model.unit * vertex(frames.back().velocities, i); });
  return {{"centre of mass at rest, mm above the floor", 1e3 * at_rest},
          {"lowest as it lands, mm above the floor", 1e3 * heights[landed]},
          {"highest after it has landed, mm above the floor", 1e3 * highest},
          {"volume at the end, % of that at rest",
           100.0 * volume(model, frames.back().positions) / volume(model, model.rest)},
          {"deepest vertex in the floor, um", 1e6 * deepest_in_solids(model, drives, frames)},
          {"RMS speed, last half second, mm/s", 1e3 * speed.mean_square_root},
          {"fastest vertex, last half second, mm/s", 1e3 * speed.fastest},
          {"creep of the whole body at the end, mm/s", 1e3 * creep.norm()}};
}

Measures measure_overlap(const model::Model& model, const Frames& frames,
                         std::vector<float> model::Frame::*places) {
  const model::OverlapMeter meter(model);
  double sum = 0.0, largest = 0.0, deepest = 0.0, last = 0.0;
  std::size_t turned = 0;
  for (const model::Frame& frame : frames) {
    const model::Overlap overlap = meter.of(frame.*places);
    sum += overlap.volume;
    largest = std::max(largest, overlap.volume);
    deepest = std::max(deepest, overlap.deepest);
    last = overlap.volume;
    turned = std::max(turned, inverted(model, frame.*places));
  }
  return {{"overlap, mean, cm3", 1e6 * sum / static_cast<double>(frames.size())},
          {"overlap, largest, cm3", 1e6 * largest},
          {"overlap as it is held, last frame, cm3", 1e6 * last},
          {"deepest, mm", 1e3 * deepest},
          {"inverted tetrahedra, largest", static_cast<double>(turned)},
          {"inverted tetrahedra, last frame", static_cast<double>(inverted(model, frames.back().*places))}};
}

Measures measure_crouch(const scene::Scene& scene, const model::Model& model, const Frames& frames) {
  Measures found = measure_overlap(model, frames, &model::Frame::positions);
  const Speed speed = last_speed(model, free_vertices(model), frames, 1.0, scene.fps);
  const Speed skin = last_way(model, free_skin(model), frames, 1.0, scene.fps);
  found.emplace_back("RMS speed of the skin from frame to frame, mm/s", 1e3 * skin.mean_square_root);
  found.emplace_back("fastest vertex of the skin, the same, mm/s", 1e3 * skin.fastest);
  found.emplace_back("RMS speed, last second, mm/s", 1e3 * speed.mean_square_root);
  found.emplace_back("fastest vertex, last second, mm/s", 1e3 * speed.fastest);
  return found;
}

double furthest_from_skeleton(const model::Model& model, const Frames& frames) {
  double furthest = 0.0;
  for (const model::Frame& frame : frames)
    for (std::uint32_t i = 0; i < model.vertex_count; ++i)
      if (model.is_kinematic(i) && !frame.skinned.empty())
        furthest =
            std::max(furthest, (model.unit * (vertex(frame.positions, i) - vertex(frame.skinned, i))).norm());
  return furthest;
}

}  // namespace fascicle::bench
