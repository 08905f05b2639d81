// The implicit integrator on rods: rod and beam theory, and independence of frame rate, substeps and
// resolution. Strong damping brings rods to rest without changing their rest position.
#include <array>
#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "cpu_reference/solver/cpu_solver.h"
#include "host/drive/drive_source.h"
#include "host/scene/scene.h"
#include "tests/paper/built_scene.h"

namespace fascicle::tests {

namespace {

using Eigen::Vector3d;

// The tip's displacement after each frame, m.
struct RodSwing {
  double fps = 0.0;
  std::uint32_t substeps = 0;
  double frequency = 0.0;  // of the layer, as computed by the build
  std::vector<Vector3d> tip;
};

RodSwing swing_of(const scene::Scene& scene) {
  const double fps = scene.fps;
  const auto [model, substeps, options] = built(scene);
  drive::DriveSource drives(scene, model, substeps);
  const auto solver = cpu_reference::make_cpu_solver(model, options, 2);
  solver->load(drives.initial_state());
  RodSwing result{fps, substeps, model.layers[0].frequency, {}};
  for (std::uint64_t k = 1; k <= scene::frame_count(scene); ++k) {
    solver->submit(drives.drive(k), {.positions = true});
    const model::Frame frame = solver->collect();
    Vector3d tip = Vector3d::Zero();
    for (const std::uint32_t i : model.probes[0].vertices)
      for (std::size_t a = 0; a < 3; ++a)
        tip[static_cast<Eigen::Index>(a)] += model.unit * (double{frame.positions[3 * std::size_t{i} + a]} -
                                                           double{model.rest[3 * std::size_t{i} + a]});
    result.tip.push_back(tip / static_cast<double>(model.probes[0].vertices.size()));
  }
  return result;
}

RodSwing swing_of(const std::string& name, const std::vector<std::string>& set, double fps, double seconds) {
  return swing_of(scene::load_scene(name, {.set = set, .fps = fps, .end = seconds}));
}

double sag_of(const RodSwing& s, const std::string& name) {
  // At rest: within a thousandth of its position a quarter of a second before. Only vertically: on an
  // asymmetric mesh, the hanging rod creeps sideways for longer.
  const double before = s.tip[s.tip.size() - 1 - static_cast<std::size_t>(s.fps / 4.0)].y();
  EXPECT_NEAR(s.tip.back().y(), before, 1e-3 * std::abs(before)) << name;
  return -s.tip.back().y();
}

// How far the tip has dropped at rest.
double sag(const std::string& name, std::vector<std::string> set = {}, double fps = 30.0,
           double seconds = 2.0, double damping = 25.0) {
  set.push_back("layers.body.damping=" + std::to_string(damping));
  return sag_of(swing_of(name, set, fps, seconds), name);
}

// The hanging rod as a surface of squares, cut along alternating diagonals, with `along` vertices along it.
mesh::SurfaceMesh rod_surface(std::uint32_t along) {
  const std::array<std::uint32_t, 3> count{(along - 1) / 5 + 1, along, (along - 1) / 5 + 1};
  const std::array<double, 3> size{0.08, 0.4, 0.08};
  mesh::SurfaceMesh mesh;
  std::map<std::array<std::uint32_t, 3>, std::uint32_t> number;
  const auto vertex = [&](const std::array<std::uint32_t, 3>& at) {
    const auto [entry, is_new] = number.try_emplace(at, static_cast<std::uint32_t>(mesh.vertices.size()));
    if (is_new)
      mesh.vertices.emplace_back(size[0] * at[0] / (count[0] - 1), size[1] * at[1] / (count[1] - 1),
                                 size[2] * at[2] / (count[2] - 1));
    return entry->second;
  };
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (const bool is_far : {false, true}) {
      const std::size_t b = (axis + 1) % 3, c = (axis + 2) % 3;
      for (std::uint32_t i = 0; i + 1 < count[b]; ++i)
        for (std::uint32_t j = 0; j + 1 < count[c]; ++j) {
          const auto corner = [&](std::uint32_t di, std::uint32_t dj) {
            std::array<std::uint32_t, 3> at{};
            at[axis] = is_far ? count[axis] - 1 : 0;
            at[b] = i + di;
            at[c] = j + dj;
            return vertex(at);
          };
          const std::uint32_t p = corner(0, 0), q = corner(1, 0), r = corner(1, 1), s = corner(0, 1);
          const bool turned = (i + j) % 2 == 0;
          for (auto triangle : turned ? std::array{std::array{p, q, s}, std::array{q, r, s}}
                                      : std::array{std::array{p, q, r}, std::array{p, r, s}}) {
            if (!is_far) std::swap(triangle[0], triangle[2]);
            mesh.triangles.push_back(triangle);
          }
        }
    }
  return mesh;
}

double sag_of_filled_rod(std::uint32_t along, double E, double seconds, double damping) {
  scene::Scene scene =
      scene::load_scene("rod-hang", {.set = {"layers.body.damping=" + std::to_string(damping),
                                             "layers.body.youngs_modulus=" + std::to_string(E)},
                                     .fps = 30.0,
                                     .end = seconds});
  scene.geometry = rod_surface(along);
  return sag_of(swing_of(scene), "filled rod");
}

std::string vertices(int along, bool hangs) {
  const std::string n = std::to_string(along), across = std::to_string((along - 1) / 5 + 1);
  return "bar.vertices=" + (hangs ? "[" + across + ", " + n + ", " + across + "]"
                                  : "[" + n + ", " + across + ", " + across + "]");
}

// Density x g x length^2 / (2 E), and density x g x area x length^4 / (8 E I).
constexpr double rod_theory = 1000.0 * 9.81 * 0.4 * 0.4 / (2.0 * 20e3);
constexpr double beam_theory = 1000.0 * 9.81 * 0.4 * 0.4 * 0.4 * 0.4 / (8.0 * 2e6 * 0.08 * 0.08 / 12.0);

TEST(Rods, RestWhereTheyDoAtEveryFrameRate) {
  for (const char* name : {"rod-hang", "rod-cantilever"}) {
    const double at_60 = sag(name, {}, 60.0, 1.5);
    for (const double fps : {24.0, 30.0, 120.0})
      EXPECT_NEAR(sag(name, {}, fps, 1.5), at_60, 0.02 * at_60) << name << fps;
  }
}

TEST(Rods, RestWhereTheyDoWithAnyNumberOfSubsteps) {
  for (const char* name : {"rod-hang", "rod-cantilever"}) {
    const double at_8 = sag(name, {"solver.substeps=8"}, 60.0, 1.5);
    for (const char* substeps : {"1", "2", "4"})
      EXPECT_NEAR(sag(name, {std::string("solver.substeps=") + substeps}, 60.0, 2.5, 15.0), at_8, 0.02 * at_8)
          << name << substeps;
  }
}

// The chosen number of iterations compared with many more.
TEST(Rods, AsManyIterationsAsChosenAreEnough) {
  for (const char* name : {"rod-hang", "rod-cantilever"}) {
    const double many = sag(name, {"solver.substeps=2", "solver.iterations=80"}, 30.0, 1.5);
    EXPECT_NEAR(sag(name, {"solver.substeps=2"}, 30.0, 2.5, 15.0), many, 0.02 * many) << name;
  }
}

// Coarse rods are too stiff; finer ones converge to theory. Measured 18, 6.2, 2.5 and 1.5 % below it when
// hanging, and 13 and 2.7 % when bending, with 21 and 41 vertices along.
TEST(Rods, ApproachTheoryUnderRefinement) {
  const double hang[]{sag("rod-hang", {vertices(11, true)}), sag("rod-hang"),
                      sag("rod-hang", {vertices(41, true)}, 24.0, 1.5),
                      sag("rod-hang", {vertices(81, true)}, 24.0, 1.5)};
  EXPECT_LT(std::abs(hang[2] - hang[1]), std::abs(hang[1] - hang[0]));
  EXPECT_LT(std::abs(hang[3] - hang[2]), std::abs(hang[2] - hang[1]));
  EXPECT_NEAR(hang[1], rod_theory, 0.10 * rod_theory);
  EXPECT_NEAR(hang[2], rod_theory, 0.05 * rod_theory);
  EXPECT_NEAR(hang[3], rod_theory, 0.05 * rod_theory);
  const double bent[]{sag("rod-cantilever", {vertices(11, false)}), sag("rod-cantilever"),
                      sag("rod-cantilever", {vertices(41, false)}, 24.0, 1.5)};
  EXPECT_LT(std::abs(bent[2] - bent[1]), std::abs(bent[1] - bent[0]));
  EXPECT_NEAR(bent[1], beam_theory, 0.25 * beam_theory);
  EXPECT_NEAR(bent[2], beam_theory, 0.10 * beam_theory);
}

// The same filled by TetGen, over two decades of E. Measured 8.5 % below theory with 21 vertices along, and
// 4.3 % with 41. It was 15 % with 21, failing this test, when the compliance of regions at the surface was a
// mean over all directions, as it is inside.
TEST(Rods, HangAsFarOnAnIrregularMesh) {
  EXPECT_NEAR(sag_of_filled_rod(21, 20e3, 2.0, 25.0), rod_theory, 0.10 * rod_theory);
  EXPECT_NEAR(sag_of_filled_rod(21, 200e3, 2.0, 25.0), 0.1 * rod_theory, 0.10 * 0.1 * rod_theory);
  EXPECT_NEAR(sag_of_filled_rod(21, 2e3, 3.0, 10.0), 10.0 * rod_theory, 0.10 * 10.0 * rod_theory);
  EXPECT_NEAR(sag_of_filled_rod(81, 20e3, 2.0, 25.0), rod_theory, 0.05 * rod_theory);
}

// Over two decades of E, stretch is inversely proportional to it; at 2 kPa the rod is twice as long, which
// linear theory does not cover.
TEST(Rods, StretchInverselyToYoungsModulus) {
  EXPECT_NEAR(sag("rod-hang", {"layers.body.youngs_modulus=200e3"}), 0.1 * rod_theory, 0.01 * rod_theory);
  EXPECT_NEAR(sag("rod-hang", {"layers.body.youngs_modulus=2e3"}, 30.0, 3.0, 10.0), 10.0 * rod_theory,
              1.0 * rod_theory);
}

// At fixed E fibres stiffen along and soften across, monotonically in beta.
TEST(Rods, FibresTurnStiffnessAndDoNotScaleIt) {
  double along = sag("rod-hang"), across = along;
  for (const char* beta : {"0.25", "0.5", "0.75", "1"}) {
    const std::string set = std::string("layers.body.beta=") + beta;
    const double stiffer = sag("rod-hang", {set, "layers.body.fibre=[0, 1, 0]"}),
                 softer = sag("rod-hang", {set, "layers.body.fibre=[1, 0, 0]"});
    EXPECT_LT(stiffer, along) << beta;
    EXPECT_GT(softer, across) << beta;
    along = stiffer;
    across = softer;
  }
}

struct Mode {
  double frequency, ratio;  // Hz; damping ratio
};

// From a decaying swing: the times and heights of its extrema, by parabolas through three frames.
Mode mode_of(const RodSwing& s) {
  std::vector<std::pair<double, double>> turns;
  for (std::size_t i = 1; i + 1 < s.tip.size(); ++i) {
    const double a = s.tip[i - 1].y(), b = s.tip[i].y(), c = s.tip[i + 1].y(), bend = a - 2.0 * b + c;
    if ((b - a) * (c - b) > 0.0 || bend == 0.0) continue;
    const double shift = (a - c) / (2.0 * bend);
    turns.emplace_back((static_cast<double>(i) + shift) / s.fps, b - (a - c) * shift / 4.0);
  }
  // The first extremum still contains higher modes.
  constexpr std::size_t first = 1, last = 6;
  if (turns.size() <= last) throw std::runtime_error("it hardly swings");
  const double half_period = (turns[last].first - turns[first].first) / double(last - first);
  const double ratio = std::abs((turns[first + 1].second - turns[first].second) /
                                (turns[last].second - turns[last - 1].second));
  const double decrement = std::log(ratio) / double(last - first - 1);
  const double zeta = decrement / std::hypot(decrement, M_PI);
  return {0.5 / half_period / std::sqrt(1.0 - zeta * zeta), zeta};
}

// A layer given in Hz swings at that frequency and decays by its damping ratio, at every frame rate and at
// two resolutions. Kuhn's tetrahedra stiffen one diagonal of the section: gravity acts along the other, the
// direction of the lowest mode.
TEST(Rods, SwingAtTheFrequencyAndRatioAskedFor) {
  for (const int along : {11, 21})
    for (const double fps : {24.0, 30.0, 60.0, 120.0}) {
      const RodSwing s = swing_of("rod-cantilever",
                                  {vertices(along, false), "layers.body.frequency=3",
                                   "layers.body.damping_ratio=0.1", "scene.gravity=[0, -0.35, 0.35]"},
                                  fps, 1.5);
      EXPECT_NEAR(s.frequency, 3.0, 1e-6);
      const Mode mode = mode_of(s);
      EXPECT_NEAR(mode.frequency, 3.0, 0.03 * 3.0) << along << " vertices, " << fps << " fps";
      EXPECT_NEAR(mode.ratio, 0.1, 0.05 * 0.1) << along << " vertices, " << fps << " fps";
    }
}

}  // namespace

}  // namespace fascicle::tests
