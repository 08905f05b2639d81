// MDD, OBJ, USD and Alembic files, read back by readers that share no code with the writers.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "host/bake/bake.h"
#include "host/bake/outputs.h"
#include "host/formats/formats.h"
#include "host/formats/murmur3.h"
#include "host/formats/surface.h"
#include "host/formats/surface_normals.h"
#include "tests/bake/fake_solver.h"
#include "tests/formats/ogawa_reader.h"
#include "tests/formats/sink_frames.h"
#include "tests/support/readers.h"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
// Both sanitizer runtimes define it, but its header is clang's, which g++ may lack.
extern "C" std::size_t __sanitizer_get_current_allocated_bytes();
#endif

namespace fascicle::tests {
namespace {

namespace fs = std::filesystem;

// Render vertices of the folded sheet in frame k; exact in float.
std::vector<float> sheet_points(std::uint64_t k) {
  const double s = 0.5 * (1.0 + 0.25 * static_cast<double>(k));
  std::vector<float> points;
  for (const std::array<double, 3>& at :
       std::vector<std::array<double, 3>>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0}, {1, 0, 0}, {0, 0, 2}})
    for (std::size_t axis = 0; axis < 3; ++axis)
      points.push_back(static_cast<float>(sink_origin[axis] + s * at[axis]));
  return points;
}

// Worked out by hand: face normals (0, 0, 1) of area 1 and (0, 1, 0) of area 2; on the seam their sum.
std::vector<float> sheet_normals() {
  const auto part = [](double x) { return static_cast<float>(x / std::sqrt(5.0)); };
  std::vector<float> normals;
  for (int copy = 0; copy < 2; ++copy) {
    for (int seam = 0; seam < 2; ++seam)
      for (const float value : {0.0f, part(2), part(1)}) normals.push_back(value);
    for (const float value : {0.0f, copy == 0 ? 0.0f : 1.0f, copy == 0 ? 1.0f : 0.0f})
      normals.push_back(value);
  }
  return normals;
}

const std::vector<double> frame_times{0.0, 0.125, 0.25};

TEST(SurfaceNormals, AreSmoothOverSeams) {
  const model::Model model = folded_sheet();
  const std::vector<float> normals = formats::SurfaceNormals(model).of(formats::embed(model, model.rest));
  const std::vector<float> expected = sheet_normals();
  ASSERT_EQ(normals.size(), expected.size());
  // Both round a double to float once; the double's last digits may differ.
  for (std::size_t i = 0; i < normals.size(); ++i) EXPECT_FLOAT_EQ(normals[i], expected[i]) << i;
}

TEST(SurfaceNormals, OfNothingPointUp) {
  model::Model model = folded_sheet();
  const std::vector<float> flat(18, 2.0f);
  const std::vector<float> normals = formats::SurfaceNormals(model).of(flat);
  for (std::size_t i = 0; i < normals.size(); ++i) EXPECT_EQ(normals[i], i % 3 == 1 ? 1.0f : 0.0f);
}

TEST(Mdd, IsBigEndianWithTimesInSeconds) {
  const TemporaryFolder folder;
  const model::Model model = folded_sheet();
  write_frames(formats::format_named("mdd").make(), model, folder / "");
  const std::string bytes = read_text(folder / "surface.mdd");
  EXPECT_EQ(bytes.size(), formats::format_named("mdd").bytes(model, 3));
  ASSERT_EQ(bytes.size(), 8u + 4 * 3 + 3 * 6 * 12);
  std::size_t at = 0;
  const auto number = [&] {
    std::uint32_t value = 0;
    for (int k = 0; k < 4; ++k) value = value << 8 | static_cast<unsigned char>(bytes[at++]);
    return value;
  };
  EXPECT_EQ(number(), 3u);
  EXPECT_EQ(number(), 6u);
  for (const double time : frame_times) EXPECT_EQ(std::bit_cast<float>(number()), static_cast<float>(time));
  for (std::uint64_t k = 0; k < 3; ++k)
    for (const float expected : sheet_points(k)) EXPECT_EQ(std::bit_cast<float>(number()), expected);
}

TEST(ObjSequence, HasTheMeshOfEachFrame) {
  const TemporaryFolder folder;
  write_frames(formats::format_named("obj").make(), folded_sheet(), folder / "");
  for (std::uint64_t k = 0; k < 3; ++k) {
    std::istringstream in(read_text(folder / ("obj/frame_00000" + std::to_string(k) + ".obj")));
    std::vector<float> points, normals;
    std::vector<std::string> faces;
    std::string line;
    std::getline(in, line);
    EXPECT_EQ(line, "# fascicle: frame " + std::to_string(k) + ", " +
                        (k == 0   ? "0"
                         : k == 1 ? "0.125"
                                  : "0.25") +
                        " s at 8 frames a second, metres, Y up");
    while (std::getline(in, line)) {
      std::istringstream words(line);
      std::string kind;
      words >> kind;
      if (kind == "f") faces.push_back(line);
      if (kind != "v" && kind != "vn") continue;
      for (int axis = 0; axis < 3; ++axis) {
        float value = 0.0f;
        EXPECT_TRUE(words >> value) << line;
        (kind == "v" ? points : normals).push_back(value);
      }
    }
    EXPECT_EQ(points, sheet_points(k));
    ASSERT_EQ(normals.size(), 18u);
    for (std::size_t i = 0; i < normals.size(); ++i) EXPECT_FLOAT_EQ(normals[i], sheet_normals()[i]);
    EXPECT_EQ(faces, (std::vector<std::string>{"f 1//1 2//2 3//3", "f 4//4 6//6 5//5"}));
  }
  EXPECT_FALSE(fs::exists(folder / "obj/frame_000003.obj"));
}

// Test vectors published with the algorithm's reference implementations, seed 0.
TEST(Murmur3, KnownDigests) {
  using Digest = std::array<std::uint64_t, 2>;
  EXPECT_EQ(formats::murmur3_x64_128(""), (Digest{0, 0}));
  EXPECT_EQ(formats::murmur3_x64_128("hello"), (Digest{0xcbd8a7b341bd9b02, 0x5b1e906a48ae1d19}));
  EXPECT_EQ(formats::murmur3_x64_128("hello, world"), (Digest{0x342fac623a5ebc8e, 0x4cdcbc079642414d}));
  EXPECT_EQ(formats::murmur3_x64_128("19 Jan 2038 at 3:14:07 AM"),
            (Digest{0xb89e5988b737affc, 0x664fc2950231b2cb}));
  EXPECT_EQ(formats::murmur3_x64_128("The quick brown fox jumps over the lazy dog."),
            (Digest{0xcd99481f9ee902c9, 0x695da1a38987b6e7}));
}

template <class T>
std::vector<T> values_of(const OgawaSample& sample) {
  std::vector<T> values(sample.bytes.size() / sizeof(T));
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = read_value<T>(sample.bytes, i * sizeof(T));
  return values;
}

TEST(Alembic, IsAPolyMeshWithEverySample) {
  const TemporaryFolder folder;
  const model::Model model = folded_sheet();
  write_frames(formats::format_named("abc").make(), model, folder / "");
  const std::string file = read_text(folder / "surface.abc");
  // The estimate only approximates the headers.
  EXPECT_NEAR(static_cast<double>(file.size()),
              static_cast<double>(formats::format_named("abc").bytes(model, 3)), 400);
  const OgawaArchive archive = read_ogawa(file);
  EXPECT_EQ(archive.form_version, 0);
  EXPECT_GE(archive.alembic_version, 9999);  // the library refuses lower versions
  EXPECT_NE(archive.metadata.find("_ai_Application=fascicle"), std::string::npos);
  EXPECT_NE(archive.metadata.find("_ai_DCC_FPS=8;"), std::string::npos);
  ASSERT_EQ(archive.samplings.size(), 2u);
  EXPECT_EQ(archive.samplings[1].most_samples, 3u);
  EXPECT_EQ(archive.samplings[1].period, 0.125);
  EXPECT_EQ(archive.samplings[1].times, std::vector<double>{0.0});

  ASSERT_EQ(archive.top.children.size(), 1u);
  const OgawaObject& surface = archive.top.children[0];
  EXPECT_EQ(surface.name, "surface");
  EXPECT_EQ(surface.metadata,
            "schema=AbcGeom_PolyMesh_v1;schemaBaseType=AbcGeom_GeomBase_v1;"
            "schemaObjTitle=AbcGeom_PolyMesh_v1:.geom");
  EXPECT_TRUE(surface.children.empty());
  const OgawaProperty& geometry = surface.properties.property(".geom");
  EXPECT_EQ(geometry.kind, OgawaKind::compound);
  EXPECT_EQ(geometry.metadata, "schema=AbcGeom_PolyMesh_v1;schemaBaseType=AbcGeom_GeomBase_v1");
  const OgawaProperty& points = geometry.property("P");
  const OgawaProperty& normals = geometry.property("N");
  const OgawaProperty& box = geometry.property(".selfBnds");
  const OgawaProperty& indices = geometry.property(".faceIndices");
  const OgawaProperty& counts = geometry.property(".faceCounts");
  for (const OgawaProperty* each : {&points, &normals, &box, &indices, &counts}) {
    EXPECT_EQ(each->samples, 3u) << each->name;
    EXPECT_EQ(each->sampling, 1u) << each->name;
    for (const OgawaSample& sample : each->stored)
      EXPECT_EQ(sample.digest, formats::murmur3_x64_128(sample.bytes)) << each->name;
  }
  for (const OgawaProperty* each : {&points, &normals}) {
    EXPECT_EQ(each->kind, OgawaKind::array);
    EXPECT_EQ(each->pod, 10u);
    EXPECT_EQ(each->extent, 3u);
    EXPECT_FALSE(each->one_point);
  }
  EXPECT_EQ(points.metadata, "geoScope=vtx;interpretation=point");
  EXPECT_NE(normals.metadata.find("geoScope=vtx;interpretation=normal;isGeomParam=true"), std::string::npos);
  EXPECT_EQ(box.kind, OgawaKind::scalar);
  EXPECT_EQ(box.pod, 11u);
  EXPECT_EQ(box.extent, 6u);
  for (std::uint32_t k = 0; k < 3; ++k) {
    const std::vector<float> expected = sheet_points(k);
    EXPECT_EQ(values_of<float>(points.at(k)), expected);
    const std::vector<float> found = values_of<float>(normals.at(k));
    ASSERT_EQ(found.size(), 18u);
    for (std::size_t i = 0; i < 18; ++i) EXPECT_FLOAT_EQ(found[i], sheet_normals()[i]);
    EXPECT_EQ(values_of<double>(box.at(k)), (std::vector<double>{expected[0], expected[1], expected[2],
                                                                 expected[3], expected[7], expected[17]}));
    // Alembic winds faces clockwise, seen from outside.
    EXPECT_EQ(values_of<std::int32_t>(indices.at(k)), (std::vector<std::int32_t>{2, 1, 0, 4, 5, 3}));
    EXPECT_EQ(values_of<std::int32_t>(counts.at(k)), (std::vector<std::int32_t>{3, 3}));
  }
}

// Readers detect a single still frame by the property's header, and sizes by their byte length.
TEST(Alembic, OneFrameAndManyFrames) {
  const model::Model model = two_tetrahedra();
  for (const std::uint64_t frames : {0u, 299u}) {
    const TemporaryFolder folder;
    const model::Frame frame = stretched(model, 0);
    const auto sink = formats::format_named("abc").make();
    sink->begin({.model = &model,
                 .folder = folder / "",
                 .scene_name = "s",
                 .fps = 24.0,
                 .start = 0.0,
                 .frames = frames,
                 .first = 0,
                 .initial = &frame});
    for (std::uint64_t k = 0; k <= frames; ++k) sink->write(frame);
    sink->finish();
    const OgawaArchive archive = read_ogawa(read_text(folder / "surface.abc"));
    const OgawaProperty& geometry = archive.top.children.at(0).properties.property(".geom");
    EXPECT_EQ(geometry.property("P").samples, frames + 1);
    EXPECT_EQ(geometry.property("P").stored.size(), frames + 1);
    EXPECT_TRUE(geometry.property(".faceCounts").one_point);  // a single triangle
    EXPECT_FALSE(geometry.property(".faceIndices").one_point);
  }
}

TEST(Usd, IsReadByOtherPrograms) {
  FASCICLE_NEEDS_NODE_READERS;
  const TemporaryFolder folder;
  write_frames(formats::format_named("usda").make(), folded_sheet(), folder / "");
  const nlohmann::json usd = nlohmann::json::parse(read_by_node("read_usda.mjs", folder / "surface.usda"));
  EXPECT_EQ(usd["stage"]["upAxis"], "Y");
  EXPECT_EQ(usd["stage"]["metersPerUnit"], 1);
  EXPECT_EQ(usd["stage"]["timeCodesPerSecond"], 8);
  EXPECT_EQ(usd["stage"]["framesPerSecond"], 8);
  EXPECT_EQ(usd["stage"]["defaultPrim"], "body");
  const std::string layer = usd["layer"];
  EXPECT_NE(layer.find("startTimeCode = 0\n"), std::string::npos) << layer;
  EXPECT_NE(layer.find("endTimeCode = 2\n"), std::string::npos) << layer;
  EXPECT_NE(layer.find("double clipStartSeconds = 1.5\n"), std::string::npos) << layer;
  EXPECT_EQ(usd["meshes"], 1);
  const auto surface = [&](const std::string& attribute) {
    return usd["specs"]["/body/surface." + attribute];
  };
  EXPECT_EQ(surface("points")["typeName"], "point3f[]");
  EXPECT_EQ(surface("normals")["typeName"], "normal3f[]");
  EXPECT_EQ(surface("extent")["typeName"], "float3[]");
  EXPECT_EQ(surface("faceVertexCounts")["default"], (std::vector<int>{3, 3}));
  EXPECT_EQ(surface("faceVertexIndices")["default"], (std::vector<int>{0, 1, 2, 3, 5, 4}));
  EXPECT_EQ(usd["first_points"].get<std::vector<float>>(), sheet_points(0));
  for (const char* attribute : {"points", "normals", "extent"})
    EXPECT_EQ(surface(attribute)["timeSamples"]["times"], (std::vector<int>{0, 1, 2})) << attribute;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto at = [&](const char* attribute) {
      return surface(attribute)["timeSamples"]["values"][k].get<std::vector<float>>();
    };
    const std::vector<float> expected = sheet_points(k);
    EXPECT_EQ(at("points"), expected);
    const std::vector<float> normals = at("normals");
    ASSERT_EQ(normals.size(), 18u);
    for (std::size_t i = 0; i < 18; ++i) EXPECT_FLOAT_EQ(normals[i], sheet_normals()[i]);
    const std::vector<float> box{expected[0], expected[1], expected[2],
                                 expected[3], expected[7], expected[17]};
    EXPECT_EQ(at("extent"), box);
    EXPECT_EQ(usd["specs"]["/body.extentsHint"]["timeSamples"]["values"][k].get<std::vector<float>>(), box);
  }
}

TEST(SurfaceFormats, RefuseABodyWithoutSurface) {
  model::Model model = two_tetrahedra();
  model.surface_vertex.clear();
  model.surface_weight.clear();
  model.surface_triangle.clear();
  for (const formats::Format& format : bake::all_formats()) {
    if (format.name.empty() || format.name == "vtu") continue;
    const TemporaryFolder folder;
    EXPECT_THROW(write_frames(format.make(), model, folder / ""), bake::BakeError) << format.name;
  }
}

// Writes `frames` frames of a large surface, with a callback after each.
template <class AfterFrame>
void write_large_frames(const formats::Format& format, const model::Model& model, std::uint64_t frames,
                        const TemporaryFolder& folder, const AfterFrame& after_frame) {
  const model::Frame frame = stretched(model, 1);
  const auto sink = format.make();
  sink->begin({.model = &model,
               .folder = folder / "",
               .scene_name = "s",
               .fps = 24.0,
               .start = 0.0,
               .frames = frames,
               .first = 0,
               .initial = &frame});
  for (std::uint64_t k = 0; k <= frames; ++k) {
    model::Frame current = frame;
    current.index = k;
    sink->write(current);
    after_frame();
  }
  sink->finish();
}

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)

// Sanitizers quarantine freed memory, so the process grows in any case; but they know how much is allocated.
// Returns the most bytes allocated after any frame.
std::uint64_t peak_memory(const formats::Format& format, const model::Model& model, std::uint64_t frames) {
  const TemporaryFolder folder;
  std::size_t most = 0;
  write_large_frames(format, model, frames, folder,
                     [&] { most = std::max(most, __sanitizer_get_current_allocated_bytes()); });
  return most;
}

#else

// Peak memory in bytes of a process that writes the frames.
std::uint64_t peak_memory(const formats::Format& format, const model::Model& model, std::uint64_t frames) {
  const TemporaryFolder folder;
  const pid_t child = ::fork();
  if (child == 0) {
    write_large_frames(format, model, frames, folder, [] {});
    ::_exit(0);
  }
  int status = -1;
  struct rusage usage {};
  EXPECT_EQ(::wait4(child, &status, 0, &usage), child);
  EXPECT_EQ(status, 0) << format.name;
  return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
}

#endif

TEST(SurfaceFormats, KeepNoFrameInMemory) {
  constexpr std::uint32_t vertices = 12000;
  model::Model model = two_tetrahedra();
  model.surface_vertex.clear();
  model.surface_weight.clear();
  model.surface_triangle.clear();
  for (std::uint32_t i = 0; i < vertices; ++i) {
    const float x = static_cast<float>(i) / vertices;
    for (const std::uint32_t vertex : {0u, 1u, 2u, 3u}) model.surface_vertex.push_back(vertex);
    for (const float weight : {1.0f - x, x * x, x - x * x, 0.0f}) model.surface_weight.push_back(weight);
    if (i >= 2)
      for (const std::uint32_t corner : {i - 2, i - 1, i}) model.surface_triangle.push_back(corner);
  }
  constexpr std::uint64_t few = 4, many = 64;
  for (const formats::Format& format : bake::all_formats()) {
    if (format.name.empty() || format.name == "vtu") continue;
    const std::uint64_t low = peak_memory(format, model, few), high = peak_memory(format, model, many);
    // Keeping just the positions would take 12 more bytes per vertex and frame, 8 MiB. The actual state per
    // frame is under a kilobyte, and rounding by the allocator is well under the rest.
    EXPECT_LT(high, low + (std::uint64_t{12} * vertices * (many - few)) / 3) << format.name;
  }
}

}  // namespace
}  // namespace fascicle::tests
