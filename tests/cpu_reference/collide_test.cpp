// Flesh does not enter solids: closed forms of one vertex against planes, spheres, capsules and boxes that
// stand, move and turn, by the Oracle and by CpuSolver, explicit and implicit.
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <numbers>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "cpu_reference/oracle/oracle.h"
#include "cpu_reference/solver/cpu_solver.h"
#include "tests/support/bar_model.h"
#include "tests/support/test_models.h"

namespace fascicle::tests {

namespace {

using cpu_reference::make_cpu_solver;
using cpu_reference::Oracle;
using cpu_reference::Simd;
using Eigen::AngleAxisd;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using model::Model;
using model::State;

constexpr double pi = std::numbers::pi;
constexpr double g = 9.81;
// What touches is at most 2^-18 working units away, and a place is rounded to float: half of 2^-23 of a
// coordinate below 2.
constexpr double near_surface = 0x1p-18 + 0x1p-22;

// A solid as it stands at one time; metres, which are the working units here.
struct Solid {
  enum Shape { plane, sphere, capsule, box } shape = plane;
  Vector3d center = Vector3d::Zero();
  Matrix3d axes = Matrix3d::Identity();   // a plane's normal and a capsule's axis are the second
  Vector3d half_size = Vector3d::Zero();  // of a box with its rounding, of a capsule (0, half its axis, 0)
  double radius = 0.0;                    // of a plane: its thickness
};

// How far a point is from the surface, below 0 inside: as a text book has it, shape by shape.
double distance_to(const Solid& solid, const Vector3d& point) {
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
      // Outside: to the nearest point of the box without its rounding. Inside: to its nearest face.
      const Vector3d core = solid.half_size - Vector3d::Constant(solid.radius);
      const Vector3d nearest = p.cwiseMax(-core).cwiseMin(core);
      if (nearest != p) return (p - nearest).norm() - solid.radius;
      return -(solid.half_size - p.cwiseAbs()).minCoeff();
    }
  }
  return 0.0;
}

void write_map(const Solid& solid, float* rows) {
  const Matrix3d turn = solid.axes.transpose();
  const Vector3d shift = -(turn * solid.center);
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) *rows++ = float(turn(r, c));
    *rows++ = float(shift[r]);
  }
}

// 1/s, as scenes have it.
constexpr double lifting_rate = 5.0;

shader::Collider collider(const Solid& before, const Solid& at, double friction, double h) {
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

model::SolverOptions options_of(const Model& model) {
  if (!model.is_implicit()) return {};
  return {.integrator = model::Integrator::implicit_step, .iterations = 8};
}

std::unique_ptr<model::Solver> make_solver(const Model& model, bool by_oracle) {
  if (by_oracle) return std::make_unique<Oracle>(model, options_of(model));
  return make_cpu_solver(model, options_of(model), 1);
}

template <class Check>
void for_each_way(const Check& check) {
  for (const bool implicit : {false, true})
    for (const bool by_oracle : {false, true}) {
      SCOPED_TRACE(std::string(implicit ? "implicit" : "explicit") +
                   (by_oracle ? ", Oracle" : ", CpuSolver"));
      check(Way{implicit, by_oracle});
    }
}

// The corner of a tetrahedron whose others are held: without stiffness it is a mass by itself.
Model point_mass_model(bool implicit, std::uint32_t solids) {
  Mesh mesh = regular_tetrahedron();
  for (Vector3d& p : mesh.points) p *= 0.0625;
  Model model = make_model(mesh, {.alpha = 0.0f});
  for (const std::uint32_t i : {1u, 2u, 3u}) make_kinematic(model, i);
  fill_weights(model);
  // 1e-9 Pa pulls by less than 1e-9 m/s^2.
  if (implicit) model = make_implicit(std::move(model), 1e-9);
  model.collider_count = solids;
  // The held ones may lie anywhere.
  model.spared.assign(model.vertex_count, 0);
  check_model(model);
  return model;
}

Vector3d triple(const std::vector<float>& values, std::uint32_t i) {
  return Vector3d(values[3 * i], values[3 * i + 1], values[3 * i + 2]);
}

// A mass by itself among solids. `at(t)`: where they stand at a time.
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
  // The least distance to the first solid on the way.
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
  bool acts = true;  // else the solids are far away
  Vector3d q, v;
};

Solid floor_at(double thickness = 0.0) {
  Solid floor;
  floor.radius = thickness;
  return floor;
}

// Restitution 0: once it has come down it stays there.
TEST(Collide, WhatFallsOnAPlaneStaysOnIt) {
  for_each_way([](const Way& way) {
    for (const double thickness : {0.0, 0.0625})
      for (const double fps : {60.0, 240.0}) {
        PointMass mass(way, floor_at(thickness), {0.1, 0.3, 0.2}, {0, 0, 0}, 1.0 / fps);
        double highest = 0.0, fastest = 0.0;
        bool has_landed = false;
        for (int k = 0; k < int(fps); ++k) {
          mass.step();
          EXPECT_GE(mass.q.y(), thickness - near_surface);
          if (has_landed) {
            highest = std::max(highest, mass.q.y() - thickness);
            fastest = std::max(fastest, mass.v.norm());
          }
          has_landed = has_landed || mass.q.y() < thickness + near_surface;
        }
        EXPECT_TRUE(has_landed);
        EXPECT_LT(highest, near_surface) << fps;
        // A place's rounding, over h.
        EXPECT_LT(fastest, near_surface * fps) << fps;
      }
  });
}

TEST(Collide, TheChecksSeeASolidThatDoesNotAct) {
  for_each_way([](const Way& way) {
    PointMass mass(way, floor_at(), {0.1, 0.3, 0.2}, {0, 0, 0}, 1.0 / 240.0);
    mass.acts = false;
    EXPECT_LT(mass.least_distance(240), -1.0);
  });
}

// A plane through the origin, turned by an angle about z: down along it is (-cos, -sin, 0).
Solid slope(double degrees) {
  Solid plane;
  plane.axes = AngleAxisd(degrees * pi / 180.0, Vector3d::UnitZ()).toRotationMatrix();
  return plane;
}

TEST(Collide, WhatIsSteeperThanFrictionSlidesAndTheRestSticks) {
  static constexpr double h = 1.0 / 240.0;
  for_each_way([](const Way& way) {
    for (const double degrees : {5.0, 20.0, 40.0})
      for (const double mu : {0.0, 0.25, 0.5, 1.0}) {
        const double a = degrees * pi / 180.0, pull = g * (std::sin(a) - mu * std::cos(a));
        PointMass mass(way, slope(degrees), {0, 0, 0}, {0, 0, 0}, h, {0, -g, 0}, mu);
        for (int k = 0; k < 240; ++k) mass.step();
        SCOPED_TRACE(std::to_string(degrees) + " degrees, friction " + std::to_string(mu));
        EXPECT_LT(std::abs(distance_to(slope(degrees), mass.q)), 4 * near_surface);
        if (pull > 0.0) {
          EXPECT_NEAR(mass.v.norm(), pull * mass.time, 0.01 * pull * mass.time);
          EXPECT_LT(mass.v.y(), 0.0);
        } else {
          // 240 roundings of a coordinate of a hundredth, all to the same side.
          EXPECT_LT(mass.q.norm(), 240 * 0x1p-30 + near_surface);
        }
      }
  });
}

Matrix3d random_rotation(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random))
      .normalized()
      .toRotationMatrix();
}

Solid random_solid(Solid::Shape shape, std::mt19937& random) {
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

// Shot at its middle from a random side, a vertex ends at the surface: friction takes off all of its sliding.
// It then stands where it began as seen along the normal, off a round surface by (way)^2 / 2 radius at most.
TEST(Collide, EveryShapeHoldsWhatIsShotAtItAtItsSurface) {
  static constexpr double h = 1.0 / 480.0, speed = 1.0;
  for_each_way([](const Way& way) {
    std::mt19937 random(3);
    std::normal_distribution<double> normal;
    for (const Solid::Shape shape : {Solid::plane, Solid::sphere, Solid::capsule, Solid::box})
      for (int trial = 0; trial < 12; ++trial) {
        const Solid solid = random_solid(shape, random);
        Vector3d from = Vector3d(normal(random), normal(random), normal(random)).normalized();
        if (shape == Solid::plane && from.dot(solid.axes.col(1)) < 0.2) from = solid.axes.col(1);
        PointMass mass(way, solid, solid.center + 0.5 * from, -speed * from, h, {0, 0, 0}, 100.0);
        EXPECT_GT(mass.least_distance(360), -2 * near_surface) << shape << ' ' << trial;
        EXPECT_LT(distance_to(solid, mass.q), 2 * near_surface + h * h * speed * speed / (2 * solid.radius))
            << shape << ' ' << trial;
        EXPECT_LT(mass.v.norm(), 1e-2) << shape << ' ' << trial;
      }
  });
}

// Shot anywhere without friction, it goes around.
TEST(Collide, NothingEntersAShapeOnItsWayAroundIt) {
  for_each_way([](const Way& way) {
    std::mt19937 random(4);
    std::normal_distribution<double> normal;
    int touched = 0;
    for (const Solid::Shape shape : {Solid::plane, Solid::sphere, Solid::capsule, Solid::box})
      for (int trial = 0; trial < 30; ++trial) {
        const Solid solid = random_solid(shape, random);
        const auto direction = [&] {
          return Vector3d(normal(random), normal(random), normal(random)).normalized();
        };
        Vector3d from = direction();
        if (shape == Solid::plane && from.dot(solid.axes.col(1)) < 0.2) from = solid.axes.col(1);
        const Vector3d start = solid.center + 0.5 * from, aim = solid.center + 0.1 * direction();
        PointMass mass(way, solid, start, (aim - start).normalized() * 3.0, 1.0 / 60.0, {0, 0, 0}, 0.0);
        if (distance_to(solid, start) < 0.01) continue;
        const Vector3d speed = mass.v;
        EXPECT_GT(mass.least_distance(30), -2 * near_surface) << shape << ' ' << trial;
        touched += (mass.v - speed).norm() > 1e-3;
        EXPECT_LT(mass.v.norm(), 3.0 * 1.0001) << "it takes no speed from what stands";
      }
    EXPECT_GT(touched, 60);
  });
}

TEST(Collide, ARoundedCornerIsRound) {
  for_each_way([](const Way& way) {
    Solid box;
    box.shape = Solid::box;
    box.axes = AngleAxisd(0.7, Vector3d(1, 2, -1).normalized()).toRotationMatrix();
    box.center = {0.05, -0.1, 0.02};
    box.half_size = {0.125, 0.25, 0.1875};
    box.radius = 0.0625;
    const Vector3d out = box.axes * Vector3d::Ones().normalized();
    const Vector3d corner = box.center + box.axes * (box.half_size - Vector3d::Constant(box.radius));
    PointMass mass(way, box, corner + 0.25 * out, -out, 1.0 / 120.0, {0, 0, 0});
    for (int k = 0; k < 60; ++k) mass.step();
    EXPECT_LT((mass.q - (corner + box.radius * out)).norm(), 4 * near_surface);
  });
}

// A plate 5 mm thick, 8 m wide, turned by any rotation.
Solid plate(const Matrix3d& axes) {
  Solid box;
  box.shape = Solid::box;
  box.axes = axes;
  box.half_size = {4.0, 0.0025, 4.0};
  return box;
}

// At 60 frames a second, a substep a frame, 5 m/s are 83 mm a substep. Whatever side it comes from, however
// flat its way, and wherever in a substep it meets the plate; the vertex may fly, or the plate.
TEST(Collide, AThinPlateIsNotPassed) {
  static constexpr double h = 1.0 / 60.0, speed = 5.0;
  for_each_way([](const Way& way) {
    std::mt19937 random(5);
    for (const double degrees : {1.0, 3.0, 10.0, 20.0, 30.0, 45.0, 60.0, 90.0})
      for (const double side : {1.0, -1.0})
        for (const bool plate_flies : {false, true})
          for (int trial = 0; trial < 6; ++trial) {
            const Matrix3d axes = trial == 0 ? Matrix3d::Identity() : random_rotation(random);
            const double a = degrees * pi / 180.0;
            const Vector3d up = side * axes.col(1);
            const Vector3d flight = speed * (std::cos(a) * axes.col(0) - std::sin(a) * up);
            // So that it meets the plate in its third substep, at another part of it in each trial.
            const double height = 0.0025 + (2.0 + (trial + 0.5) / 6.0) * speed * h * std::sin(a);
            const Vector3d start = height * up - axes.col(0);
            PointMass mass(
                way,
                [&](double t) {
                  Solid now = plate(axes);
                  if (plate_flies) now.center = -t * flight;
                  return PointMass::Solids{now};
                },
                start, plate_flies ? Vector3d(Vector3d::Zero()) : flight, h, {0, 0, 0}, 0.25 * trial);
            double least = 1.0;
            for (int k = 0; k < 8; ++k) {
              mass.step();
              least = std::min(least, up.dot(mass.q - mass.at(mass.time)[0].center) - 0.0025);
            }
            EXPECT_GT(least, -4 * near_surface) << degrees << " degrees, side " << side
                                                << (plate_flies ? ", the plate flies, " : ", ") << trial;
          }
  });
}

// Without weight and speed, depth x exp(-5 t): it is lifted and gets no speed by it.
TEST(Collide, WhatBeginsInsideIsLiftedAndNotThrown) {
  static constexpr double h = 1.0 / 240.0, depth = 0.1;
  for_each_way([](const Way& way) {
    for (const double gravity : {0.0, g}) {
      PointMass mass(way, floor_at(), {0.1, -depth, 0.2}, {0, 0, 0}, h, {0, -gravity, 0});
      for (int k = 0; k < 480; ++k) {
        mass.step();
        EXPECT_NEAR(mass.q.y(), -depth * std::exp(-lifting_rate * mass.time), 0.01 * depth) << mass.time;
        EXPECT_LE(mass.v.norm(), lifting_rate * depth * 1.01);
        if (testing::Test::HasFailure()) break;
      }
      EXPECT_GT(mass.q.y(), -depth * 1e-3);
      EXPECT_LT(mass.q.y(), near_surface) << "it would fly on";
    }
  });
}

// A tray that rises, goes sideways and turns about an axis aside from what lies on it.
TEST(Collide, WhatSticksGoesWithASolidThatMoves) {
  static constexpr double h = 1.0 / 240.0;
  for_each_way([](const Way& way) {
    for (const double spin : {0.0, 2.0}) {  // 1/s
      const auto tray_at = [&](double t) {
        Solid tray = plate(AngleAxisd(spin * t, Vector3d::UnitY()).toRotationMatrix());
        tray.center = Vector3d(0.5 * t, 0.25 * t, -0.25 * t);
        return PointMass::Solids{tray};
      };
      const auto on_tray = [&](double t, const Vector3d& q) {
        const Solid tray = tray_at(t)[0];
        return Vector3d(tray.axes.transpose() * (q - tray.center));
      };
      PointMass mass(way, tray_at, {0.125, 0.0025, 0.0}, {0, 0, 0}, h, {0, -g, 0}, 1.0);
      for (int k = 0; k < 60; ++k) mass.step();  // until it has caught up
      const Vector3d caught = on_tray(mass.time, mass.q);
      for (int k = 0; k < 240; ++k) mass.step();
      // 240 roundings of a coordinate of about 1/2, all to the same side.
      EXPECT_LT((on_tray(mass.time, mass.q) - caught).norm(), 240 * 0x1p-25 + near_surface) << spin;
      const Solid tray = tray_at(mass.time)[0];
      const Vector3d speed =
          Vector3d(0.5, 0.25, -0.25) + spin * Vector3d::UnitY().cross(Vector3d(mass.q - tray.center));
      // The chord of a substep for its arc: spin^2 r h / 2.
      EXPECT_LT((mass.v - speed).norm(), spin * spin * 0.15 * h + 1e-3) << spin;
    }
  });
}

// A bat of 1 m that turns at 3 1/s: it takes along what it meets and never comes through it.
TEST(Collide, ASolidThatTurnsPushesWhatIsInItsWay) {
  static constexpr double h = 1.0 / 60.0, spin = 3.0;
  for_each_way([](const Way& way) {
    const auto bat_at = [](double t) {
      Solid bat;
      bat.shape = Solid::capsule;
      bat.axes = AngleAxisd(spin * t - 0.5 * pi, Vector3d::UnitZ()).toRotationMatrix();
      bat.center = bat.axes * Vector3d(0, 0.5, 0);
      bat.half_size = {0, 0.5, 0};
      bat.radius = 0.0625;
      return PointMass::Solids{bat};
    };
    PointMass mass(way, bat_at, {0.5, 0.25, 0.01}, {0, 0, 0}, h, {0, 0, 0}, 0.5);
    EXPECT_GT(mass.least_distance(30), -4 * near_surface);
    EXPECT_GT(mass.v.norm(), 0.9 * spin * 0.5) << "it was hit";
  });
}

TEST(Collide, ASolidThatSparesAVertexLetsItPass) {
  for_each_way([](const Way& way) {
    const auto floors = [](double) {
      Solid low = floor_at();
      low.center.y() = -0.25;
      return PointMass::Solids{floor_at(), low};
    };
    for (const std::uint32_t spared : {1u, 2u}) {
      PointMass mass(way, floors, {0.1, 0.1, 0.2}, {0, 0, 0}, 1.0 / 240.0);
      mass.model.spared[0] = spared;
      mass.solver = make_solver(mass.model, way.by_oracle);
      mass.load({0.1, 0.1, 0.2}, {0, 0, 0});
      for (int k = 0; k < 240; ++k) mass.step();
      EXPECT_NEAR(mass.q.y(), spared == 1u ? -0.25 : 0.0, near_surface);
    }
  });
}

// Into the edge where two slopes meet. Solids come one after the other, and the second may move it into the
// first: by the way of a substep, of 3 m/s, and the next one lifts it again.
TEST(Collide, ACornerOfTwoPlanesHoldsWhatFallsIntoIt) {
  for_each_way([](const Way& way) {
    const auto valley = [](double) { return PointMass::Solids{slope(30.0), slope(-50.0)}; };
    PointMass mass(way, valley, {0.1, 0.5, 0.0}, {0, 0, 0}, 1.0 / 240.0);
    double deepest = 0.0;
    for (int k = 0; k < 960; ++k) {
      mass.step();
      for (const Solid& side : valley(0)) deepest = std::min(deepest, distance_to(side, mass.q));
    }
    EXPECT_GT(deepest, -3.0 / 240.0);
    EXPECT_LT(mass.q.norm(), 1e-3) << mass.q.transpose();
    EXPECT_LT(mass.v.norm(), 0.05);
    // The control: one slope alone is slid down.
    PointMass alone(way, slope(30.0), {0.1, 0.5, 0.0}, {0, 0, 0}, 1.0 / 240.0);
    for (int k = 0; k < 480; ++k) alone.step();
    EXPECT_GT(alone.q.norm(), 1.0);
  });
}

TEST(Collide, WhatIsHeldIsNotPushedAndWhatIsNoNumberTouchesNothing) {
  for_each_way([](const Way& way) {
    PointMass mass(way, floor_at(1.0), {0.1, 0.5, 0.2}, {0, 0, 0}, 1.0 / 240.0);
    const State before = mass.solver->save();
    mass.step();
    const State after = mass.solver->save();
    for (std::size_t k = 3; k < before.positions.size(); ++k)
      EXPECT_EQ(after.positions[k], before.positions[k]) << "kinematic vertices lie in the floor";
    EXPECT_NE(after.positions[1], before.positions[1]);
    const double nan = std::numeric_limits<double>::quiet_NaN();
    mass.load({0.1, nan, 0.2}, {0, 0, 0});
    mass.step();
    EXPECT_TRUE(std::isnan(mass.q.y()));
    mass.load({0.1, 0.5, 0.2}, {0, nan, 0});
    mass.step();
    EXPECT_TRUE(std::isnan(mass.q.y()));
  });
}

struct Dropped {
  double highest = 0.0;  // of the centre of mass after it has landed
  double start = 0.0, end = 0.0, lowest = 1.0;
};

// A block of flesh, 0.25 m wide and 0.125 m high, that falls 0.25 m onto the floor.
Dropped dropped(const Way& way, double damping, bool acts) {
  Model model = make_model(kuhn_bar(4, 2, 2, 0.0625), {.alpha = 0.25f, .damping = damping});
  if (way.implicit) model = make_implicit(std::move(model), 5e3);
  model.collider_count = 1;
  model.spared.assign(model.vertex_count, 0);
  const auto solver = make_solver(model, way.by_oracle);
  constexpr double h = 1.0 / 240.0;
  TestDrive drive = quiet_drive(model, h, 1, {0, -g, 0});
  Solid floor = floor_at();
  floor.center.y() = -0.25;
  if (acts) drive.colliders[0] = collider(floor, floor, 0.5, h);
  const double mass = std::accumulate(model.mass.begin(), model.mass.end(), 0.0);
  const auto height = [&](const std::vector<float>& positions) {
    double sum = 0.0;
    for (std::uint32_t i = 0; i < model.vertex_count; ++i)
      sum += model.mass[i] * (0.25 + double{positions[3 * i + 1]});
    return sum / mass;
  };
  Dropped d;
  d.start = height(solver->save().positions);
  double before = d.start;
  bool is_down = false;
  for (int k = 0; k < 720; ++k) {
    solver->submit(drive.get(), {.positions = true});
    const model::Frame frame = solver->collect();
    d.end = height(frame.positions);
    is_down = is_down || d.end > before;
    before = d.end;
    if (is_down) d.highest = std::max(d.highest, d.end);
    for (std::uint32_t i = 0; i < model.vertex_count; ++i)
      d.lowest = std::min(d.lowest, 0.25 + double{frame.positions[3 * i + 1]});
  }
  return d;
}

// Flesh gives back what it has taken up, the floor gives nothing: it never comes up to where it fell from.
TEST(Collide, AnElasticBlockComesUpLowerThanItFell) {
  for_each_way([](const Way& way) {
    for (const double damping : {0.0, 8.0}) {
      const Dropped d = dropped(way, damping, true);
      EXPECT_GT(d.lowest, -near_surface);
      EXPECT_GT(d.highest, 0.0) << "it has landed";
      EXPECT_LT(d.highest, d.start - 0.02) << damping;
      EXPECT_GT(d.end, 0.03) << "it is not flat";
      if (damping > 0.0) {
        EXPECT_LT(d.end, 0.08) << "it lies";
      }
    }
    EXPECT_LT(dropped(way, 8.0, false).lowest, -1.0) << "the control: no floor";
  });
}

// Shown of one stage over a run.
struct StageProbe : model::Probe {
  void on_stage(const model::Where& where, std::span<const float> values) override {
    if (where.stage == stage) seen.emplace_back(values.begin(), values.end());
  }
  model::Stage stage = model::Stage::collide;
  std::vector<std::vector<float>> seen;
};

// A block that is dropped among solids which move and turn.
struct Scuffle {
  explicit Scuffle(bool implicit)
      : model(make_model(jittered(kuhn_bar(5, 3, 3, 0.0625), 1.0 / 1024, 8, 2),
                         {.alpha = 0.3f, .damping = 2.0})) {
    if (implicit) model = make_implicit(std::move(model), 2e4);
    model.collider_count = 4;
    for (std::uint32_t i = 0; i < model.vertex_count; ++i)
      model.spared.push_back(i % 9 == 4 ? 1u << i % 4 : 0u);
    drive = quiet_drive(model, h, 1, {0.5, -g, 0});
  }
  std::vector<Solid> at(double t) const {
    Solid ball, rod, crate, hill = slope(10.0);
    ball.shape = Solid::sphere;
    ball.center = {0.05 + 0.5 * t, -0.05 + 0.3 * t, 0.1};
    ball.radius = 0.0625;
    rod.shape = Solid::capsule;
    rod.center = {0.3, 0.23 - 0.4 * t, 0.09};
    rod.axes = AngleAxisd(2.0 * t, Vector3d::UnitY()).toRotationMatrix() *
               AngleAxisd(1.2, Vector3d::UnitX()).toRotationMatrix();
    rod.half_size = {0, 0.1, 0};
    rod.radius = 0.03;
    crate.shape = Solid::box;
    crate.center = {0.36 - 0.2 * t, 0.0, 0.05};
    crate.axes = AngleAxisd(0.3 - t, Vector3d(1, 2, 2).normalized()).toRotationMatrix();
    crate.half_size = {0.05, 0.06, 0.07};
    crate.radius = 0.01;
    hill.center.y() = -0.08;
    return {ball, rod, crate, hill};
  }
  model::Drive frame(int k) {
    const std::vector<Solid> before = at((k - 1) * h), now = at(k * h);
    for (std::size_t s = 0; s < now.size(); ++s)
      drive.colliders[s] = collider(before[s], now[s], 0.2 * double(s), h);
    return drive.get();
  }

  static constexpr double h = 1.0 / 120.0;
  Model model;
  TestDrive drive;
};

// A substep from the same state each time. A way is followed to anywhere within 2^-18 of a surface, whose
// plane there turns by sqrt(2 x 2^-18 / radius), 0.03 of the roundest here, over what is met at different
// places; times the millimetre that a grazing way leads in, 3e-5. Velocities are that over h.
TEST(Collide, EverySubstepIsTheOracles) {
  for (const bool implicit : {false, true}) {
    SCOPED_TRACE(implicit ? "implicit" : "explicit");
    Scuffle scuffle(implicit);
    check_model(scuffle.model);
    const auto ours = make_solver(scuffle.model, false), theirs = make_solver(scuffle.model, true);
    Model untouched = scuffle.model;
    untouched.spared.assign(untouched.vertex_count, ~0u);
    const auto without = make_solver(untouched, true);
    std::size_t compared = 0, acted = 0;
    double furthest = 0.0, furthest_in_speed = 0.0;
    for (int k = 1; k <= 40; ++k) {
      const State state = ours->save();
      const model::Drive drive = scuffle.frame(k);
      const auto shown = [&](model::Solver& solver) {
        StageProbe probe;
        solver.load(state);
        solver.submit(drive, {}, &probe);
        solver.collect();
        return std::pair{probe.seen.at(0), solver.save()};
      };
      const auto [control, free] = shown(*without);
      const auto [reference, after_reference] = shown(*theirs);
      const auto [stage, after] = shown(*ours);
      for (std::uint32_t i = 0; i < scuffle.model.vertex_count; ++i) {
        ++compared;
        furthest = std::max(furthest, (triple(stage, i) - triple(reference, i)).norm());
        furthest_in_speed = std::max(
            furthest_in_speed, (triple(after.velocities, i) - triple(after_reference.velocities, i)).norm());
        acted += (triple(control, i) - triple(reference, i)).norm() > 1e-4;
      }
    }
    EXPECT_LT(furthest, 4e-5);
    EXPECT_LT(furthest_in_speed, 4e-5 / Scuffle::h);
    EXPECT_GT(acted, compared / 10) << "a hundred times as far";
  }
}

// The bars that other rooms' tests bend are moved by their solids.
TEST(Collide, TheBarsThatOtherTestsBendAreTouched) {
  for (const BarOptions& bar :
       {BarOptions{.colliders = true}, BarOptions{.implicit = true, .colliders = true},
        BarOptions{.skeleton = true, .limits = false, .colliders = true}}) {
    const Model m = make_bar(bar);
    Model spared = m;
    spared.spared.assign(m.vertex_count, ~0u);
    const auto bent = [](const Model& model) {
      const auto solver = make_cpu_solver(model, options_of(model), 1);
      BarMotion motion(model, 3);
      for (std::uint64_t k = 1; k <= 10; ++k) solver->submit(motion.drive(k), {});
      return solver->save().positions;
    };
    const std::vector<float> a = bent(m), b = bent(spared);
    std::size_t moved = 0;
    for (std::size_t k = 0; k < a.size(); ++k) {
      moved += std::abs(a[k] - b[k]) > 1e-3f;
      EXPECT_LT(std::abs(a[k]), 2.0f) << "it stays in one piece";
    }
    EXPECT_GT(moved, a.size() / 4);
  }
}

State after_frames(const Model& model, model::Solver& solver, std::uint64_t first, std::uint64_t last,
                   bool cuts) {
  BarMotion motion(model, 3, cuts);
  for (std::uint64_t k = 1; k <= last; ++k) {
    const model::Drive drive = motion.drive(k);
    if (k < first) continue;
    solver.submit(drive, {});
    solver.collect();
  }
  return solver.save();
}

TEST(Collide, LanesThreadsProbesAndSavingHaveTheScalarBits) {
  for (const BarOptions& bar :
       {BarOptions{.colliders = true}, BarOptions{.skeleton = true, .cuts = true, .colliders = true},
        BarOptions{.implicit = true, .colliders = true},
        BarOptions{.skeleton = true,
        .cuts = true,
        .implicit = true,
        .limits = true,
        .contact = true,
        .colliders = true}}) {
    const Model m = make_bar(bar);
    check_model(m);
    const State scalar = after_frames(m, *make_cpu_solver(m, options_of(m), 1, Simd::scalar), 1, 8, bar.cuts);
    for (const Simd simd : cpu_reference::available_simd())
      for (const unsigned threads : {1u, 3u}) {
        const auto solver = make_cpu_solver(m, options_of(m), threads, simd);
        const State half = after_frames(m, *solver, 1, 4, bar.cuts);
        const auto resumed = make_cpu_solver(m, options_of(m), threads, simd);
        resumed->load(half);
        EXPECT_EQ(after_frames(m, *resumed, 5, 8, bar.cuts), scalar) << name_of(simd) << ' ' << threads;
      }
    const auto probed = make_cpu_solver(m, options_of(m), 2);
    BarMotion motion(m, 3, bar.cuts);
    StageProbe probe;
    for (std::uint64_t k = 1; k <= 8; ++k) probed->submit(motion.drive(k), {}, &probe);
    EXPECT_EQ(probed->save(), scalar);
    EXPECT_EQ(probe.seen.size(), 24u);
  }
}

// Solids that touch nothing change no bit.
TEST(Collide, WhereNothingTouchesNoBitChanges) {
  for (const bool implicit : {false, true}) {
    const Model without = make_bar({.skeleton = true, .implicit = implicit});
    Model m = make_bar({.skeleton = true, .implicit = implicit, .colliders = true});
    EXPECT_NE(after_frames(m, *make_cpu_solver(m, options_of(m), 1), 1, 4, false),
              after_frames(without, *make_cpu_solver(without, options_of(without), 1), 1, 4, false))
        << "the control";
    m.spared.assign(m.vertex_count, ~0u);
    EXPECT_EQ(after_frames(m, *make_cpu_solver(m, options_of(m), 1), 1, 4, false),
              after_frames(without, *make_cpu_solver(without, options_of(without), 1), 1, 4, false));
  }
}

}  // namespace

}  // namespace fascicle::tests
