// Stage collide of CpuSolver compared with the Oracle's, and its lanes, threads and resumed runs compared
// with each other.
#include "tests/cpu_reference/collide_models.h"
#include "tests/support/bar_model.h"

namespace fascicle::tests::collide_oracle_test {

namespace {

// A block that falls among moving and rotating solids.
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

// Both solvers start each substep from the same state. A path may end anywhere within 2^-18 of a surface.
// Over that range the tangent plane turns by sqrt(2 x 2^-18 / radius), 0.03 for the roundest solid here;
// times the millimetre by which a grazing path enters, that is 3e-5. Velocities differ by that over h, and by
// twice as much in a corner of two solids: a vertex guided along both moves further by 1 over the sine of the
// angle.
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
    EXPECT_LT(furthest_in_speed, 8e-5 / Scuffle::h);
    EXPECT_GT(acted, compared / 10) << "solids move vertices a hundred times as far";
  }
}

// The solids touch the bars that other rooms' tests use.
TEST(Collide, TheBarsThatOtherTestsBendAreTouched) {
  for (const BarOptions& bar :
       {BarOptions{.colliders = true}, BarOptions{.implicit = true, .colliders = true},
        BarOptions{.skeleton = true, .limits = false, .colliders = true}}) {
    const Model m = make_bar(bar);
    Model spared = m;
    spared.spared.assign(m.vertex_count, ~0u);
    const auto bent = [](const Model& model) {
      const auto solver = cpu_reference::make_cpu_solver(model, options_of(model), 1);
      BarMotion motion(model, 3);
      for (std::uint64_t k = 1; k <= 10; ++k) solver->submit(motion.drive(k), {});
      return solver->save().positions;
    };
    const std::vector<float> a = bent(m), b = bent(spared);
    std::size_t moved = 0;
    for (std::size_t k = 0; k < a.size(); ++k) {
      moved += std::abs(a[k] - b[k]) > 1e-3f;
      EXPECT_LT(std::abs(a[k]), 2.0f) << "the bar stays in one piece";
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
    const State scalar = after_frames(
        m, *cpu_reference::make_cpu_solver(m, options_of(m), 1, cpu_reference::Simd::scalar), 1, 8, bar.cuts);
    for (const cpu_reference::Simd simd : cpu_reference::available_simd())
      for (const unsigned threads : {1u, 3u}) {
        const auto solver = cpu_reference::make_cpu_solver(m, options_of(m), threads, simd);
        const State half = after_frames(m, *solver, 1, 4, bar.cuts);
        const auto resumed = cpu_reference::make_cpu_solver(m, options_of(m), threads, simd);
        resumed->load(half);
        EXPECT_EQ(after_frames(m, *resumed, 5, 8, bar.cuts), scalar) << name_of(simd) << ' ' << threads;
      }
    const auto probed = cpu_reference::make_cpu_solver(m, options_of(m), 2);
    BarMotion motion(m, 3, bar.cuts);
    StageProbe probe;
    for (std::uint64_t k = 1; k <= 8; ++k) probed->submit(motion.drive(k), {}, &probe);
    EXPECT_EQ(probed->save(), scalar);
    EXPECT_EQ(probe.seen.size(), 24u);
  }
}

// Solids that touch nothing do not change a bit.
TEST(Collide, WhereNothingTouchesNoBitChanges) {
  for (const bool implicit : {false, true}) {
    const Model without = make_bar({.skeleton = true, .implicit = implicit});
    Model m = make_bar({.skeleton = true, .implicit = implicit, .colliders = true});
    EXPECT_NE(
        after_frames(m, *cpu_reference::make_cpu_solver(m, options_of(m), 1), 1, 4, false),
        after_frames(without, *cpu_reference::make_cpu_solver(without, options_of(without), 1), 1, 4, false))
        << "the control: solids that do touch";
    m.spared.assign(m.vertex_count, ~0u);
    EXPECT_EQ(
        after_frames(m, *cpu_reference::make_cpu_solver(m, options_of(m), 1), 1, 4, false),
        after_frames(without, *cpu_reference::make_cpu_solver(without, options_of(without), 1), 1, 4, false));
  }
}

}  // namespace

}  // namespace fascicle::tests::collide_oracle_test
