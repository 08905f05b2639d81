// Figures 6, 7 and 8 and table 1 of the paper, on the built-in scenes: ten seconds of each, by the CPU
// solver. Each figure is one test, because ctest runs each test in its own process and a test shares the run
// of a scene.
#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <gtest/gtest.h>

#include "cpu_reference/solver/cpu_solver.h"
#include "host/build/build.h"
#include "host/drive/drive_source.h"
#include "host/model/model.h"
#include "host/scene/scene.h"

namespace fascicle::tests {

namespace {

using Eigen::Vector3d;

constexpr std::uint64_t frame_count = 600;

// A bar's motion: its vertex positions in metres, in frames 0 (rest) to 600.
struct Motion {
  scene::Scene scene;
  model::Model model;
  std::vector<std::vector<Vector3d>> frames;

  const scene::Bar& bar() const { return std::get<scene::Bar>(scene.geometry); }
  double length() const { return bar().size.maxCoeff(); }
  const std::vector<std::uint32_t>& probe(const std::string& name) const {
    for (const model::ProbeSet& set : model.probes)
      if (set.name == name) return set.vertices;
    throw std::out_of_range("no probe " + name);
  }
  Vector3d mean(const std::vector<std::uint32_t>& vertices, std::size_t frame) const {
    Vector3d sum = Vector3d::Zero();
    for (const std::uint32_t i : vertices) sum += frames[frame][i];
    return sum / static_cast<double>(vertices.size());
  }
  Vector3d tip(std::size_t frame) const { return mean(probe("tip"), frame); }
};

Vector3d metres(const model::Model& model, const std::array<double, 3>& origin,
                const std::vector<float>& values, std::size_t i) {
  Vector3d p;
  for (std::size_t a = 0; a < 3; ++a)
    p[static_cast<Eigen::Index>(a)] = origin[a] + model.unit * double{values[3 * i + a]};
  return p;
}

Motion run(const std::string& name, const std::vector<std::string>& set = {},
           std::uint64_t frames = frame_count) {
  Motion motion;
  motion.scene = scene::load_scene(name, {.set = set});
  build::Report report;
  motion.model = build::build_model(motion.scene, report);
  const model::Model& model = motion.model;
  drive::DriveSource drives(motion.scene, model);
  const auto solver = cpu_reference::make_cpu_solver(model, {}, 2);
  solver->load(drives.initial_state());
  const auto keep = [&](const std::array<double, 3>& origin, const std::vector<float>& values) {
    std::vector<Vector3d>& frame = motion.frames.emplace_back();
    for (std::size_t i = 0; i < model.vertex_count; ++i) frame.push_back(metres(model, origin, values, i));
  };
  keep(model.rest_origin, model.rest);
  for (std::uint64_t k = 1; k <= frames; ++k) {
    solver->submit(drives.drive(k), {.positions = true});
    const model::Frame frame = solver->collect();
    keep(frame.origin, frame.positions);
  }
  return motion;
}

// How far the tip has dropped once the bar hangs still, in lengths of the bar.
double drop(const Motion& motion) {
  // At rest: the tip has moved less than a thousandth of the length in the last second. Otherwise the figures
  // below would depend on the phase of a swing.
  EXPECT_LT((motion.tip(frame_count) - motion.tip(frame_count - 60)).norm(), 1e-3 * motion.length())
      << motion.scene.name;
  return (motion.tip(0).y() - motion.tip(frame_count).y()) / motion.length();
}

TEST(Paper, Figure6StretchesMostAcrossAndLeastAlongTheFibres) {
  const std::vector<std::string> names{"bar-hang-across", "bar-hang-none", "bar-hang-along"};
  std::map<std::string, double> stretch;
  for (const std::string& name : names) {
    stretch[name] = drop(run(name));
    RecordProperty(name, std::to_string(stretch[name]));
    // Visible in a picture without a ruler, but still recognisable as the same bar.
    EXPECT_GE(stretch[name], 0.1) << name;
    EXPECT_LE(stretch[name], 0.6) << name;
  }
  // "rigid parallel to the fibre": a twentieth of the middle value is far above the effect of float rounding
  // or residual motion (1e-3), and below the visible differences in the figure.
  const double visible = 0.05 * stretch["bar-hang-none"];
  EXPECT_GT(stretch["bar-hang-across"], stretch["bar-hang-none"] + visible);
  EXPECT_GT(stretch["bar-hang-none"], stretch["bar-hang-along"] + visible);

  // The control: with beta 0 the three scenes are the same, and the ordering fails.
  std::vector<double> without;
  for (const std::string& name : names) without.push_back(drop(run(name, {"layers.body.beta=0"})));
  EXPECT_EQ(without[0], without[1]);
  EXPECT_EQ(without[1], without[2]);
}

TEST(Paper, Figure7DropsFurtherTheLargerBeta) {
  double before = 0.0;
  std::string all;
  for (const auto& [name, beta] :
       {std::pair{"bar-beta-0", 0.0}, {"bar-beta-0.6", 0.6}, {"bar-beta-0.75", 0.75}, {"bar-beta-1", 1.0}}) {
    const Motion motion = run(name);
    const scene::Layer& body = motion.scene.layers.at(0);
    EXPECT_EQ(body.beta, beta) << name;
    // "all fiber vectors are orthogonal to the floor"
    EXPECT_EQ(body.fibre.value(), Vector3d(0, 1, 0)) << name;
    const double here = drop(motion);
    all += std::string(name) + " " + std::to_string(here) + "; ";
    EXPECT_GE(here, 0.2) << name;
    EXPECT_LE(here, 0.8) << name;
    // A hundredth of the length is visible in a picture 400 pixels wide, and is ten times the residual motion
    // allowed above.
    EXPECT_GT(here, before + 0.01) << all;
    before = here;
  }
  RecordProperty("drops", all);

  // The control: fibres along the bar hold it up, so the ordering is due to the fibres, not to beta alone.
  const std::string along = "layers.body.fibre=[1, 0, 0]";
  EXPECT_LT(drop(run("bar-beta-1", {along})), drop(run("bar-beta-0.6", {along})));
}

// A section across the bar: its centre, and its rotation in the plane of the fall.
struct Section {
  Vector3d centre = Vector3d::Zero();
  double turned = 0.0;  // radians from rest
};

Section section(const Motion& motion, double x, std::size_t frame) {
  Section result;
  Vector3d upwards = Vector3d::Zero();
  std::size_t count = 0;
  // Half the spacing of the vertices: one layer of them.
  const double half = 0.5 * motion.bar().size.x() / (motion.bar().vertices[0] - 1);
  double middle = motion.bar().size.y() / 2.0;
  for (std::size_t i = 0; i < motion.frames[0].size(); ++i) {
    const Vector3d& rest = motion.frames[0][i];
    if (std::abs(rest.x() - x) > half) continue;
    result.centre += motion.frames[frame][i];
    upwards += (rest.y() - middle) * motion.frames[frame][i];
    ++count;
  }
  result.centre /= static_cast<double>(count);
  result.turned = std::atan2(-upwards.x(), upwards.y());
  return result;
}

// The fall and the first swings; later ones are smaller.
constexpr std::uint64_t swing_frames = 240;

// How far a part of the bar swings in its own frame: the range of heights of its far end, relative to the
// near end and rotated with it, in lengths of the part.
double swing(const Motion& motion, double from, double to) {
  double low = 1e300, high = -1e300;
  for (std::size_t k = 0; k <= swing_frames; ++k) {
    const Section near = section(motion, from, k), far = section(motion, to, k);
    const Vector3d apart = far.centre - near.centre;
    const double height = -std::sin(near.turned) * apart.x() + std::cos(near.turned) * apart.y();
    low = std::min(low, height);
    high = std::max(high, height);
  }
  return (high - low) / (to - from);
}

// The ratio of the fat's swing to the muscle's.
double fat_over_muscle(const Motion& motion) {
  const double length = motion.length();
  return swing(motion, 0.5 * length, length) / swing(motion, 0.0, 0.5 * length);
}

// How far the vertices of one half of the bar are from their mean positions: RMS over frames and vertices, in
// lengths of the bar.
double motion_of_half(const Motion& motion, bool outer) {
  const double half = 0.5 * motion.length();
  double sum = 0.0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < motion.frames[0].size(); ++i) {
    if ((motion.frames[0][i].x() > half) != outer) continue;
    Vector3d mean = Vector3d::Zero();
    for (std::size_t k = 0; k <= swing_frames; ++k) mean += motion.frames[k][i];
    mean /= static_cast<double>(swing_frames + 1);
    for (std::size_t k = 0; k <= swing_frames; ++k) sum += (motion.frames[k][i] - mean).squaredNorm();
    count += swing_frames + 1;
  }
  return std::sqrt(sum / static_cast<double>(count)) / motion.length();
}

double rms_distance_of_tips(const Motion& a, const Motion& b) {
  double sum = 0.0;
  for (std::size_t k = 0; k <= frame_count; ++k) sum += (a.tip(k) - b.tip(k)).squaredNorm();
  return std::sqrt(sum / static_cast<double>(frame_count + 1)) / a.length();
}

TEST(Paper, Figure8MovesInFourWaysAndTheFatSwingsMost) {
  std::vector<Motion> motions;
  for (const char* name : {"bar-layers-iwamoto", "bar-layers-i", "bar-layers-ii", "bar-layers-iii"}) {
    motions.push_back(run(name));
    const Motion& motion = motions.back();
    const double muscle = motion_of_half(motion, false), fat = motion_of_half(motion, true);
    EXPECT_GT(fat, muscle) << name;
    // But the outer half of any bar moves more than the inner one, and swings less in its own frame, because
    // the inner half carries the weight of both. So compare with the same bar whose fat is as stiff as its
    // muscle: the ratio of the fat's swing to the muscle's must be larger by more than a visible tenth.
    const double ratio = fat_over_muscle(motion),
                 stiff = fat_over_muscle(run(name, {"layers.fat.alpha=1"}, swing_frames));
    RecordProperty(std::string(name) + " fat, muscle, ratio, with stiff fat",
                   std::to_string(fat) + " " + std::to_string(muscle) + " " + std::to_string(ratio) + " " +
                       std::to_string(stiff));
    EXPECT_GT(ratio, 1.1 * stiff) << name;
  }
  std::string all;
  for (std::size_t a = 0; a < motions.size(); ++a)
    for (std::size_t b = 0; b < a; ++b) {
      const double distance = rms_distance_of_tips(motions[a], motions[b]);
      const std::string pair = motions[a].scene.name + " and " + motions[b].scene.name;
      all += pair + " " + std::to_string(distance) + "; ";
      EXPECT_GT(distance, 0.02) << pair;  // visible in a picture
    }
  RecordProperty("distances", all);
}

const scene::Layer& layer(const scene::Scene& scene, const std::string& name) {
  for (const scene::Layer& one : scene.layers)
    if (one.name == name) return one;
  throw std::out_of_range(scene.name + " has no layer " + name);
}

TEST(Paper, Table1GivesTheParametersOfFigure8) {
  struct Row {
    const char* scene;
    double alpha_m, beta_m, alpha_f, beta_f;
  };
  constexpr Row table[]{{"bar-layers-iwamoto", 1.0, 0.0, 0.3, 0.0},
                        {"bar-layers-i", 1.0, 1.0, 0.3, 0.3},
                        {"bar-layers-ii", 1.0, 1.0, 0.3, 0.3},
                        {"bar-layers-iii", 1.0, 1.0, 0.3, 1.0}};
  for (const Row& row : table) {
    const scene::Scene scene = scene::load_scene(row.scene);
    EXPECT_EQ(scene.layers.size(), 2u) << row.scene;
    EXPECT_EQ(layer(scene, "muscle").alpha, row.alpha_m) << row.scene;
    EXPECT_EQ(layer(scene, "muscle").beta, row.beta_m) << row.scene;
    EXPECT_EQ(layer(scene, "fat").alpha, row.alpha_f) << row.scene;
    EXPECT_EQ(layer(scene, "fat").beta, row.beta_f) << row.scene;
  }
  // (i) and (ii) share a row of the table, and differ in the muscle's fibres.
  const scene::Scene one = scene::load_scene("bar-layers-i"), two = scene::load_scene("bar-layers-ii");
  EXPECT_NE(layer(one, "muscle").fibre.value(), layer(two, "muscle").fibre.value());
  EXPECT_EQ(layer(one, "fat").fibre.value(), layer(two, "fat").fibre.value());
  EXPECT_EQ(layer(one, "muscle").damping, layer(two, "muscle").damping);
}

}  // namespace

}  // namespace fascicle::tests
