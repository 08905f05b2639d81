// Vertices in corners of several solids end outside all of them.
#include "tests/cpu_reference/collide_models.h"

namespace fascicle::tests::collide_corner_test {

namespace {

using Solids = PointMass::Solids;

// A plane through the origin; the solid is on the side opposite to `normal`.
Solid plane_along(const Vector3d& normal) {
  Solid plane;
  plane.axes = Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitY(), normal).toRotationMatrix();
  return plane;
}

// Two planes that meet along z and leave free the space between them, at this angle; the corner opens along
// x.
Solids wedge(double degrees) {
  const double a = degrees * pi / 360.0;
  return {plane_along({std::sin(a), std::cos(a), 0}), plane_along({std::sin(a), -std::cos(a), 0})};
}

// Three planes that meet at the origin, each at this angle to the x axis, along which the corner opens.
Solids pit(double degrees) {
  Solids planes;
  for (const double turn : {0.0, 2.0 * pi / 3.0, 4.0 * pi / 3.0}) {
    const double a = degrees * pi / 180.0;
    planes.push_back(plane_along({std::sin(a), std::cos(a) * std::cos(turn), std::cos(a) * std::sin(turn)}));
  }
  return planes;
}

// A box on a plane, with its side at this angle to it; the corner opens along x.
Solids box_on_plane(double degrees) {
  const Solids planes = wedge(degrees);
  Solid box;
  box.shape = Solid::box;
  box.axes = planes[1].axes;
  box.half_size = {0.5, 0.25, 0.5};
  box.radius = 0.01;
  box.center = box.axes * Vector3d(0, -0.25, 0);
  return {planes[0], box};
}

Solids turned(Solids solids, const Matrix3d& turn) {
  for (Solid& solid : solids) {
    solid.axes = turn * solid.axes;
    solid.center = turn * solid.center;
  }
  return solids;
}

double least_distance(const Solids& solids, const Vector3d& q) {
  double least = std::numeric_limits<double>::infinity();
  for (const Solid& solid : solids) least = std::min(least, distance_to(solid, q));
  return least;
}

struct Held {
  double deepest = 0.0, furthest = 0.0, fastest = 0.0;  // over the whole run; the last two at its end
};

// A mass flies into the corner at 3 m/s and is pressed into it by ten times its weight and sideways by twice
// its weight. Returns the worst of six rotated cases, with the solids in either order.
Held pressed_into(const Way& way, const Solids& corner, const Vector3d& aside, double mu) {
  Held held;
  std::mt19937 random(6);
  for (int trial = 0; trial < 6; ++trial) {
    const Matrix3d turn = random_rotation(random);
    Solids solids = turned(corner, turn);
    if (trial % 2 == 1) std::reverse(solids.begin(), solids.end());
    const Vector3d opens = turn.col(0), side = turn * aside;
    PointMass mass(
        way, [=](double) { return solids; }, 0.25 * opens + 0.02 * side, -3.0 * opens, 1.0 / 240.0,
        g * (2.0 * side - 10.0 * opens), mu);
    for (int k = 0; k < 240; ++k) {
      mass.step();
      held.deepest = std::max(held.deepest, -least_distance(solids, mass.q));
    }
    held.furthest = std::max(held.furthest, mass.q.norm());
    held.fastest = std::max(held.fastest, mass.v.norm());
  }
  return held;
}

struct Corner {
  std::string name;
  Solids solids;
  Vector3d aside;
  double deepest;
};

std::vector<Corner> corners() {
  // A vertex resting on a solid is off by the contact distance and the rounding of maps and positions.
  constexpr double rounding = 4 * near_surface;
  std::vector<Corner> all;
  for (const double degrees : {15.0, 30.0, 60.0, 90.0, 120.0, 150.0})
    all.push_back({"wedge " + std::to_string(degrees), wedge(degrees), {0, 0.1, 0}, rounding});
  for (const double degrees : {30.0, 35.264, 60.0})
    all.push_back({"pit " + std::to_string(degrees), pit(degrees), {0, 0.1, 0.05}, rounding});
  // A push slides along only one other plane. With three planes this steep it approaches the corner step by
  // step: within 0.1 mm after all passes, where a substep's motion is 1.7 mm.
  all.push_back({"pit 15", pit(15.0), {0, 0.1, 0.05}, 2e-4});
  for (const double degrees : {30.0, 60.0, 90.0, 120.0})
    all.push_back({"box " + std::to_string(degrees), box_on_plane(degrees), {0, -0.1, 0}, rounding});
  return all;
}

TEST(CollideCorner, HoldsWhatIsPressedIntoIt) {
  for_each_way([](const Way& way) {
    for (const Corner& corner : corners())
      for (const double mu : {0.0, 0.5}) {
        SCOPED_TRACE(corner.name + ", friction " + std::to_string(mu));
        const Held held = pressed_into(way, corner.solids, corner.aside, mu);
        EXPECT_LT(held.deepest, corner.deepest);
        // Without friction the mass still swings through a flat corner; it stops where both sides press.
        EXPECT_LT(held.furthest, 0.01);
        EXPECT_LT(held.fastest, 0.2);
      }
  });
}

// The control: without a second pass, each solid would push the mass into the other.
TEST(CollideCorner, OneOfItsSidesAloneDoesNotHold) {
  for_each_way([](const Way& way) {
    for (Corner corner : corners()) {
      const Solids all = corner.solids;
      corner.solids.pop_back();
      if (corner.solids.size() > 1) continue;
      const Held held = pressed_into(way, corner.solids, corner.aside, 0.0);
      EXPECT_GT(held.furthest, 0.1) << corner.name;
    }
  });
}

// Planes that close until they leave no room: nothing is thrown, and no NaN appears.
TEST(CollideCorner, NoRoomThrowsNothing) {
  for_each_way([](const Way& way) {
    const auto press = [](double t) {
      Solid above = plane_along({0, -1, 0});
      above.center.y() = std::max(-0.05, 0.1 - t);
      return Solids{floor_at(), above};
    };
    PointMass mass(way, press, {0.1, 0.05, 0.2}, {0, 0, 0}, 1.0 / 240.0, {0, -g, 0}, 0.5);
    for (int k = 0; k < 480; ++k) {
      mass.step();
      ASSERT_LT((mass.q - Vector3d(0.1, 0.0, 0.2)).norm(), 0.1);
      // The plane moves at 1 m/s. Up to 0.05 m below the floor, the plane's lift is five times that per
      // second, which does not count as speed; and gravity adds a substep's worth.
      ASSERT_LT(mass.v.norm(), 1.0 + lifting_rate * 0.05 + g / 240.0);
    }
    EXPECT_LT(mass.v.norm(), 0.3);
  });
}

}  // namespace

}  // namespace fascicle::tests::collide_corner_test
