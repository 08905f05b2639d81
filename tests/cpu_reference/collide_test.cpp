// Flesh does not enter solids. Closed forms for one vertex and planes, spheres, capsules and boxes that stand
// still, move and rotate, in the Oracle and in CpuSolver, explicit and implicit.
#include "tests/cpu_reference/collide_models.h"

namespace fascicle::tests::collide_test {

namespace {

// Restitution is 0: after landing it stays.
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
        // The rounding of a position, over h.
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
          // 240 roundings of a coordinate of about 0.01, all with the same sign.
          EXPECT_LT(mass.q.norm(), 240 * 0x1p-30 + near_surface);
        }
      }
  });
}

// A vertex shot at a solid's centre from a random side ends on the surface, as friction stops all sliding. It
// stops within (path)^2 / 2 radius of a round surface, measured along the normal.
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

// Shot from anywhere without friction, it slides around the solid.
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
        EXPECT_LT(mass.v.norm(), 3.0 * 1.0001) << "it gains no speed from a static solid";
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

// At 60 frames a second with one substep a frame, 5 m/s are 83 mm a substep. Covers both sides, grazing
// angles and impacts at any time within a substep; either the vertex or the plate moves.
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
            // The impact is in the third substep, at another fraction of it in each trial.
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

// Without gravity and speed, the depth decays as depth x exp(-5 t): the vertex is lifted and gains no speed.
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
      EXPECT_LT(mass.q.y(), near_surface) << "it was thrown";
    }
  });
}

// A tray that rises, moves sideways and turns about an axis away from the vertex on it.
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
      for (int k = 0; k < 60; ++k) mass.step();  // until it has the tray's speed
      const Vector3d caught = on_tray(mass.time, mass.q);
      for (int k = 0; k < 240; ++k) mass.step();
      // 240 roundings of a coordinate of about 1/2, all with the same sign.
      EXPECT_LT((on_tray(mass.time, mass.q) - caught).norm(), 240 * 0x1p-25 + near_surface) << spin;
      const Solid tray = tray_at(mass.time)[0];
      const Vector3d speed =
          Vector3d(0.5, 0.25, -0.25) + spin * Vector3d::UnitY().cross(Vector3d(mass.q - tray.center));
      // The chord of a substep instead of the arc: spin^2 r h / 2.
      EXPECT_LT((mass.v - speed).norm(), spin * spin * 0.15 * h + 1e-3) << spin;
    }
  });
}

// A bat 1 m long that turns at 3 1/s pushes what it hits and is never penetrated.
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

// Into the valley where two slopes meet.
TEST(Collide, ACornerOfTwoPlanesHoldsWhatFallsIntoIt) {
  for_each_way([](const Way& way) {
    const auto valley = [](double) { return PointMass::Solids{slope(30.0), slope(-50.0)}; };
    PointMass mass(way, valley, {0.1, 0.5, 0.0}, {0, 0, 0}, 1.0 / 240.0);
    double deepest = 0.0;
    for (int k = 0; k < 960; ++k) {
      mass.step();
      for (const Solid& side : valley(0)) deepest = std::min(deepest, distance_to(side, mass.q));
    }
    EXPECT_GT(deepest, -4 * near_surface);
    EXPECT_LT(mass.q.norm(), 1e-3) << mass.q.transpose();
    EXPECT_LT(mass.v.norm(), 0.05);
    // The control: on one slope alone it slides down.
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
      EXPECT_EQ(after.positions[k], before.positions[k]) << "kinematic vertices may be inside the floor";
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

}  // namespace

}  // namespace fascicle::tests::collide_test
