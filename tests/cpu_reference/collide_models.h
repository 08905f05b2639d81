// A single mass, or a body, with solids: shared by the tests of stage collide.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <numbers>
#include <random>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "cpu_reference/oracle/oracle.h"
#include "cpu_reference/solver/cpu_solver.h"
#include "tests/support/test_models.h"

namespace fascicle::tests {

using Eigen::AngleAxisd;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using model::Model;
using model::State;

inline constexpr double pi = std::numbers::pi;
inline constexpr double g = 9.81;
// A contact is at most 2^-18 working units away, and a position is rounded to float: half of 2^-23 for
// coordinates below 2.
inline constexpr double near_surface = 0x1p-18 + 0x1p-22;

// A solid's pose at one time, in metres, which are the working units here.
struct Solid {
  enum Shape { plane, sphere, capsule, box } shape = plane;
  Vector3d center = Vector3d::Zero();
  Matrix3d axes = Matrix3d::Identity();   // the second axis is a plane's normal and a capsule's axis
  Vector3d half_size = Vector3d::Zero();  // box: including its rounding; capsule: (0, half its axis, 0)
  double radius = 0.0;                    // plane: its thickness
};

// Signed distance of a point from the surface, negative inside, by the textbook formula of each shape.
inline double distance_to(const Solid& solid, const Vector3d& point) {
  const Vector3d p = solid.axes.transpose() * (point - solid.center);
  switch (solid.shape) {
    case Solid::plane:
      return p.y() - solid.radius;
    case Solid::sphere:
      return p.norm() - solid.radius;
    case Solid::capsule: {
      const double along = std::min(std::max(p.y(), -solid.half_size.y()), solid.half_size.y());
      return (p - Vector3d(0, along, 0)).norm() - solid.radius;
    }
    case Solid::box: {
      // Outside: to the nearest point of the box without its rounding. Inside: to the nearest face.
      const Vector3d core = solid.half_size - Vector3d::Constant(solid.radius);
      const Vector3d nearest = p.cwiseMax(-core).cwiseMin(core);
      if (nearest != p) return (p - nearest).norm() - solid.radius;
      return -(solid.half_size - p.cwiseAbs()).minCoeff();
    }
  }
  return 0.0;
}

inline void write_map(const Solid& solid, float* rows) {
  const Matrix3d turn = solid.axes.transpose();
  const Vector3d shift = -(turn * solid.center);
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) *rows++ = float(turn(r, c));
    *rows++ = float(shift[r]);
  }
}

// 1/s, the same as in scenes.
inline constexpr double lifting_rate = 5.0;

inline shader::Collider collider(const Solid& before, const Solid& at, double friction, double h) {
  shader::Collider c{};
  write_map(at, &c.xx);
  write_map(before, &c.before_xx);
  const Vector3d core =
      at.shape == Solid::box ? Vector3d(at.half_size - Vector3d::Constant(at.radius)) : at.half_size;
  c.half_x = float(core.x());
  c.half_y = float(core.y());
  c.half_z = float(core.z());
  c.radius = float(at.radius);
  c.friction = float(friction);
  c.lifted = float(1.0 - std::exp(-lifting_rate * h));
  c.is_plane = at.shape == Solid::plane ? 1.0f : 0.0f;
  return c;
}

struct Way {
  bool implicit = false, by_oracle = false;
};

inline model::SolverOptions options_of(const Model& model) {
  if (!model.is_implicit()) return {};
  return {.integrator = model::Integrator::implicit_step, .iterations = 8};
}

inline std::unique_ptr<model::Solver> make_solver(const Model& model, bool by_oracle) {
  if (by_oracle) return std::make_unique<cpu_reference::Oracle>(model, options_of(model));
  return cpu_reference::make_cpu_solver(model, options_of(model), 1);
}

template <class Check>
inline void for_each_way(const Check& check) {
  for (const bool implicit : {false, true})
    for (const bool by_oracle : {false, true}) {
      SCOPED_TRACE(std::string(implicit ? "implicit" : "explicit") +
                   (by_oracle ? ", Oracle" : ", CpuSolver"));
      check(Way{implicit, by_oracle});
    }
}

// A corner of a tetrahedron whose other corners are kinematic: without stiffness it is a free mass.
inline Model point_mass_model(bool implicit, std::uint32_t solids) {
  Mesh mesh = regular_tetrahedron();
  for (Vector3d& p : mesh.points) p *= 0.0625;
  Model model = make_model(mesh, {.alpha = 0.0f});
  for (const std::uint32_t i : {1u, 2u, 3u}) make_kinematic(model, i);
  fill_weights(model);
  // 1e-9 Pa accelerates by less than 1e-9 m/s^2.
  if (implicit) model = make_implicit(std::move(model), 1e-9);
  model.collider_count = solids;
  // Kinematic vertices may be inside solids.
  model.spared.assign(model.vertex_count, 0);
  check_model(model);
  return model;
}

inline Vector3d triple(const std::vector<float>& values, std::uint32_t i) {
  return Vector3d(values[3 * i], values[3 * i + 1], values[3 * i + 2]);
}

// A single mass among solids. `at(t)` gives the solids at time t.
struct PointMass {
  using Solids = std::vector<Solid>;
  using Moving = std::function<Solids(double)>;

  PointMass(const Way& way, const Moving& solids_at, const Vector3d& place, const Vector3d& speed,
            double step, const Vector3d& gravity = {0, -g, 0}, double mu = 0.0)
      : model(point_mass_model(way.implicit, std::uint32_t(solids_at(0).size()))),
        solver(make_solver(model, way.by_oracle)),
        drive(quiet_drive(model, step, 1, gravity)),
        at(solids_at),
        h(step),
        friction(mu) {
    load(place, speed);
  }
  PointMass(const Way& way, const Solid& solid, const Vector3d& place, const Vector3d& speed, double step,
            const Vector3d& gravity = {0, -g, 0}, double mu = 0.0)
      : PointMass(
            way, [=](double) { return Solids{solid}; }, place, speed, step, gravity, mu) {}

  void load(const Vector3d& place, const Vector3d& speed) {
    State state = solver->save();
    for (std::size_t k = 0; k < 3; ++k) {
      state.positions[k] = float(place[int(k)]);
      state.velocities[k] = float(speed[int(k)]);
    }
    solver->load(state);
    q = place;
    v = speed;
  }
  void step() {
    const Solids before = at(time), now = at(time + h);
    for (std::size_t k = 0; k < now.size() && acts; ++k)
      drive.colliders[k] = collider(before[k], now[k], friction, h);
    solver->submit(drive.get(), {.positions = true, .velocities = true});
    const model::Frame frame = solver->collect();
    q = triple(frame.positions, 0);
    v = triple(frame.velocities, 0);
    time += h;
  }
  // The least distance to the first solid over these steps.
  double least_distance(int steps) {
    double least = std::numeric_limits<double>::infinity();
    for (int k = 0; k < steps; ++k) {
      step();
      least = std::min(least, distance_to(at(time)[0], q));
    }
    return least;
  }

  Model model;
  std::unique_ptr<model::Solver> solver;
  TestDrive drive;
  Moving at;
  double h, friction, time = 0.0;
  bool acts = true;  // otherwise the solids are far away
  Vector3d q, v;
};

inline Solid floor_at(double thickness = 0.0) {
  Solid floor;
  floor.radius = thickness;
  return floor;
}

// A plane through the origin, rotated by an angle about z; downhill is (-cos, -sin, 0).
inline Solid slope(double degrees) {
  Solid plane;
  plane.axes = AngleAxisd(degrees * pi / 180.0, Vector3d::UnitZ()).toRotationMatrix();
  return plane;
}

inline Matrix3d random_rotation(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random))
      .normalized()
      .toRotationMatrix();
}

inline Solid random_solid(Solid::Shape shape, std::mt19937& random) {
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  Solid solid;
  solid.shape = shape;
  solid.center = 0.2 * Vector3d(unit(random), unit(random), unit(random));
  solid.axes = random_rotation(random);
  solid.radius = 0.02 + 0.08 * unit(random);
  if (shape == Solid::capsule) solid.half_size = Vector3d(0, 0.05 + 0.2 * unit(random), 0);
  if (shape == Solid::box)
    solid.half_size =
        Vector3d::Constant(solid.radius) + 0.2 * Vector3d(unit(random), unit(random), unit(random));
  return solid;
}

// A plate 5 mm thick and 8 m wide, with any orientation.
inline Solid plate(const Matrix3d& axes) {
  Solid box;
  box.shape = Solid::box;
  box.axes = axes;
  box.half_size = {4.0, 0.0025, 4.0};
  return box;
}

// Records the output of one stage over a run.
struct StageProbe : model::Probe {
  void on_stage(const model::Where& where, std::span<const float> values) override {
    if (where.stage == stage) seen.emplace_back(values.begin(), values.end());
  }
  model::Stage stage = model::Stage::collide;
  std::vector<std::vector<float>> seen;
};

}  // namespace fascicle::tests
