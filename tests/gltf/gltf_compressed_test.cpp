// Files compressed here with the codecs' own encoders read like the plain ones; damaged ones are refused.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <draco/compression/config/compression_shared.h>
#include <draco/core/draco_types.h>
#include <gtest/gtest.h>
#include <meshoptimizer.h>

#include "host/base/errors.h"
#include "host/gltf/gltf.h"
#include "host/gltf/gltf_rig.h"
#include "host/scene/scene.h"
#include "tests/gltf/compressed_builder.h"
#include "tests/gltf/gltf_builder.h"

namespace fascicle::tests {
namespace {

using Eigen::Vector3d;
using nlohmann::json;
using rig::Character;

Character read(const json& document) {
  const TemporaryFolder folder;
  return gltf::read_gltf(folder.write("small.gltf", document.dump()));
}

std::array<std::uint32_t, 3> turned(std::array<std::uint32_t, 3> t) {
  std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
  return t;
}

std::vector<std::array<std::uint32_t, 3>> turned(const mesh::SurfaceMesh& surface) {
  std::vector<std::array<std::uint32_t, 3>> result;
  for (const auto& t : surface.triangles) result.push_back(turned(t));
  return result;
}

class Meshopt : public testing::TestWithParam<const char*> {};

TEST_P(Meshopt, reads_as_the_plain_file_does) {
  const GltfBuilder b = column();
  const Character plain = read(b.with_data_uri()), small = read(with_meshopt(b, GetParam()));
  EXPECT_EQ(small.surface.vertices, plain.surface.vertices);
  EXPECT_EQ(small.weights, plain.weights);
  EXPECT_EQ(small.joints, plain.joints);
  // The codec may start a triangle at another corner.
  EXPECT_EQ(turned(small.surface), turned(plain.surface));
  ASSERT_EQ(small.clips.size(), 2u);
  EXPECT_EQ(small.clips[0].channels[0].values, plain.clips[0].channels[0].values);
}

INSTANTIATE_TEST_SUITE_P(Names, Meshopt, testing::Values(meshopt, "KHR_meshopt_compression"));

// Without a stride of its own a view may hold elements of several sizes: a clip's times and rotations.
TEST(Meshopt, a_view_of_several_sizes_is_tightly_packed) {
  GltfBuilder b = column();
  json &accessors = b.document["accessors"], &views = b.document["bufferViews"];
  const json& sampler = b.document["animations"][0]["samplers"][0];
  json &times = accessors[sampler["input"].get<std::size_t>()],
       &rotations = accessors[sampler["output"].get<std::size_t>()];
  json &first = views[times["bufferView"].get<std::size_t>()],
       &second = views[rotations["bufferView"].get<std::size_t>()];
  const std::size_t length = first["byteLength"];
  ASSERT_EQ(first["byteOffset"].get<std::size_t>() + length, second["byteOffset"]);
  first["byteLength"] = length + second["byteLength"].get<std::size_t>();
  const json unused = rotations;
  rotations["bufferView"] = times["bufferView"];
  rotations["byteOffset"] = length;
  accessors.push_back(unused);
  const Character plain = read(b.with_data_uri()), small = read(with_meshopt(b));
  ASSERT_EQ(small.clips.size(), 2u);
  EXPECT_EQ(small.clips[0].channels[0].times, plain.clips[0].channels[0].times);
  EXPECT_EQ(small.clips[0].channels[0].values, plain.clips[0].channels[0].values);
}

TEST(Meshopt, goes_on_uncompressed) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.write("small.gltf", with_meshopt(column()).dump());
  std::vector<std::string> missing;
  const gltf::GltfDocument document = gltf::pack_gltf(path, missing);
  EXPECT_EQ(document.json.dump().find("meshopt"), std::string::npos);
  json whole = document.json;
  const std::vector<unsigned char> bytes(document.binary.begin(), document.binary.end());
  whole["buffers"][0]["uri"] = "data:application/octet-stream;base64," + base64(bytes);
  EXPECT_EQ(read(whole).surface.vertices, read(column().with_data_uri()).surface.vertices);
}

TEST(Meshopt, an_exponential_filter_is_undone) {
  GltfBuilder b = column();
  json document = with_meshopt(b);
  // 12 positions of 2^-1 x mantissa.
  std::vector<std::uint32_t> encoded;
  for (std::uint32_t i = 0; i < 36; ++i) encoded.push_back(0xff000000u | i);
  std::vector<unsigned char> bytes(meshopt_encodeVertexBufferBound(12, 12));
  bytes.resize(meshopt_encodeVertexBuffer(bytes.data(), bytes.size(), encoded.data(), 12, 12));
  document["buffers"].push_back(
      {{"byteLength", bytes.size()}, {"uri", "data:application/octet-stream;base64," + base64(bytes)}});
  json& how = document["bufferViews"][0]["extensions"][meshopt];
  how["buffer"] = 2;
  how["byteOffset"] = 0;
  how["byteLength"] = bytes.size();
  how["filter"] = "EXPONENTIAL";
  const Character c = read(document);
  // Raw (x, y, z) becomes (x, z, -y) centimetres: vertex 1 is raw (1.5, 2, 2.5).
  EXPECT_LT((c.surface.vertices[1] - Vector3d(0.015, 0.025, -0.02)).norm(), 1e-7);
}

// Vertices with their attributes, sorted: the codec reorders them.
std::vector<std::vector<double>> sorted(const Character& c) {
  std::vector<std::vector<double>> rows;
  for (std::size_t i = 0; i < c.surface.vertices.size(); ++i) {
    const Vector3d& p = c.surface.vertices[i];
    double upper = 0.0;
    for (std::size_t k = 0; k < 8; ++k)
      if (c.joints[i][k] == 1) upper += c.weights[i][k];
    rows.push_back({p.x(), p.y(), p.z(), upper});
  }
  std::sort(rows.begin(), rows.end());
  return rows;
}

double area(const mesh::SurfaceMesh& surface) {
  double sum = 0.0;
  for (const auto& t : surface.triangles)
    sum += 0.5 * (surface.vertices[t[1]] - surface.vertices[t[0]])
                     .cross(surface.vertices[t[2]] - surface.vertices[t[0]])
                     .norm();
  return sum;
}

class Draco : public testing::TestWithParam<int> {};

TEST_P(Draco, reads_as_the_plain_file_does) {
  const GltfBuilder b = with_draco(GetParam());
  const Character plain = read(column().with_data_uri()), small = read(b.with_data_uri());
  EXPECT_EQ(sorted(small), sorted(plain));  // nothing is quantised
  EXPECT_EQ(small.surface.triangles.size(), plain.surface.triangles.size());
  EXPECT_NEAR(area(small.surface), area(plain.surface), 1e-12);
  const TemporaryFolder folder;
  std::vector<std::string> missing;
  const gltf::GltfDocument document = gltf::pack_gltf(folder.write("small.glb", b.glb()), missing);
  EXPECT_EQ(document.json.dump().find("draco"), std::string::npos);
}

// With any byte of the stream changed, or the stream truncated: read or refused, never a crash.
TEST_P(Draco, a_damaged_stream_is_read_or_refused) {
  const GltfBuilder good = with_draco(GetParam());
  const std::size_t view =
      good.document["meshes"][0]["primitives"][0]["extensions"][draco_name]["bufferView"];
  const std::size_t offset = good.document["bufferViews"][view]["byteOffset"],
                    length = good.document["bufferViews"][view]["byteLength"];
  const TemporaryFolder folder;
  std::size_t refused = 0;
  const auto attempt = [&](const GltfBuilder& bad) {
    try {
      gltf::read_gltf(folder.write("bad.glb", bad.glb()));
    } catch (const base::SceneError&) {
      ++refused;
    }
  };
  for (std::size_t at = 0; at < length; ++at) {
    GltfBuilder bad = good;
    const unsigned flip = at % 3 == 0 ? 0x01u : at % 3 == 1 ? 0x40u : 0xffu;
    bad.bytes[offset + at] = static_cast<unsigned char>(bad.bytes[offset + at] ^ flip);
    attempt(bad);
  }
  EXPECT_GT(refused, length / 10);  // a changed byte of a float just gives another number
  refused = 0;
  for (std::size_t cut = 1; cut < length; cut += 7) {
    GltfBuilder bad = good;
    bad.document["bufferViews"][view]["byteLength"] = cut;
    attempt(bad);
  }
  EXPECT_GT(refused, length / 7 / 2);
}

INSTANTIATE_TEST_SUITE_P(Methods, Draco,
                         testing::Values(static_cast<int>(draco::MESH_SEQUENTIAL_ENCODING),
                                         static_cast<int>(draco::MESH_EDGEBREAKER_ENCODING)));

void expect_refused(const json& document, const std::string& place) {
  try {
    read(document);
    ADD_FAILURE() << "was read";
  } catch (const base::SceneError& error) {
    EXPECT_NE(std::string(error.what()).find(": " + place + ": "), std::string::npos) << error.what();
  }
}

TEST(CompressedLies, are_refused) {
  const std::string how = std::string("/bufferViews/0/extensions/") + meshopt;
  const auto lie = [&](const char* key, const json& value, const std::string& place) {
    json document = with_meshopt(column());
    document["bufferViews"][0]["extensions"][meshopt][key] = value;
    SCOPED_TRACE(key + (" " + value.dump()));
    expect_refused(document, place);
  };
  lie("count", 4000000000u, how);
  lie("count", 0, how);
  lie("byteStride", 10, how);
  lie("byteStride", 260, how);
  lie("mode", "NOTHING", how);
  lie("filter", "QUATERNION", how);
  lie("filter", "SEPIA", how);
  lie("buffer", 7, how + "/buffer");
  lie("byteLength", 1000000, how + "/byteLength");
  lie("byteLength", 5, how);

  const std::string draco = std::string("/meshes/0/primitives/0/extensions/") + draco_name;
  const auto draco_lie = [&](const std::string& place, const auto& tell) {
    json document = with_draco(draco::MESH_EDGEBREAKER_ENCODING).with_data_uri();
    tell(document);
    expect_refused(document, place);
  };
  const auto extension = [](json& document) -> json& {
    return document["meshes"][0]["primitives"][0]["extensions"][draco_name];
  };
  draco_lie(draco, [](json& d) {
    for (const std::size_t a : {0u, 1u, 2u}) d["accessors"][a]["count"] = 11;
  });
  draco_lie(draco, [](json& d) {
    for (const std::size_t a : {0u, 1u, 2u}) d["accessors"][a]["count"] = 4000000000u;
  });
  draco_lie("/accessors/2/count", [](json& d) { d["accessors"][2]["count"] = 11; });
  draco_lie(draco + "/bufferView", [&](json& d) { extension(d)["bufferView"] = 99; });
  draco_lie(draco, [&](json& d) { extension(d)["bufferView"] = 0; });
  draco_lie(draco, [&](json& d) { extension(d)["attributes"]["POSITION"] = 9; });
  draco_lie(draco + "/attributes/NORMAL", [&](json& d) { extension(d)["attributes"]["NORMAL"] = 0; });
}

// Draco's own reader takes any byte for a bool, which is undefined behaviour.
TEST(CompressedLies, a_draco_attribute_of_a_type_that_gltf_lacks_is_refused) {
  const GltfBuilder good = with_draco(draco::MESH_EDGEBREAKER_ENCODING);
  const std::size_t view =
      good.document["meshes"][0]["primitives"][0]["extensions"][draco_name]["bufferView"];
  const std::size_t offset = good.document["bufferViews"][view]["byteOffset"],
                    length = good.document["bufferViews"][view]["byteLength"];
  ASSERT_EQ(offset + length, good.bytes.size());
  // The weights: a generic attribute (4) of floats (9), 4 components, not normalized, unique id 2.
  const std::array<unsigned char, 5> weights{4, 9, 4, 0, 2};
  const auto at = std::search(good.bytes.begin() + static_cast<std::ptrdiff_t>(offset), good.bytes.end(),
                              weights.begin(), weights.end());
  ASSERT_NE(at, good.bytes.end());
  for (const draco::DataType type : {draco::DT_BOOL, draco::DT_FLOAT64, draco::DT_INT64, draco::DT_UINT64}) {
    GltfBuilder bad = good;
    bad.bytes[static_cast<std::size_t>(at - good.bytes.begin()) + 1] = static_cast<unsigned char>(type);
    // Numbers of 64 bits need more bytes. The weights come last.
    bad.bytes.resize(bad.bytes.size() + 4096);
    bad.document["bufferViews"][view]["byteLength"] = length + 4096;
    try {
      read(bad.with_data_uri());
      ADD_FAILURE() << "type " << type << " was read";
    } catch (const base::SceneError& error) {
      EXPECT_NE(std::string(error.what()).find("a type that glTF lacks"), std::string::npos) << error.what();
    }
  }
}

TEST(CompressedLies, a_damaged_meshopt_stream_is_read_or_refused) {
  const json good = with_meshopt(column());
  const std::string uri = good["buffers"][0]["uri"];
  const TemporaryFolder folder;
  std::size_t refused = 0;
  for (std::size_t at = uri.find(',') + 1; at < uri.size(); ++at) {
    json bad = good;
    std::string changed = uri;
    changed[at] = changed[at] == 'A' ? '/' : 'A';
    bad["buffers"][0]["uri"] = changed;
    try {
      gltf::read_gltf(folder.write("bad.gltf", bad.dump()));
    } catch (const base::SceneError&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 0u);
}

TEST(OtherFormats, a_vrm_is_a_glb_and_other_names_get_advice) {
  const TemporaryFolder folder;
  EXPECT_EQ(gltf::read_gltf(folder.write("avatar.vrm", column().glb())).surface.vertices.size(), 12u);
  const scene::Scene scene = scene::load_scene(folder.write("avatar.vrm", column().glb()).string());
  EXPECT_TRUE(std::holds_alternative<Character>(scene.geometry));
  try {
    scene::load_scene((folder.path() / "hero.blend").string());
    FAIL() << "was read";
  } catch (const base::SceneError& error) {
    const std::string what = error.what();
    EXPECT_NE(what.find("export `hero.glb`"), std::string::npos) << what;
  }
}

}  // namespace
}  // namespace fascicle::tests
