// The parent's side of fascicle-mesher: the result for good surfaces, and one clear message for each kind of
// failure.
#include "host/build/tetrahedralize.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <locale>
#include <map>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>
#include <unistd.h>

#include "host/build/wrap.h"
#include "host/mesh/mesh_file.h"
#include "tests/support/assets.h"

namespace fascicle::tests {
namespace {

namespace fs = std::filesystem;
using build::BuildOptions;
using mesh::SurfaceMesh;
using mesh::TetMesh;
using scene::Vector3d;
using Triangle = std::array<std::uint32_t, 3>;

SurfaceMesh cube(const Vector3d& corner, double size) {
  SurfaceMesh mesh;
  for (std::uint32_t i = 0; i < 8; ++i) {
    mesh.vertices.push_back(corner + size * Vector3d((i & 1U) != 0, (i & 2U) != 0, (i & 4U) != 0));
  }
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

SurfaceMesh joined(const SurfaceMesh& a, const SurfaceMesh& b) {
  SurfaceMesh mesh = a;
  const auto offset = static_cast<std::uint32_t>(a.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), b.vertices.begin(), b.vertices.end());
  for (const Triangle& t : b.triangles)
    mesh.triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
  return mesh;
}

SurfaceMesh turned_inside_out(SurfaceMesh mesh) {
  for (Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
  return mesh;
}

// By the divergence theorem, relative to the first vertex.
double volume_inside(const SurfaceMesh& mesh) {
  double volume = 0.0;
  const Vector3d origin = mesh.vertices[0];
  for (const Triangle& t : mesh.triangles) {
    volume +=
        (mesh.vertices[t[0]] - origin).cross(mesh.vertices[t[1]] - origin).dot(mesh.vertices[t[2]] - origin) /
        6.0;
  }
  return volume;
}

double volume_of(const TetMesh& mesh, const std::array<std::uint32_t, 4>& t) {
  Eigen::Matrix3d edges;
  for (int k = 0; k < 3; ++k)
    edges.col(k) = mesh.vertices[t[static_cast<std::size_t>(k) + 1]] - mesh.vertices[t[0]];
  return edges.determinant() / 6.0;
}

double mean_edge(const TetMesh& mesh) {
  std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (const auto& t : mesh.tetrahedra) {
    for (std::size_t a = 0; a < 4; ++a) {
      for (std::size_t b = 0; b < a; ++b) edges.insert(std::minmax(t[a], t[b]));
    }
  }
  double sum = 0.0;
  for (const auto& [a, b] : edges) sum += (mesh.vertices[a] - mesh.vertices[b]).norm();
  return sum / static_cast<double>(edges.size());
}

// The promises of tetrahedralize().
void expect_fills(const TetMesh& mesh, const SurfaceMesh& surface) {
  ASSERT_GE(mesh.vertices.size(), surface.vertices.size());
  for (std::size_t i = 0; i < surface.vertices.size(); ++i) EXPECT_EQ(mesh.vertices[i], surface.vertices[i]);
  double volume = 0.0;
  std::vector<bool> is_used(mesh.vertices.size(), false);
  std::map<Triangle, int> faces;
  for (const auto& t : mesh.tetrahedra) {
    EXPECT_GT(volume_of(mesh, t), 0.0);
    volume += volume_of(mesh, t);
    for (std::size_t left_out = 0; left_out < 4; ++left_out) {
      Triangle face{};
      std::size_t size = 0;
      for (std::size_t k = 0; k < 4; ++k) {
        ASSERT_LT(t[k], mesh.vertices.size());
        is_used[t[k]] = true;
        if (k != left_out) face[size++] = t[k];
      }
      std::sort(face.begin(), face.end());
      ++faces[face];
    }
  }
  EXPECT_EQ(std::count(is_used.begin(), is_used.end(), false), 0);
  // Both sums have at most 1e6 terms of either sign, each with an error of about 1e-15 of the body's volume.
  const double wanted = std::abs(volume_inside(surface));
  EXPECT_NEAR(volume, wanted, 1e-9 * wanted);
  for (Triangle t : surface.triangles) {
    std::sort(t.begin(), t.end());
    EXPECT_EQ(faces[t], 1);
  }
  EXPECT_EQ(static_cast<std::size_t>(
                std::count_if(faces.begin(), faces.end(), [](const auto& face) { return face.second == 1; })),
            surface.triangles.size());
}

class Tetrahedralize : public ::testing::Test {
 protected:
  // Redirects temporary folders of the code under test into one of ours, so that leftovers are detected.
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "fascicle-test-XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = name;
    fs::create_directory(folder_ / "tmp");
    const char* before = std::getenv("TMPDIR");
    saved_ = before == nullptr ? "" : before;
    ::setenv("TMPDIR", (folder_ / "tmp").c_str(), 1);
    options_.mesher = fs::path(FASCICLE_BINARY_DIR) / "fascicle-mesher";
  }
  void TearDown() override {
    EXPECT_TRUE(fs::is_empty(folder_ / "tmp")) << "a temporary folder was left behind";
    if (saved_.empty()) {
      ::unsetenv("TMPDIR");
    } else {
      ::setenv("TMPDIR", saved_.c_str(), 1);
    }
    fs::remove_all(folder_);
  }

  // A shell script as mesher. $3 is the output's path.
  void fake_mesher(const std::string& script) {
    options_.mesher = folder_ / "fake-mesher";
    std::ofstream(options_.mesher) << "#!/bin/sh\n" << script << "\n";
    fs::permissions(options_.mesher, fs::perms::owner_all);
  }

  std::string refusal(const SurfaceMesh& surface, double edge = 0.0) const {
    std::string what = "accepted";
    try {
      build::tetrahedralize(surface, edge, {}, options_);
    } catch (const scene::SceneError& error) {
      what = error.what();
    }
    EXPECT_EQ(what.find('\n'), std::string::npos) << "more than one line: " << what;
    return what;
  }

  // What was said of the machine, and not of the input.
  static std::string machine_fault(const std::function<void()>& action) {
    try {
      action();
    } catch (const base::SceneError& error) {
      ADD_FAILURE() << "blamed the input: " << error.what();
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "nothing";
  }

  fs::path folder_;
  std::string saved_;
  BuildOptions options_;
};

#define EXPECT_REFUSED(message, part) \
  EXPECT_NE((message).find(part), std::string::npos) << "the message is: " << (message)

const SurfaceMesh unit_cube = cube(Vector3d::Zero(), 1.0);

TEST_F(Tetrahedralize, FillsCube) {
  const SurfaceMesh surface = cube({0.1, -0.2, 0.3}, 0.7);
  expect_fills(build::tetrahedralize(surface, 0.0, {}, options_), surface);
}

TEST_F(Tetrahedralize, TurnsInsideOutSurfaceRound) {
  const SurfaceMesh surface = turned_inside_out(unit_cube);
  expect_fills(build::tetrahedralize(surface, 0.0, {}, options_), surface);
}

TEST_F(Tetrahedralize, FillsSeparateParts) {
  const SurfaceMesh surface = joined(unit_cube, cube({3, 0, 0}, 0.5));
  expect_fills(build::tetrahedralize(surface, 0.0, {}, options_), surface);
}

TEST_F(Tetrahedralize, InsidePointsBecomeVerticesInOrder) {
  const std::vector<Vector3d> inside = {{0.5, 0.25, 0.5}, {7, 7, 7}, {0.3, 0.6, 0.7}};
  const TetMesh mesh = build::tetrahedralize(unit_cube, 0.0, inside, options_);
  expect_fills(mesh, unit_cube);
  ASSERT_GE(mesh.vertices.size(), 10U);
  EXPECT_EQ(mesh.vertices[8], inside[0]);
  EXPECT_EQ(mesh.vertices[9], inside[2]) << "the point outside should be left out";
}

// A program that calls the library may write numbers as people do.
TEST_F(Tetrahedralize, WritesPointsAsTheMesherReadsThemInAnyLocale) {
  struct Grouped : std::numpunct<char> {
    char do_thousands_sep() const override { return ','; }
    std::string do_grouping() const override { return "\3"; }
  };
  std::vector<Vector3d> inside;
  for (int k = 0; k < 1000; ++k) inside.emplace_back(7.0, 7.0, k);  // outside, so all are left out
  const std::locale before = std::locale::global(std::locale(std::locale::classic(), new Grouped));
  TetMesh mesh;
  EXPECT_NO_THROW(mesh = build::tetrahedralize(unit_cube, 0.0, inside, options_));
  std::locale::global(before);
  expect_fills(mesh, unit_cube);
}

TEST_F(Tetrahedralize, FillsBunnyWithTheWantedEdge) {
  const fs::path file = asset("bunny.off");
  FASCICLE_NEEDS_ASSET(file);
  const SurfaceMesh surface = mesh::read_surface_mesh(file);
  double own_edge = 0.0;
  for (const Triangle& t : surface.triangles) {
    for (std::size_t k = 0; k < 3; ++k)
      own_edge += (surface.vertices[t[k]] - surface.vertices[t[(k + 1) % 3]]).norm();
  }
  own_edge /= 3.0 * static_cast<double>(surface.triangles.size());
  const TetMesh mesh = build::tetrahedralize(surface, 0.0, {}, options_);
  expect_fills(mesh, surface);
  // The bound on volumes was calibrated here (measured: 0.997); another TetGen version may differ by a few
  // per cent.
  EXPECT_NEAR(mean_edge(mesh) / own_edge, 1.0, 0.05);
  const TetMesh finer = build::tetrahedralize(surface, 0.7 * own_edge, {}, options_);
  expect_fills(finer, surface);
  EXPECT_LT(mean_edge(finer), 0.85 * mean_edge(mesh));

  options_.mesher_bytes = std::uint64_t{60} << 20;
  EXPECT_REFUSED(refusal(surface, 0.5 * own_edge), "60 MiB of memory allowed; use");
  EXPECT_REFUSED(refusal(surface, 0.2 * own_edge), "million tetrahedra, more than the 60 MiB of memory");
  options_.mesher_bytes = std::uint64_t{4} << 30;
  EXPECT_REFUSED(refusal(surface, 0.05 * own_edge), "million tetrahedra, more than the 4096 MiB of memory");
  // A limit is also how long the machine may stand still, so it must not be short.
  options_.mesher_seconds = 1.5;
  EXPECT_REFUSED(refusal(surface, 0.25 * own_edge), "longer than the 1.5 s");
}

TEST_F(Tetrahedralize, RefusesSurfacesThatEncloseNothing) {
  SurfaceMesh open = unit_cube;
  open.triangles.pop_back();
  EXPECT_REFUSED(refusal(open), "has only one triangle");
  SurfaceMesh flipped = unit_cube;
  std::swap(flipped.triangles[3][0], flipped.triangles[3][1]);
  EXPECT_REFUSED(refusal(flipped), "face opposite ways");
  SurfaceMesh fin = unit_cube;
  fin.triangles.push_back({0, 2, 7});
  EXPECT_REFUSED(refusal(fin), "has 3 triangles");
  SurfaceMesh loose = unit_cube;
  loose.vertices.emplace_back(5, 5, 5);
  EXPECT_REFUSED(refusal(loose), "vertex 8 belongs to no triangle");
  SurfaceMesh split = joined(unit_cube, cube({1, 1, 1}, 1.0));
  EXPECT_REFUSED(refusal(split), "vertices 7 and 8 lie at one place");
  EXPECT_REFUSED(refusal(SurfaceMesh{}), "no triangles");
}

TEST_F(Tetrahedralize, NamesWhereASurfaceCrossesItself) {
  const SurfaceMesh crossing = joined(unit_cube, cube({0.5, 0.4, 0.3}, 1.0));
  const std::string message = refusal(crossing);
  EXPECT_REFUSED(message, "crosses itself: triangles ");
  EXPECT_REFUSED(message, "cross near (");
}

TEST_F(Tetrahedralize, RefusesPartsInsideOthers) {
  EXPECT_REFUSED(refusal(joined(unit_cube, cube({0.3, 0.3, 0.3}, 0.3))), "inside another part");
}

TEST_F(Tetrahedralize, RefusesImpossibleEdges) {
  EXPECT_REFUSED(refusal(unit_cube, -1.0), "edge length");
  EXPECT_REFUSED(refusal(unit_cube, std::numeric_limits<double>::quiet_NaN()), "edge length");
  EXPECT_REFUSED(refusal(unit_cube, 1e-200), "scale it");
}

TEST_F(Tetrahedralize, SaysWhenTheMesherIsMissing) {
  options_.mesher = folder_ / "nothing";
  EXPECT_REFUSED(refusal(unit_cube), "no such program");
  options_.mesher = folder_ / "tmp";  // a folder
  EXPECT_REFUSED(refusal(unit_cube), "no such program");
  options_.mesher = folder_ / "not-a-program";
  std::ofstream(options_.mesher) << "neither ELF nor script";
  fs::permissions(options_.mesher, fs::perms::owner_all);
  EXPECT_REFUSED(refusal(unit_cube), "cannot run fascicle-mesher");
}

// A full or missing folder for temporary files is the machine's fault: a farm tries the job on another.
TEST_F(Tetrahedralize, BlamesTheMachineForItsTemporaryFolder) {
  const std::string before = std::getenv("TMPDIR") == nullptr ? "" : std::getenv("TMPDIR");
  ::setenv("TMPDIR", (folder_ / "missing").c_str(), 1);
  const std::string said = machine_fault([&] { build::tetrahedralize(unit_cube, 0.0, {}, options_); });
  if (before.empty())
    ::unsetenv("TMPDIR");
  else
    ::setenv("TMPDIR", before.c_str(), 1);
  EXPECT_NE(said.find("(TMPDIR)"), std::string::npos) << said;
}

// So is what ends the mesher from outside, and a disk that is full when it writes.
TEST_F(Tetrahedralize, BlamesTheMachineForWhatEndsTheMesher) {
  const auto each_run = [&](const std::string& script, const std::string& part) {
    fake_mesher("echo run >> '" + (folder_ / "runs").string() + "'; " + script);
    build::WrapOrder order;
    order.alpha = 0.1;
    for (const std::string& said :
         {machine_fault([&] { build::tetrahedralize(unit_cube, 0.0, {}, options_); }),
          machine_fault([&] { build::wrap_surface(unit_cube, order, options_); }),
          machine_fault([&] { build::find_defects(unit_cube, options_); })}) {
      EXPECT_REFUSED(said, part);
      EXPECT_EQ(said.find("surface may have"), std::string::npos) << said;
      EXPECT_EQ(said.find('\n'), std::string::npos) << said;
    }
  };
  each_run("kill -KILL $$", "was killed from outside (Killed) while ");
  each_run("kill -TERM $$", "was killed from outside (Terminated) while ");
  each_run("kill -HUP $$", "often for lack of memory");
  each_run("echo 'fascicle-mesher: write: File too large' >&2; exit 9",
           "File too large; check the free space");
  each_run("exit 3", "could not read its files");
  std::ifstream file(folder_ / "runs");
  const std::string runs{std::istreambuf_iterator<char>(file), {}};
  EXPECT_EQ(std::count(runs.begin(), runs.end(), '\n'), 15) << "a run was tried again";
}

// The mesher itself, whose files may not be larger than 1 KiB; 160 vertices and as many tetrahedra take more.
TEST_F(Tetrahedralize, BlamesTheMachineForALimitOnFiles) {
  const std::string mesher = options_.mesher.string();
  fake_mesher("ulimit -f 1; exec '" + mesher + "' \"$@\"");
  SurfaceMesh cubes = unit_cube;
  for (int k = 1; k < 20; ++k) cubes = joined(cubes, cube({2.0 * k, 0, 0}, 1.0));
  EXPECT_REFUSED(machine_fault([&] { build::tetrahedralize(cubes, 0.0, {}, options_); }), "(ulimit -f)");
}

TEST_F(Tetrahedralize, SurvivesMeshersThatEndBadly) {
  fake_mesher("echo 'free(): invalid pointer' >&2; kill -SEGV $$");
  const std::string crash = refusal(unit_cube);
  EXPECT_NE(crash.find("crashed (Segmentation fault); the surface may have"), std::string::npos) << crash;
  EXPECT_EQ(crash.find("invalid pointer"), std::string::npos) << "it shows internals: " << crash;
  fake_mesher("kill -ABRT $$");
  EXPECT_REFUSED(refusal(unit_cube), "crashed (Aborted)");
  fake_mesher("exit 42");
  EXPECT_REFUSED(refusal(unit_cube), "exit status 42");
  fake_mesher("exit 8");
  EXPECT_REFUSED(refusal(unit_cube), "no tetrahedra");
  fake_mesher("exit 7");
  EXPECT_REFUSED(refusal(unit_cube), "could not be filled");
}

TEST_F(Tetrahedralize, StopsMeshersThatDoNotEnd) {
  const double usual = options_.mesher_seconds;
  // A limit is also how long the machine may stand still, so it must not be short where the mesher runs.
  options_.mesher_seconds = 1.5;
  fake_mesher("trap '' TERM INT; while :; do :; done");
  EXPECT_REFUSED(refusal(unit_cube), "longer than the 1.5 s");
  fake_mesher("while :; do echo noise >&2; done");
  EXPECT_REFUSED(refusal(unit_cube), "longer than the 1.5 s");
  options_.mesher_seconds = 0.3;
  fake_mesher("exec 2>&-; sleep 600");
  EXPECT_REFUSED(refusal(unit_cube), "made no progress for 0.3 s");
  options_.mesher_seconds = usual;
  // Its child processes are killed too, even if they keep stderr open.
  fake_mesher("(sleep 2; touch '" + (folder_ / "survived").string() + "') & exit 8");
  EXPECT_REFUSED(refusal(unit_cube), "no tetrahedra");
  ::sleep(3);
  EXPECT_FALSE(fs::exists(folder_ / "survived"));
}

// As on a busy machine: 5 s pass, of which the mesher runs for a few milliseconds.
TEST_F(Tetrahedralize, WaitsForMeshersThatGetLittleOfTheProcessor) {
  options_.mesher_seconds = 3.0;
  fake_mesher("i=0; while [ $i -lt 25 ]; do i=$((i+1)); sleep 0.2; done; exit 8");
  EXPECT_REFUSED(refusal(unit_cube), "no tetrahedra");
}

TEST_F(Tetrahedralize, StopsMeshersThatEatMemory) {
  options_.mesher_bytes = std::uint64_t{64} << 20;
  fake_mesher("x=0123456789abcdef; while :; do x=$x$x; done");
  const std::string message = refusal(unit_cube);
  EXPECT_EQ(message.find("longer than"), std::string::npos)
      << message;  // it reached the memory limit, not the time limit
  EXPECT_NE(message, "accepted");
}

// A cube of twelve triangles gets 256 MiB plus 2 KiB for each expected tetrahedron, not the full 4 GiB.
TEST_F(Tetrahedralize, GivesMemoryByWhatIsDue) {
  fake_mesher("ulimit -v >&2; exit 6");
  EXPECT_REFUSED(refusal(unit_cube), "256 MiB set aside for a surface of 12 triangles at this resolution. ");
  const auto limit = [this](double edge) {
    fake_mesher("ulimit -v > '" + (folder_ / "limit").string() + "'; exit 8");
    refusal(unit_cube, edge);
    std::ifstream in(folder_ / "limit");
    double kib = 0.0;
    in >> kib;
    return kib;
  };
  const double coarse = limit(1.0), fine = limit(0.02);
  EXPECT_NEAR(coarse, 256 * 1024, 1024);
  // 6 sqrt(2) / 0.02^3 regular tetrahedra at 2 KiB each; the triangles' share is below 1 MiB.
  EXPECT_NEAR(fine - coarse, 2.0 * 6.0 * std::sqrt(2.0) / 8e-6, 1024);
  EXPECT_NEAR(limit(0.007), 4.0 * 1024 * 1024, 1.0) << "never more than the options allow";
}

TEST_F(Tetrahedralize, BelievesNothingThatComesBack) {
  fake_mesher("exit 0");
  EXPECT_REFUSED(refusal(unit_cube), "there is no file");
  fake_mesher(": > $3");
  EXPECT_REFUSED(refusal(unit_cube), "cannot be used");
  const std::string vertices =
      "MeshVersionFormatted 2\\nDimension 3\\nVertices\\n8\\n0 0 0 0\\n1 0 0 0\\n0 1 0 0\\n1 1 0 0\\n0 0 1 "
      "0\\n"
      "1 0 1 0\\n0 1 1 0\\n1 1 1 0\\nTetrahedra\\n";
  const auto answer = [&](const std::string& text) { fake_mesher("printf '" + text + "' > $3"); };
  answer(vertices + "1\\n1 2 3 9 0\\nEnd\\n");
  EXPECT_REFUSED(refusal(unit_cube), "vertex number 9");
  answer(vertices + "0\\nEnd\\n");
  EXPECT_REFUSED(refusal(unit_cube), "no tetrahedra");
  answer(vertices + "1\\n1 2 3 5 0\\nEnd\\n");
  EXPECT_REFUSED(refusal(unit_cube), "of the surface is in no tetrahedron");
  answer(vertices + "1\\n1 2 3 4 0\\nEnd\\n");
  EXPECT_REFUSED(refusal(unit_cube), "is flat");
  // Five tetrahedra fill a cube correctly, but not with the surface's diagonals.
  answer(vertices + "5\\n1 2 3 5 0\\n4 3 2 8 0\\n6 2 5 8 0\\n7 3 8 5 0\\n2 3 5 8 0\\nEnd\\n");
  EXPECT_REFUSED(refusal(unit_cube), "its outside is not the surface");
  SurfaceMesh moved = unit_cube;
  moved.vertices[3].x() += 1e-15;
  EXPECT_REFUSED(refusal(moved), "vertex 3 of the surface was moved");
}

}  // namespace
}  // namespace fascicle::tests
