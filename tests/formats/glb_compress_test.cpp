// surface.glb quantised and compressed: our reader, an independent viewer and three.js show what the plain
// file shows.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "host/bake/export.h"
#include "host/bake/read_frame_cache.h"
#include "host/base/part_file.h"
#include "host/formats/formats.h"
#include "host/formats/gltf_writer.h"
#include "host/formats/surface.h"
#include "host/gltf/gltf_rig.h"
#include "tests/bake/fake_solver.h"
#include "tests/formats/dressed_model.h"
#include "tests/formats/jointed_body.h"
#include "tests/gltf/gltf_viewer.h"
#include "tests/support/readers.h"

namespace fascicle::tests {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;
using nlohmann::json;

constexpr std::uint64_t jointed_frames = 6;
// Floats of about 10 m in the file, in inverse bind matrices and in their products.
constexpr double float_rounding = 1e-5;

fs::path baked_jointed(const TemporaryFolder& folder, const char* name, std::optional<double> compress) {
  bake::BakeOptions options = options_for(folder / name);
  options.formats = {"glb"};
  options.glb.compress = compress;
  bake_jointed(options, jointed_frames);
  return folder / name;
}

// The file decompressed by our reader.
GltfViewer unpacked(const fs::path& glb) {
  std::vector<std::string> missing;
  const fs::path plain = glb.parent_path() / "unpacked.glb";
  base::write_whole(plain, formats::glb_text(gltf::pack_gltf(glb, missing)));
  return GltfViewer(plain);
}

double furthest_apart(const std::vector<Vector3d>& a, const std::vector<Vector3d>& b) {
  EXPECT_EQ(a.size(), b.size());
  double most = 0.0;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) most = std::max(most, (a[i] - b[i]).norm());
  return most;
}

TEST(GlbCompress, ShowsThePlainFileWithinItsBound) {
  const TemporaryFolder folder;
  const GltfViewer plain(baked_jointed(folder, "plain", {}) / "surface.glb");
  for (const double bound : {0.05, 0.002, 0.0001}) {
    const std::string name = "m" + std::to_string(bound);
    const fs::path out = baked_jointed(folder, name.c_str(), bound);
    const GltfViewer small = unpacked(out / "surface.glb");
    double most = 0.0;
    for (std::uint64_t k = 0; k <= jointed_frames; ++k) {
      const auto time = static_cast<double>(static_cast<float>(static_cast<double>(k) / 24.0));
      most = std::max(most, furthest_apart(plain.shown(0, time), small.shown(0, time)));
    }
    const json extras = read_glb(out / "surface.glb").document["extras"]["fascicle"];
    EXPECT_LE(extras["quantisation_error"], bound);
    EXPECT_LE(most, bound + float_rounding);
    EXPECT_NEAR(most, extras["quantisation_error"].get<double>(), float_rounding);
    // Steps are powers of two, so they may be half as large as allowed, and a triangle reaches a quarter of
    // the worst case.
    EXPECT_GT(most, bound / 16.0);
  }
}

TEST(GlbCompress, SaysWhatAReaderMustKnow) {
  const TemporaryFolder folder;
  const fs::path out = baked_jointed(folder, "out", 1e-4);
  const GlbChunks glb = read_glb(out / "surface.glb");
  for (const char* list : {"extensionsUsed", "extensionsRequired"})
    EXPECT_EQ(glb.document[list],
              (std::vector<std::string>{"EXT_meshopt_compression", "KHR_mesh_quantization"}));
  const json& primitive = glb.document["meshes"][0]["primitives"][0];
  const auto type_of = [&](const json& number) {
    return glb.document["accessors"][number.get<std::size_t>()]["componentType"].get<int>();
  };
  EXPECT_EQ(type_of(primitive["attributes"]["POSITION"]), 5122);
  EXPECT_EQ(type_of(primitive["attributes"]["NORMAL"]), 5120);
  for (const json& view : glb.document["bufferViews"]) {
    if (!view.contains("extensions")) continue;
    const json& how = view["extensions"]["EXT_meshopt_compression"];
    EXPECT_EQ(view["byteLength"], how["count"].get<std::size_t>() * how["byteStride"].get<std::size_t>());
    // The codec version that the extension allows for each mode.
    const auto head = static_cast<unsigned char>(glb.binary.at(how["byteOffset"].get<std::size_t>()));
    EXPECT_EQ(head, how["mode"] == "ATTRIBUTES" ? 0xa0 : how["mode"] == "TRIANGLES" ? 0xe1 : 0xd1);
  }
  const json manifest = json::parse(read_text(out / "manifest.json"));
  EXPECT_EQ(manifest["output"]["glb_compress"], 1e-4);
}

TEST(GlbCompress, ABoundTooFineForSixteenBitsIsRefused) {
  const TemporaryFolder folder;
  try {
    baked_jointed(folder, "out", 1e-9);
    FAIL() << "was written";
  } catch (const bake::BakeError& error) {
    const std::string what = error.what();
    const std::size_t at = what.find("give at least ");
    ASSERT_NE(at, std::string::npos) << what;
    // The bound it names works.
    baked_jointed(folder, "again", std::stod(what.substr(at + 14)));
  }
}

TEST(GlbCompress, ExportsToTheBytesOfTheBake) {
  const TemporaryFolder folder;
  const fs::path out = baked_jointed(folder, "out", 1e-4);
  bake::export_bake(
      {.bake = out, .folder = folder / "exported", .formats = {"glb"}, .glb = {.compress = 1e-4}});
  EXPECT_EQ(read_text(folder / "exported/surface.glb"), read_text(out / "surface.glb"));
}

// Frames of a large sheet without a skeleton: its node undoes the quantisation, and targets are large moves.
class Sheet {
 public:
  Sheet() : model_(two_tetrahedra()) {
    constexpr std::uint32_t vertices = 3000;
    model_.surface_vertex.clear();
    model_.surface_weight.clear();
    model_.surface_triangle.clear();
    for (std::uint32_t i = 0; i < vertices; ++i) {
      const float x = static_cast<float>(i / 2) * 2.0f / vertices, y = i % 2 == 0 ? 0.0f : 0.1f;
      for (const std::uint32_t vertex : {0u, 1u, 2u, 3u}) model_.surface_vertex.push_back(vertex);
      for (const float weight : {1.0f - x - y, x, y, 0.0f}) model_.surface_weight.push_back(weight);
      if (i >= 2)
        for (const std::uint32_t corner : {i - 2, i - 1 + i % 2, i - i % 2})
          model_.surface_triangle.push_back(corner);
    }
  }
  void write(const fs::path& folder, std::optional<double> compress) const {
    fs::create_directories(folder);
    const model::Frame initial = turned(model_, 0);
    const auto sink = formats::format_named("glb").make();
    sink->begin({.model = &model_,
                 .folder = folder,
                 .scene_name = "s",
                 .fps = 8.0,
                 .start = 0.0,
                 .frames = 3,
                 .first = 0,
                 .initial = &initial,
                 .glb = {.compress = compress}});
    for (std::uint64_t k = 0; k < 4; ++k) sink->write(turned(model_, k));
    sink->finish();
  }

 private:
  model::Model model_;
};

TEST(GlbCompress, ABodyWithoutSkeletonIsPlacedByItsNode) {
  const TemporaryFolder folder;
  const Sheet sheet;
  sheet.write(folder / "plain", {});
  sheet.write(folder / "small", 1e-3);
  const GltfViewer plain(folder / "plain/surface.glb"), small = unpacked(folder / "small/surface.glb");
  for (std::uint64_t k = 0; k < 4; ++k) {
    const double time = static_cast<double>(k) / 8.0;
    EXPECT_LE(furthest_apart(plain.shown(0, time), small.shown(0, time)), 1e-3 + float_rounding) << k;
  }
  // A plain target has 28 bytes per vertex, more than twice what is needed for neighbours along a strip.
  EXPECT_LT(fs::file_size(folder / "small/surface.glb"), fs::file_size(folder / "plain/surface.glb") / 2);
}

TEST(GlbCompress, SeveralObjectsOfOneSkinShareAGrid) {
  const TemporaryFolder folder;
  const auto write = [&](const char* name, std::optional<double> compress) {
    fs::create_directories(folder / name);
    write_dressed_frames(formats::format_named("glb").make(), folder / name, {.glb = {.compress = compress}});
    return folder / name / "surface.glb";
  };
  const GltfViewer plain(write("plain", {})), small = unpacked(write("small", 1e-3));
  for (std::uint64_t k = 0; k < 4; ++k) {
    const double time = static_cast<double>(k) / 8.0;
    EXPECT_LE(furthest_apart(plain.shown(0, time), small.shown(0, time)), 1e-3 + float_rounding) << k;
  }
  // Only the replaced floats are gone: the image is still there.
  EXPECT_NE(read_glb(folder / "small/surface.glb").binary.find("no picture"), std::string::npos);
}

// The dressed body with `change` applied to its file, plain and compressed; both in FOLDER.
struct PlainAndSmall {
  GltfViewer plain, small;
};
PlainAndSmall changed_dressed(const TemporaryFolder& folder,
                              const std::function<void(json&, std::string&)>& change) {
  const auto write = [&](const char* name, std::optional<double> compress) {
    fs::create_directories(folder / name);
    const fs::path file = folder / name / "character.glb";
    write_dressed(file);
    GlbChunks glb = read_glb(file);
    change(glb.document, glb.binary);
    base::write_whole(file, formats::glb_text({.json = glb.document, .binary = glb.binary}));
    write_turned_frames(formats::format_named("glb").make(), folder / name, {.glb = {.compress = compress}});
    return folder / name / "surface.glb";
  };
  return {GltfViewer(write("plain", {})), unpacked(write("small", 1e-3))};
}

void expect_same_shown(const PlainAndSmall& files) {
  for (std::uint64_t k = 0; k < 4; ++k) {
    const double time = static_cast<double>(k) / 8.0;
    EXPECT_LE(furthest_apart(files.plain.shown(0, time), files.small.shown(0, time)), 1e-3 + float_rounding)
        << k;
  }
}

int position_type(const GltfViewer& file, std::size_t node) {
  const json& d = file.document;
  const std::size_t mesh = d["nodes"][node]["mesh"];
  const std::size_t number = d["meshes"][mesh]["primitives"][0]["attributes"]["POSITION"];
  return d["accessors"][number]["componentType"];
}

// Makes the first object a child of the joint, without a skin.
void hang_first_object(json& document) {
  json& nodes = document["nodes"];
  nodes[0]["children"] = {1};
  document["scenes"][0]["nodes"] = {0, 2};
  nodes[1].erase("skin");
  // Column-major: raw (x, -z, y) to (x, y, z).
  nodes[1]["matrix"] = {1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1};
}

TEST(GlbCompress, AHungObjectIsPlacedByItsNode) {
  const TemporaryFolder folder;
  const PlainAndSmall files =
      changed_dressed(folder, [](json& document, std::string&) { hang_first_object(document); });
  expect_same_shown(files);
  EXPECT_EQ(position_type(files.small, 1), 5122);
}

TEST(GlbCompress, AMeshThatALeftOutNodeShowsTooKeepsItsFloats) {
  const TemporaryFolder folder;
  const PlainAndSmall files = changed_dressed(folder, [](json& document, std::string&) {
    hang_first_object(document);
    document["nodes"].push_back({{"mesh", 0}, {"translation", {5, 0, 0}}});
    document["scenes"][0]["nodes"].push_back(3);
  });
  expect_same_shown(files);
  EXPECT_EQ(position_type(files.small, 1), 5126);
}

TEST(GlbCompress, AMeshWithLinesKeepsItsFloats) {
  const TemporaryFolder folder;
  expect_same_shown(changed_dressed(folder, [](json& document, std::string&) {
    hang_first_object(document);
    json& primitives = document["meshes"][0]["primitives"];
    json lines = primitives[0];
    lines["mode"] = 3;
    primitives.push_back(lines);
  }));
}

TEST(GlbCompress, AMeshOfASkinOutsideTheSceneKeepsItsFloats) {
  const TemporaryFolder folder;
  const PlainAndSmall files = changed_dressed(folder, [](json& document, std::string&) {
    document["skins"].push_back(json(document["skins"][0]));
    document["nodes"].push_back({{"mesh", 1}, {"skin", 1}});
  });
  expect_same_shown(files);
  EXPECT_EQ(position_type(files.small, 2), 5126);
}

// Random normals: 9 in 3 primitives.
void strew_normals(const json& document, std::string& binary, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> value;
  for (const json& mesh : document["meshes"])
    for (const json& primitive : mesh["primitives"]) {
      const json& accessor = document["accessors"][primitive["attributes"]["NORMAL"].get<std::size_t>()];
      const json& view = document["bufferViews"][accessor["bufferView"].get<std::size_t>()];
      std::size_t at = view.value("byteOffset", std::size_t{0});
      for (std::size_t i = 0; i < accessor["count"].get<std::size_t>(); ++i, at += 12) {
        const Eigen::Vector3f normal =
            Vector3d(value(random), value(random), value(random)).normalized().cast<float>();
        std::memcpy(binary.data() + at, normal.data(), 12);
      }
    }
}

TEST(GlbCompress, NormalsStandWithinHalfADegree) {
  // Three components, each rounded by at most half of 1/127; or by half of 1/256 in targets whose change
  // exceeds the range of a byte.
  const double angle = std::asin(std::sqrt(3.0) * 0.5 / 127.0);
  EXPECT_LT(angle, 0.5 / 180.0 * 3.14159);
  std::size_t far = 0;
  for (unsigned seed = 0; seed < 20; ++seed) {
    const TemporaryFolder folder;
    const PlainAndSmall files = changed_dressed(
        folder, [&](const json& document, std::string& binary) { strew_normals(document, binary, seed); });
    const std::vector<Vector3d> rest = files.plain.raw_normals(-1, 0.0);
    for (int k = -1; k < 4; ++k) {
      const int clip = k < 0 ? -1 : 0;
      const double time = k / 8.0;
      const std::vector<Vector3d> wanted = files.plain.raw_normals(clip, time),
                                  is = files.small.raw_normals(clip, time);
      ASSERT_EQ(wanted.size(), 9u);
      ASSERT_EQ(is.size(), wanted.size());
      for (std::size_t i = 0; i < is.size(); ++i) {
        // Floats of about 1.
        EXPECT_LT(wanted[i].cross(is[i].normalized()).norm(), std::sin(angle) + 1e-6) << k;
        EXPECT_GT(wanted[i].dot(is[i]), 0.0);
        if ((wanted[i] - rest[i]).lpNorm<Eigen::Infinity>() > 1.01) ++far;
      }
    }
  }
  // The sample includes changes beyond the range of a byte.
  EXPECT_GT(far, 100u);
}

TEST(GlbCompress, ThreeShowsTheBake) {
  FASCICLE_NEEDS_NODE_READERS;
  const TemporaryFolder folder;
  constexpr double bound = 1e-3;
  const model::Model model = jointed_model();
  for (const bool is_small : {false, true}) {
    const fs::path out =
        baked_jointed(folder, is_small ? "small" : "plain", is_small ? std::optional(bound) : std::nullopt);
    std::string command = "node '" + (node_readers() / "read_three.mjs").string() + "' '" +
                          (out / "surface.glb").string() + "'";
    for (std::uint64_t k = 0; k <= jointed_frames; ++k)
      command += " " + std::to_string(static_cast<double>(k) / 24.0);
    command += " > '" + (folder / "shown.json").string() + "'";
    ASSERT_EQ(std::system(command.c_str()), 0);
    const json shown = json::parse(read_text(folder / "shown.json"));
    const bake::FrameCacheReader cache(out / "frames.fascicle");
    for (std::uint64_t k = 0; k <= jointed_frames; ++k) {
      const model::Frame frame = cache.read(k);
      const std::vector<float> baked =
          formats::world_positions(formats::embed(model, frame.positions), model.unit, frame.origin);
      const auto points = shown[k][0]["points"].get<std::vector<double>>();
      ASSERT_EQ(points.size(), baked.size());
      for (std::size_t i = 0; i < points.size(); ++i)
        // Times have six digits: 1e-5 m at some metres per second, and as much from floats.
        EXPECT_NEAR(points[i], double{baked[i]}, (is_small ? bound : 0.0) + 3 * float_rounding)
            << "frame " << k << ", value " << i;
    }
  }
}

TEST(GlbCompress, TheValidatorHasNoErrors) {
  FASCICLE_NEEDS_NODE_READERS;
  const TemporaryFolder folder;
  const fs::path out = baked_jointed(folder, "out", 1e-4);
  const std::string command = "node '" + (node_readers() / "validate_gltf.mjs").string() + "' '" +
                              (out / "surface.glb").string() + "' > '" + (folder / "report.json").string() +
                              "'";
  ASSERT_EQ(std::system(command.c_str()), 0);
  const json report = json::parse(read_text(folder / "report.json"));
  EXPECT_EQ(report["issues"]["numErrors"], 0) << report["issues"].dump(1);
}

}  // namespace
}  // namespace fascicle::tests
