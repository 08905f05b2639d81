// The files of a bake, read back by code that shares nothing with the writers, and compared with closed
// forms.
#include "host/formats/formats.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <locale>
#include <map>
#include <random>
#include <sstream>
#include <string>
#include <system_error>
#include <vector>

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "host/bake/bake.h"
#include "host/bake/outputs.h"
#include "host/bake/read_frame_cache.h"
#include "host/formats/blender_script.h"
#include "host/formats/frame_files.h"
#include "host/formats/rest_mesh.h"
#include "host/formats/surface.h"
#include "host/formats/surface_objects.h"
#include "shaders/kernel/embed.inc"
#include "tests/bake/fake_solver.h"
#include "tests/formats/sink_frames.h"
#include "tests/formats/vtk_reader.h"

namespace fascicle::tests {
namespace {

namespace fs = std::filesystem;
using bake::BakeError;

constexpr std::array<double, 3> origin = sink_origin;

std::vector<std::string> split(const std::string& line, char by) {
  std::vector<std::string> parts;
  std::istringstream in(line);
  for (std::string part; std::getline(in, part, by);) parts.push_back(part);
  return parts;
}

TEST(Surface, EmbedHasTheBitsOfTheKernel) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> uniform(-3.0f, 3.0f);
  model::Model model = two_tetrahedra();
  for (int round = 0; round < 1000; ++round) {
    std::vector<float> positions(15);
    for (float& value : positions) value = uniform(random) * (round % 3 == 0 ? 1e-13f : 1.0f);
    for (float& weight : model.surface_weight) weight = uniform(random);
    const std::vector<float> surface = formats::embed(model, positions);
    ASSERT_EQ(surface.size(), 9u);
    for (std::size_t s = 0; s < 3; ++s)
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const float* w = &model.surface_weight[4 * s];
        const auto x = [&](std::size_t c) { return positions[3 * model.surface_vertex[4 * s + c] + axis]; };
        const float expected =
            kernel::embed_coordinate<float>(w[0], x(0), w[1], x(1), w[2], x(2), w[3], x(3));
        ASSERT_EQ(std::bit_cast<std::uint32_t>(surface[3 * s + axis]),
                  std::bit_cast<std::uint32_t>(expected));
      }
  }
}

TEST(Surface, RestObjHasTheRenderMeshInMetres) {
  const model::Model model = two_tetrahedra();
  std::istringstream in(formats::rest_obj(model, formats::read_surface_objects(model, {})));
  std::vector<std::array<double, 3>> vertices;
  std::vector<std::array<int, 3>> triangles;
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    std::string kind;
    words >> kind;
    if (kind == "v") words >> vertices.emplace_back()[0] >> vertices.back()[1] >> vertices.back()[2];
    if (kind == "f") words >> triangles.emplace_back()[0] >> triangles.back()[1] >> triangles.back()[2];
    EXPECT_TRUE(words) << line;
  }
  // Rest origin (10, 0, -3), unit 0.5; the second vertex is the first tetrahedron's centre.
  EXPECT_EQ(vertices, (std::vector<std::array<double, 3>>{
                          {10.0, 0.0, -3.0}, {10.125, 0.125, -2.875}, {10.3125, 0.3125, -2.625}}));
  EXPECT_EQ(triangles, (std::vector<std::array<int, 3>>{{1, 2, 3}}));
}

TEST(Pc2, HeaderAndEverySample) {
  const TemporaryFolder folder;
  const model::Model model = two_tetrahedra();
  write_frames(formats::format_named("pc2").make(), model, folder / "");
  const std::string bytes = read_text(folder / "surface.pc2");
  EXPECT_EQ(bytes.substr(0, 12), std::string("POINTCACHE2\0", 12));
  EXPECT_EQ(read_value<std::int32_t>(bytes, 12), 1);
  EXPECT_EQ(read_value<std::int32_t>(bytes, 16), 3);
  EXPECT_EQ(read_value<float>(bytes, 20), 0.0f);
  EXPECT_EQ(read_value<float>(bytes, 24), 1.0f);
  EXPECT_EQ(read_value<std::int32_t>(bytes, 28), 3);
  ASSERT_EQ(bytes.size(), 32u + 3 * 3 * 12);
  EXPECT_EQ(bytes.size(), formats::format_named("pc2").bytes(model, 3));
  for (std::size_t k = 0; k < 3; ++k) {
    const double s = 0.5 * (1.0 + 0.25 * static_cast<double>(k));
    // Render vertices at rest in working units, by hand from the weights; exact in float.
    const double at[3][3] = {{0, 0, 0}, {0.25, 0.25, 0.25}, {0.625, 0.625, 0.75}};
    for (std::size_t v = 0; v < 3; ++v)
      for (std::size_t axis = 0; axis < 3; ++axis)
        EXPECT_EQ(read_value<float>(bytes, 32 + 12 * (3 * k + v) + 4 * axis),
                  static_cast<float>(origin[axis] + s * at[v][axis]));
  }
}

TEST(Pc2, RefusesABodyWithoutSurface) {
  const TemporaryFolder folder;
  model::Model model = two_tetrahedra();
  model.surface_vertex.clear();
  model.surface_weight.clear();
  model.surface_triangle.clear();
  EXPECT_THROW(write_frames(formats::format_named("pc2").make(), model, folder / ""), BakeError);
}

TEST(Metrics, AgainstClosedForms) {
  const TemporaryFolder folder;
  const model::Model model = two_tetrahedra();
  write_frames(bake::make_metrics_sink(), model, folder / "");
  std::istringstream in(read_text(folder / "metrics.csv"));
  std::string line;
  std::getline(in, line);
  EXPECT_EQ(line,
            "frame,time,kinetic_energy,volume,volume_ratio,largest_displacement,inverted,volume_fat,"
            "volume_ratio_fat,volume_bone,volume_ratio_bone,tip_x,tip_y,tip_z");
  for (int k = 0; k < 3; ++k) {
    ASSERT_TRUE(std::getline(in, line));
    const std::vector<std::string> cells = split(line, ',');
    ASSERT_EQ(cells.size(), 14u);
    const auto cell = [&](std::size_t c) { return std::stod(cells[c]); };
    const double s = 1.0 + 0.25 * k;
    // All inputs are small multiples of powers of two. Only the division by 6, the division by the rest
    // volume and the square root round: a few times 2^-53 each.
    constexpr double few_ulps = 1e-15;
    EXPECT_EQ(cells[0], std::to_string(k));
    EXPECT_EQ(cell(1), 1.5 + k / 8.0);
    // Masses 2, 3, 4 at distance 1 and 5 at squared distance 3; velocity k x, half a metre per unit.
    EXPECT_EQ(cell(2), 0.5 * (2 + 3 + 4 + 5 * 3) * k * k * 0.25);
    // Volumes 1/6 and 1/3 in cubic units of 1/8 m^3, times s^3.
    EXPECT_NEAR(cell(3), 0.5 / 8.0 * s * s * s, few_ulps);
    EXPECT_NEAR(cell(4), s * s * s, 10 * few_ulps);
    // The far corner (1, 1, 1) moves by the factor s - 1; the origin is that of frame 0.
    EXPECT_NEAR(cell(5), 0.5 * (s - 1.0) * std::sqrt(3.0), few_ulps);
    EXPECT_EQ(cells[6], "0");
    // One corner of four of the larger tetrahedron is bone.
    EXPECT_NEAR(cell(7), 5.0 / 12.0 / 8.0 * s * s * s, few_ulps);
    EXPECT_NEAR(cell(8), s * s * s, 10 * few_ulps);
    EXPECT_NEAR(cell(9), 1.0 / 12.0 / 8.0 * s * s * s, few_ulps);
    EXPECT_NEAR(cell(10), s * s * s, 10 * few_ulps);
    // The tip is the mean of (1, 0, 0) and (0, 0, 1).
    EXPECT_EQ(cell(11), 12.0 + 0.25 * s);
    EXPECT_EQ(cell(12), -1.0);
    EXPECT_EQ(cell(13), 4.0 + 0.25 * s);
  }
  EXPECT_FALSE(std::getline(in, line));
}

// A frame with another origin can be at the same place in the world.
TEST(Metrics, DisplacementIsInTheWorld) {
  const TemporaryFolder folder;
  const model::Model model = two_tetrahedra();
  const model::Frame initial = stretched(model, 0);
  model::Frame moved = stretched(model, 0);
  moved.index = 1;
  moved.origin = {13.0, -1.0, 4.0};
  for (std::size_t i = 0; i < moved.positions.size(); i += 3) moved.positions[i] -= 2.0f;  // 1 m
  const auto sink = bake::make_metrics_sink();
  sink->begin({.model = &model,
               .folder = folder / "",
               .scene_name = "s",
               .fps = 8.0,
               .start = 0.0,
               .frames = 1,
               .first = 0,
               .initial = &initial});
  sink->write(initial);
  sink->write(moved);
  sink->finish();
  std::istringstream in(read_text(folder / "metrics.csv"));
  std::string line, last;
  while (std::getline(in, line)) last = line;
  EXPECT_EQ(split(last, ',')[5], "0");
}

// Two tetrahedra with a skeleton. In frame k the flesh is k/4 units from its skinned position. In frame 1 one
// skinned vertex, and in frame 2 one vertex of the flesh, is on the wrong side of its tetrahedron's face.
TEST(Metrics, LagAndInversionBesideSkinningAlone) {
  const TemporaryFolder folder;
  model::Model model = two_tetrahedra();
  model.joint_count = 1;
  model.skin_offset = {0, 1, 2, 3, 4, 5};
  model.skin_joint.assign(5, 0);
  model.skin_weight.assign(5, 1.0f);
  const auto frame = [&](std::uint64_t k) {
    model::Frame f{.index = k,
                   .origin = {},
                   .positions = model.rest,
                   .velocities = model.rest,
                   .surface = {},
                   .skinned = model.rest};
    for (std::size_t i = 1; i < f.positions.size(); i += 3) f.positions[i] += 0.25f * static_cast<float>(k);
    if (k == 1) std::fill_n(f.skinned.begin(), 3, 1.0f);
    if (k == 2) std::fill_n(f.positions.begin(), 3, 2.0f);
    return f;
  };
  const model::Frame initial = frame(0);
  const auto sink = bake::make_metrics_sink();
  EXPECT_TRUE(sink->needs().skinned);
  sink->begin({.model = &model,
               .folder = folder / "",
               .scene_name = "s",
               .fps = 8.0,
               .start = 0.0,
               .frames = 2,
               .first = 0,
               .initial = &initial});
  for (std::uint64_t k = 0; k < 3; ++k) sink->write(frame(k));
  sink->finish();
  std::istringstream in(read_text(folder / "metrics.csv"));
  std::string line;
  std::getline(in, line);
  EXPECT_NE(line.find(",inverted,inverted_skinned,lag_fat,lag_bone,volume_fat,volume_ratio_fat,volume_bone,"
                      "volume_ratio_bone,tip_x"),
            std::string::npos)
      << line;
  const auto cells_of_next = [&] {
    std::getline(in, line);
    return split(line, ',');
  };
  const auto zero = cells_of_next(), one = cells_of_next(), two = cells_of_next();
  EXPECT_EQ(zero[6] + zero[7] + zero[8] + zero[9], "0000");
  EXPECT_EQ(one[6], "0");
  EXPECT_EQ(one[7], "1") << "the tetrahedron of vertex 0";
  EXPECT_EQ(one[9], "0") << "kinematic vertices do not lag";
  // Three free vertices lag by 1/4. Vertex 0 is at (0, 1/4, 0), its skinned position at (1, 1, 1); half a
  // metre per unit.
  EXPECT_NEAR(std::stod(one[8]), 0.5 * std::sqrt((3 * 0.0625 + 2 + 0.5625) / 4.0), 1e-12);
  EXPECT_EQ(two[6], "1");
  EXPECT_EQ(two[7], "0");
  // Vertex 0 of the flesh is at (2, 2, 2): it contributes 12, each other vertex 1/4.
  EXPECT_NEAR(std::stod(two[8]), 0.5 * std::sqrt((3 * 0.25 + 12) / 4.0), 1e-12);
  const auto peaks = bake::peak_lags(folder / "", model);
  ASSERT_EQ(peaks.size(), 1u);
  EXPECT_EQ(peaks[0].layer, "fat");
  EXPECT_EQ(peaks[0].frame, 2u);
  EXPECT_EQ(peaks[0].lag, std::stod(two[8]));
}

TEST(Metrics, NamesWithCommasAreQuoted) {
  const TemporaryFolder folder;
  model::Model model = two_tetrahedra();
  model.probes[0].name = "left, \"upper\"";
  write_frames(bake::make_metrics_sink(), model, folder / "");
  const std::string text = read_text(folder / "metrics.csv");
  EXPECT_NE(text.find("\"left, \"\"upper\"\"_x\",\"left, \"\"upper\"\"_y\""), std::string::npos) << text;
}

// Each frame is one line: a resumed bake counts lines.
TEST(Metrics, AreOneLinePerFrame) {
  const TemporaryFolder folder;
  model::Model model = two_tetrahedra();
  model.probes[0].name = "=1+\n\x1b[31mtip";
  write_frames(bake::make_metrics_sink(), model, folder / "");
  const std::string text = read_text(folder / "metrics.csv");
  EXPECT_NE(text.find(",'=1+\\n\\x1b[31mtip_x,"), std::string::npos) << text;
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1 + 3) << text;
}

// Decimal comma and grouped digits, as in a German locale.
struct GermanNumbers final : std::numpunct<char> {
  char do_decimal_point() const override { return ','; }
  char do_thousands_sep() const override { return '.'; }
  std::string do_grouping() const override { return "\3"; }
};

TEST(Metrics, AreTheSameInEveryLocale) {
  const TemporaryFolder folder;
  const model::Model model = two_tetrahedra();
  write_frames(bake::make_metrics_sink(), model, folder / "");
  const std::string plain = read_text(folder / "metrics.csv");
  const std::string plain_obj = formats::rest_obj(model, formats::read_surface_objects(model, {}));
  const std::locale old = std::locale::global(std::locale(std::locale::classic(), new GermanNumbers));
  std::ostringstream control;
  control << 1234.5;
  write_frames(bake::make_metrics_sink(), model, folder / "");
  const std::string german_obj = formats::rest_obj(model, formats::read_surface_objects(model, {}));
  std::locale::global(old);
  EXPECT_EQ(control.str(), "1.234,5");
  EXPECT_EQ(read_text(folder / "metrics.csv"), plain);
  EXPECT_EQ(german_obj, plain_obj);
}

TEST(VtuSeries, HoldsTheMeshAndItsMotion) {
  const TemporaryFolder folder;
  const model::Model model = two_tetrahedra();
  write_frames(formats::format_named("vtu").make(), model, folder / "");
  for (std::uint64_t k = 0; k < 3; ++k) {
    VtkFile vtu = read_vtk(folder / ("vtu/frame_00000" + std::to_string(k) + ".vtu"));
    EXPECT_NE(vtu.xml.find("NumberOfPoints=\"5\" NumberOfCells=\"2\""), std::string::npos);
    const double s = 1.0 + 0.25 * static_cast<double>(k);
    ASSERT_EQ(vtu.arrays["position"].size(), 60u);
    for (std::size_t i = 0; i < 15; ++i) {
      const double rest = double{model.rest[i]};
      EXPECT_EQ(read_value<float>(vtu.arrays["position"], 4 * i),
                static_cast<float>(origin[i % 3] + 0.5 * s * rest));
      EXPECT_EQ(read_value<float>(vtu.arrays["displacement"], 4 * i),
                static_cast<float>(0.5 * (s - 1.0) * rest));
      EXPECT_EQ(read_value<float>(vtu.arrays["velocity"], 4 * i),
                static_cast<float>(0.5 * static_cast<double>(k) * rest));
    }
    EXPECT_EQ(vtu.names["layers"], (std::vector<std::string>{"fat", "bone"}));
    EXPECT_EQ(vtu.arrays["layer"], std::string("\0\0\0\0\1", 5));
    EXPECT_EQ(vtu.arrays["kinematic"], std::string("\0\0\0\0\1", 5));
    EXPECT_EQ(vtu.arrays["types"], std::string("\x0a\x0a"));
    for (std::size_t i = 0; i < 5; ++i)
      EXPECT_EQ(read_value<std::uint32_t>(vtu.arrays["source_vertex"], 4 * i), model.source_vertex[i]);
    for (std::size_t i = 0; i < 8; ++i)
      EXPECT_EQ(read_value<std::uint32_t>(vtu.arrays["connectivity"], 4 * i), model.tetrahedron[i]);
    EXPECT_EQ(read_value<std::int32_t>(vtu.arrays["offsets"], 0), 4);
    EXPECT_EQ(read_value<std::int32_t>(vtu.arrays["offsets"], 4), 8);
  }
  const std::string series = read_text(folder / "vtu/series.pvd");
  EXPECT_NE(series.find("timestep=\"1.5\" file=\"frame_000000.vtu\""), std::string::npos) << series;
  EXPECT_NE(series.find("timestep=\"1.75\" file=\"frame_000002.vtu\""), std::string::npos) << series;
  EXPECT_EQ(series.find("frame_000003"), std::string::npos) << series;
}

TEST(FrameFiles, Names) {
  EXPECT_EQ(formats::frame_file_name(7, "vtu"), "frame_000007.vtu");
  EXPECT_EQ(formats::frame_file_name(1234567, "obj"), "frame_1234567.obj");
  EXPECT_TRUE(formats::is_frame_file_name("frame_000007.vtu", "vtu"));
  EXPECT_TRUE(formats::is_frame_file_name("frame_1234567.obj", "obj"));
  for (const char* name : {"frame_7.vtu", "frame_00000a.vtu", "frame_000007.vtk", "xframe_000007.vtu",
                           "frame_000007.vtu.bak", "frame_000007vtu"})
    EXPECT_FALSE(formats::is_frame_file_name(name, "vtu")) << name;
}

TEST(FrameCache, GivesBackWhatWasWritten) {
  const TemporaryFolder folder;
  const model::Model model = two_tetrahedra();
  write_frames(bake::make_cache_sink(), model, folder / "");
  const bake::FrameCacheReader cache(folder / bake::cache_name);
  EXPECT_EQ(cache.header().vertex_count, 5u);
  EXPECT_EQ(cache.header().unit, 0.5);
  EXPECT_EQ(cache.header().fps, 8.0);
  EXPECT_EQ(cache.header().start, 1.5);
  EXPECT_EQ(cache.header().frames, 2u);
  EXPECT_EQ(cache.header().rest_origin, model.rest_origin);
  ASSERT_EQ(cache.frame_count(), 3u);
  for (const std::uint64_t k : {2u, 0u, 1u}) {
    const model::Frame frame = cache.read(k), expected = stretched(model, k);
    EXPECT_EQ(frame.index, k);
    EXPECT_EQ(frame.origin, origin);
    EXPECT_EQ(frame.positions, expected.positions);
  }
  EXPECT_THROW(cache.read(3), BakeError);
}

// The documented layout, decoded by hand.
TEST(FrameCache, HasTheDocumentedLayout) {
  const TemporaryFolder folder;
  write_frames(bake::make_cache_sink(), two_tetrahedra(), folder / "");
  const std::string bytes = read_text(folder / bake::cache_name);
  EXPECT_EQ(bytes.substr(0, 8), "FASCICLE");
  EXPECT_EQ(read_value<std::uint32_t>(bytes, 8), 1u);
  EXPECT_EQ(read_value<std::uint32_t>(bytes, 12), 104u);
  EXPECT_EQ(read_value<std::uint32_t>(bytes, 16), 5u);
  const auto record = read_value<std::uint64_t>(bytes, 88);
  EXPECT_EQ(record, 32u + 64 + 8);  // 60 bytes of positions and 4 of padding
  ASSERT_EQ(bytes.size(), 104 + 3 * record);
  EXPECT_EQ(read_value<std::uint64_t>(bytes, 104 + 2 * record), 2u);
  EXPECT_EQ(read_value<double>(bytes, 104 + 2 * record + 24), 4.0);
  EXPECT_EQ(read_value<float>(bytes, 104 + 2 * record + 32 + 12), 1.5f);  // x of vertex 1 stretched by 1.5
}

TEST(FrameCache, DropsWhatIsNotWholeAtTheEnd) {
  const TemporaryFolder folder;
  write_frames(bake::make_cache_sink(), two_tetrahedra(), folder / "");
  const fs::path path = folder / bake::cache_name;
  const std::string whole = read_text(path);
  const std::size_t record = (whole.size() - 104) / 3;
  // Truncated at any byte.
  for (std::size_t length = 104; length <= whole.size(); ++length) {
    write_text(path, whole.substr(0, length));
    EXPECT_EQ(bake::FrameCacheReader(path).frame_count(), (length - 104) / record);
  }
  // The right length, but with a wrong bit in the last record, or with zeros in place of the last two.
  for (std::size_t byte = 104 + 2 * record; byte < whole.size(); ++byte) {
    std::string damaged = whole;
    damaged[byte] = static_cast<char>(damaged[byte] ^ (1 << byte % 8));
    write_text(path, damaged);
    EXPECT_EQ(bake::FrameCacheReader(path).frame_count(), 2u) << "byte " << byte;
  }
  std::string zeros = whole;
  std::fill(zeros.begin() + static_cast<std::ptrdiff_t>(104 + record), zeros.end(), '\0');
  write_text(path, zeros);
  EXPECT_EQ(bake::FrameCacheReader(path).frame_count(), 1u);
}

// A limit on file size stands in for a full disk.
TEST(FrameCache, AFullDiskLeavesWholeFrames) {
  const TemporaryFolder folder;
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{104 + 2 * 104 + 50, 104 + 2 * 104 + 50};  // header, two records and part of a third
    ::setrlimit(RLIMIT_FSIZE, &limit);
    try {
      write_frames(bake::make_cache_sink(), two_tetrahedra(), folder / "");
    } catch (const std::system_error& error) {
      ::_exit(error.code() == std::errc::file_too_large ? 0 : 2);
    }
    ::_exit(1);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
  EXPECT_EQ(fs::file_size(folder / bake::cache_name), 104u + 2 * 104);
}

TEST(FrameCache, RefusesWhatIsDamagedOrForeign) {
  const TemporaryFolder folder;
  write_frames(bake::make_cache_sink(), two_tetrahedra(), folder / "");
  const fs::path path = folder / bake::cache_name;
  const std::string whole = read_text(path);
  for (std::size_t byte = 0; byte < 104; ++byte) {
    std::string damaged = whole;
    damaged[byte] = static_cast<char>(damaged[byte] ^ 1);
    write_text(path, damaged);
    EXPECT_THROW(bake::FrameCacheReader{path}, BakeError) << "byte " << byte;
  }
  for (const std::size_t length : {0u, 7u, 8u, 103u}) {
    write_text(path, whole.substr(0, length));
    EXPECT_THROW(bake::FrameCacheReader{path}, BakeError) << "length " << length;
  }
  // Damage to a middle frame leaves the others readable.
  const std::size_t record = (whole.size() - 104) / 3;
  std::string damaged = whole;
  damaged[104 + record + 40] = static_cast<char>(damaged[104 + record + 40] ^ 1);
  write_text(path, damaged);
  const bake::FrameCacheReader cache(path);
  EXPECT_EQ(cache.frame_count(), 3u);
  EXPECT_THROW(cache.read(1), BakeError);
  EXPECT_EQ(cache.read(2).index, 2u);
  EXPECT_THROW(bake::FrameCacheReader{folder / "absent"}, BakeError);
}

TEST(Formats, Names) {
  EXPECT_EQ(bake::format_names(),
            (std::vector<std::string>{"abc", "glb", "mdd", "obj", "pc2", "usda", "vtp", "vtu"}));
}

// The script's table and blender_loads() agree.
TEST(BlenderScript, LoadsTheFilesItIsSaidToLoad) {
  const std::string script = formats::blender_script({.fps = 24.0, .frames = 2, .first_number = 0});
  std::size_t loaded = 0;
  for (const formats::Format& format : formats::named_formats()) {
    const bool has_row =
        script.find("    '" + format.name + "': ('" + format.file + "', ") != std::string::npos;
    EXPECT_EQ(formats::blender_loads("out/" + format.file), has_row) << format.name;
    loaded += has_row ? 1 : 0;
  }
  EXPECT_EQ(loaded, 5u);
  EXPECT_FALSE(formats::blender_loads("out/obj/"));
  // A character's source file holds no motion to load.
  EXPECT_FALSE(formats::blender_loads("out/character.glb"));
}

}  // namespace
}  // namespace fascicle::tests
