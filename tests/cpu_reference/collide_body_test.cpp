// Bodies of flesh in contact with solids: energy, rest and reaction forces.
#include <numeric>

#include "tests/cpu_reference/collide_models.h"

namespace fascicle::tests::collide_body_test {

namespace {

struct Dropped {
  double highest = 0.0;  // of the centre of mass after landing
  double start = 0.0, end = 0.0, lowest = 1.0;
};

// A block of flesh, 0.25 m wide and 0.125 m high, falls 0.25 m onto the floor.
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

// Flesh returns the energy it absorbed and the floor returns none, so the block never reaches its starting
// height.
TEST(Collide, AnElasticBlockComesUpLowerThanItFell) {
  for_each_way([](const Way& way) {
    for (const double damping : {0.0, 8.0}) {
      const Dropped d = dropped(way, damping, true);
      EXPECT_GT(d.lowest, -near_surface);
      EXPECT_GT(d.highest, 0.0) << "it landed";
      EXPECT_LT(d.highest, d.start - 0.02) << damping;
      EXPECT_GT(d.end, 0.03) << "the block is not flattened";
      if (damping > 0.0) {
        EXPECT_LT(d.end, 0.08) << "the block lies on the floor";
      }
    }
    EXPECT_LT(dropped(way, 8.0, false).lowest, -1.0) << "the control: no floor";
  });
}

// A body with a floor below and a lid above, which arrive from a thousand working units away.
struct Pressed {
  explicit Pressed(Model made) : model(std::move(made)) {
    model.collider_count = 2;
    model.spared.assign(model.vertex_count, 0);
    check_model(model);
    solver = make_solver(model, false);
    drive = quiet_drive(model, h);
  }
  double mass() const { return std::accumulate(model.mass.begin(), model.mass.end(), 0.0); }
  void step(double floor_height, double lid_height_before, double lid_height, double friction) {
    Solid floor = floor_at(), lid_before = slope(180.0);
    floor.center.y() = floor_height;
    lid_before.center.y() = lid_height_before;
    Solid lid = lid_before;
    lid.center.y() = lid_height;
    drive.colliders = {collider(floor, floor, friction, h), collider(lid_before, lid, friction, h)};
    probe = {};
    probe.stage = model::Stage::goal;
    solver->submit(drive.get(), {.positions = true, .velocities = true}, &probe);
    frame = solver->collect();
  }
  // The force of flesh on the vertices below or above this height (N): mass x stiffness x (x - goal), along
  // y.
  double pull(bool above, double height) const {
    double sum = 0.0;
    for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
      const double y = triple(frame.positions, i).y();
      if ((y > height) == above)
        sum += model.mass[i] * double(model.stiffness[i]) * (y - triple(probe.seen.back(), i).y());
    }
    return sum;
  }
  double height() const {
    double sum = 0.0;
    for (std::uint32_t i = 0; i < model.vertex_count; ++i)
      sum += model.mass[i] * triple(frame.positions, i).y();
    return sum / mass();
  }

  static constexpr double h = 1.0 / 240.0;
  Model model;
  std::unique_ptr<model::Solver> solver;
  TestDrive drive;
  StageProbe probe;
  model::Frame frame;
};

constexpr double far_away = 1000.0;

// A bar of 0.1 x 0.2 x 0.1 m between frictionless plates, one of which comes down by a twentieth of the bar's
// height. At rest, flesh exerts no force on a free vertex, so its force on the others is the load on the
// plates: E x area x 0.05.
TEST(CollideBody, PlatesBearWhatRodTheorySays) {
  constexpr double E = 50e3, force = E * 0.1 * 0.1 * 0.05;
  Pressed bar(make_implicit(make_model(kuhn_bar(5, 10, 5, 0.02), {.damping = 10.0}), E));
  const auto lid = [](double t) { return 0.2 - 0.01 * std::min(1.0, t); };
  for (int k = 0; k < 480; ++k) bar.step(0.0, lid(k * Pressed::h), lid((k + 1) * Pressed::h), 0.0);
  const double below = bar.pull(false, 0.01), above = -bar.pull(true, 0.18);
  // Stiffness is fitted to E inside a body. Regions at ends and sides are truncated, which costs 3.8 % here.
  EXPECT_NEAR(above, force, 0.05 * force);
  // With these weights, flesh exerts no net force on the whole body. The iterations stop a thousandth short
  // of that.
  EXPECT_NEAR(below, above, 1e-3 * force);
  EXPECT_NEAR(bar.pull(true, 0.01), -above, 1e-3 * force) << "on the vertices between the plates";
}

// The floor bears the weight, and the centre of the body sags by density g H^2 / 3 E.
TEST(CollideBody, AFloorBearsTheWeight) {
  constexpr double E = 40e3, H = 0.2;
  Pressed bar(make_implicit(make_model(kuhn_bar(5, 10, 5, 0.02), {.damping = 20.0}), E));
  bar.drive.drive.gravity = {0.0f, float(-g), 0.0f};
  for (int k = 0; k < 960; ++k) bar.step(0.0, far_away, far_away, 0.0);
  const double weight = g * bar.mass(), sag = 1000.0 * g * H * H / (3.0 * E);
  // In addition to flesh's force, the floor bears the lowest vertices themselves.
  double on_floor = 0.0;
  for (std::uint32_t i = 0; i < bar.model.vertex_count; ++i)
    if (triple(bar.frame.positions, i).y() < 0.01) on_floor += g * bar.model.mass[i];
  EXPECT_NEAR(bar.pull(false, 0.01) + on_floor, weight, 1e-3 * weight);
  // A chain of lumped masses and springs, not a rod: 6.6 %.
  EXPECT_NEAR(0.5 * H - bar.height(), sag, 0.1 * sag);
}

// The elastic energy of flesh is never negative and a static floor adds none, so kinetic and potential energy
// never exceed their initial sum.
TEST(CollideBody, WhatFallsNeverHasMoreEnergyThanItFellWith) {
  for (const bool implicit : {false, true})
    for (const double damping : {0.0, 3.0})
      for (const double friction : {0.0, 0.6}) {
        Model model = make_model(jittered(kuhn_bar(4, 3, 3, 0.0625), 1.0 / 1024, 8, 2),
                                 {.alpha = 0.25f, .damping = damping});
        if (implicit) model = make_implicit(std::move(model), 25e3);
        Pressed body(std::move(model));
        body.drive.drive.gravity = {0.0f, float(-g), 0.0f};
        constexpr double fall = 0.25;
        const auto energy = [&] {
          double sum = 0.0;
          for (std::uint32_t i = 0; i < body.model.vertex_count; ++i)
            sum += body.model.mass[i] * (g * triple(body.frame.positions, i).y() +
                                         0.5 * triple(body.frame.velocities, i).squaredNorm());
          return sum;
        };
        double highest = 0.0, first = 0.0;
        for (int k = 0; k < 720; ++k) {
          body.step(-fall, far_away, far_away, friction);
          if (k == 0) first = energy();
          highest = std::max(highest, energy() - first);
        }
        SCOPED_TRACE((implicit ? "implicit, damping " : "explicit, damping ") + std::to_string(damping) +
                     ", friction " + std::to_string(friction));
        // Each substep rounds a velocity of 2 m/s to 2^-23 of it, and a position likewise; the bound assumes
        // that all errors have the same sign.
        EXPECT_LT(highest, 720 * 0x1p-22 * body.mass() * g * fall);
        // Most of the energy is lost on landing, and with damping the rest of the motion is lost too.
        const double lost = (first - energy()) / (body.mass() * g * fall);
        EXPECT_GT(lost, 0.8);
        EXPECT_LT(lost, 1.1) << "it lies on the floor, lower by its sag";
      }
}

}  // namespace

}  // namespace fascicle::tests::collide_body_test
