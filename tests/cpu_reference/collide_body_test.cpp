// Bodies of flesh among solids: what holds of energy, rest and reaction.
#include <numeric>

#include "tests/cpu_reference/collide_models.h"

namespace fascicle::tests {

namespace {

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

}  // namespace

}  // namespace fascicle::tests
