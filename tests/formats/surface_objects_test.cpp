// Objects, materials, texture coordinates, creased normals and velocities of a file, read back from every
// format that holds them.
#include "host/formats/surface_objects.h"

#include <cmath>
#include <filesystem>
#include <map>
#include <random>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "host/bake/bake.h"
#include "host/formats/formats.h"
#include "host/formats/obj_text.h"
#include "host/formats/rest_mesh.h"
#include "host/formats/surface.h"
#include "host/formats/surface_normals.h"
#include "host/formats/surface_velocities.h"
#include "host/formats/unique_names.h"
#include "host/formats/usd_text.h"
#include "tests/bake/fake_solver.h"
#include "tests/formats/dressed_model.h"
#include "tests/formats/ogawa_reader.h"
#include "tests/formats/sink_frames.h"
#include "tests/formats/vtk_reader.h"
#include "tests/support/readers.h"

namespace fascicle::tests {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// Normals are computed in double and rounded once; the file's 0.6 and 0.8 are floats of length 1 within 1e-7.
constexpr double normal_error = 1e-6;

formats::SurfaceObjects dressed() {
  const TemporaryFolder folder;
  write_dressed(folder / "character.glb");
  return formats::read_surface_objects(dressed_model(), folder / "character.glb");
}

template <class T>
std::vector<T> values_in(const std::string& bytes) {
  std::vector<T> values(bytes.size() / sizeof(T));
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = read_value<T>(bytes, i * sizeof(T));
  return values;
}

void expect_points(const std::vector<float>& found, std::uint64_t k, std::size_t first) {
  for (std::size_t i = 0; i < found.size(); ++i)
    EXPECT_EQ(found[i], static_cast<float>(dressed_point(k, first + i / 3)[i % 3])) << i;
}

void expect_normals(const std::vector<float>& found, std::uint64_t k, std::size_t first) {
  for (std::size_t i = 0; i < found.size(); ++i)
    EXPECT_NEAR(found[i], dressed_normal(k, first + i / 3)[i % 3], normal_error)
        << "frame " << k << ", " << i;
}

// Velocities of frame k of 0 to 3, at 8 fps.
void expect_velocities(const std::vector<float>& found, std::uint64_t k, std::size_t first) {
  const std::uint64_t before = k == 0 ? 0 : k - 1, after = k == 3 ? 3 : k + 1;
  const double factor = 8.0 / static_cast<double>(after - before);
  for (std::size_t i = 0; i < found.size(); ++i) {
    const auto at = [&](std::uint64_t frame) {
      return double{static_cast<float>(dressed_point(frame, first + i / 3)[i % 3])};
    };
    EXPECT_EQ(found[i], static_cast<float>((at(after) - at(before)) * factor)) << "frame " << k << ", " << i;
  }
}

// Many images of the same bytes would make a small file's textures gigabytes.
TEST(SurfaceObjects, ImagesOfTheSameBytesAreOneTexture) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder / "character.glb";
  write_dressed(path, [](gltf::GltfDocument& document) {
    const nlohmann::json first = document.json["images"][0];
    document.json["bufferViews"].push_back({{"buffer", 0}, {"byteLength", document.binary.size()}});
    document.json["images"] = {first, first, first};
    document.json["images"][2]["bufferView"] = document.json["bufferViews"].size() - 1;
    for (std::size_t k = 0; k < 3; ++k) {
      document.json["textures"][k] = {{"source", k}};
      document.json["materials"][k]["pbrMetallicRoughness"] = {{"baseColorTexture", {{"index", k}}}};
    }
  });
  const formats::SurfaceObjects surface = formats::read_surface_objects(dressed_model(), path);
  ASSERT_EQ(surface.materials.size(), 3u);
  EXPECT_EQ(surface.materials[0].texture, "textures/image_000.png");
  EXPECT_EQ(surface.materials[1].texture, "textures/image_000.png");
  EXPECT_EQ(surface.materials[2].texture, "");  // with the first, more bytes than the file's buffer
  ASSERT_EQ(surface.textures.size(), 1u);
  EXPECT_EQ(surface.textures[0].bytes, "no picture");
}

TEST(SurfaceObjects, AreThoseOfTheFile) {
  const formats::SurfaceObjects surface = dressed();
  ASSERT_EQ(surface.objects.size(), 2u);
  EXPECT_EQ(surface.objects[0].name, "Body.001");
  EXPECT_EQ(surface.objects[0].identifier, "Body_001");
  EXPECT_EQ(surface.objects[1].name, "Body.001_2");
  EXPECT_EQ(surface.objects[1].identifier, "Body_001_2");
  EXPECT_EQ(surface.objects[0].triangle, (std::vector<std::uint32_t>{0, 1, 2, 3, 4, 5}));
  EXPECT_EQ(surface.objects[1].first_vertex, 6u);
  EXPECT_EQ(surface.objects[1].triangle, (std::vector<std::uint32_t>{0, 1, 2}));
  ASSERT_EQ(surface.materials.size(), 3u);
  EXPECT_EQ(surface.materials[0].name, "Skin");
  EXPECT_EQ(surface.materials[0].color, (std::array<double, 3>{0.5, 0.25, 0.125}));
  EXPECT_EQ(surface.materials[1].name, "Cloth_Red");
  EXPECT_EQ(surface.materials[1].texture, "textures/image_000.png");
  EXPECT_EQ(surface.materials[2].name, "material 2");
  ASSERT_EQ(surface.textures.size(), 1u);
  EXPECT_EQ(surface.textures[0].bytes, "no picture");
  EXPECT_TRUE(surface.objects[1].uvs.empty());
  // Rotated to the bind pose; the file has Z up.
  ASSERT_EQ(surface.normals.size(), 27u);
  for (std::size_t i = 0; i < 27; ++i) EXPECT_NEAR(surface.normals[i], dressed_normals[i], normal_error);
}

// Alpha acts only where the file says so: exporters often leave one of 0 on opaque materials.
TEST(SurfaceObjects, ShowAlphaAsTheFileSays) {
  const TemporaryFolder folder;
  const fs::path path = folder / "character.glb";
  write_dressed(path, [](gltf::GltfDocument& document) {
    json& materials = document.json["materials"];
    document.json["samplers"] = {{{"wrapS", 33071}, {"wrapT", 33648}}};
    document.json["textures"][0]["sampler"] = 0;
    materials[0]["pbrMetallicRoughness"]["baseColorFactor"] = {1, 1, 1, 0};
    materials[1]["alphaMode"] = "MASK";
    materials[1]["alphaCutoff"] = 0.25;
    materials[2] = {{"alphaMode", "BLEND"},
                    {"extensions",
                     {{"KHR_materials_pbrSpecularGlossiness",
                       {{"diffuseFactor", {0.5, 0, 0, 0.5}}, {"glossinessFactor", 0.75}}}}}};
  });
  const formats::SurfaceObjects surface = formats::read_surface_objects(dressed_model(), path);
  const std::string mtl = formats::mtl_text(surface, "../"), usd = formats::usd_materials(surface, "/m", 0);
  const auto part = [](const std::string& text, const std::string& from, const std::string& to) {
    const std::size_t first = text.find(from);
    return first == std::string::npos ? "" : text.substr(first, text.find(to, first) - first);
  };
  const auto has = [](const std::string& text, const std::string& what) {
    return text.find(what) != std::string::npos;
  };
  const std::string opaque = part(usd, "def Material \"Skin\"", "def Material \"Cloth_Red\"");
  EXPECT_TRUE(has(opaque, "float inputs:opacity = 1\n")) << opaque;
  const std::string masked = part(usd, "def Material \"Cloth_Red\"", "def Material \"material_2\"");
  EXPECT_TRUE(has(masked, "float inputs:opacity.connect = </m/Cloth_Red/Texture.outputs:a>\n")) << masked;
  EXPECT_TRUE(has(masked, "float inputs:opacityThreshold = 0.25\n")) << masked;
  EXPECT_TRUE(has(masked, "float outputs:a\n")) << masked;
  EXPECT_TRUE(has(masked, "token inputs:wrapS = \"clamp\"\n")) << masked;
  EXPECT_TRUE(has(masked, "token inputs:wrapT = \"mirror\"\n")) << masked;
  const std::string blended = part(usd, "def Material \"material_2\"", "no such text");
  EXPECT_TRUE(has(blended, "color3f inputs:diffuseColor = (0.5, 0, 0)\n")) << blended;
  EXPECT_TRUE(has(blended, "float inputs:opacity = 0.5\n")) << blended;
  EXPECT_TRUE(has(blended, "float inputs:roughness = 0.25\n")) << blended;
  EXPECT_TRUE(has(blended, "int inputs:useSpecularWorkflow = 1\n")) << blended;
  EXPECT_TRUE(has(part(mtl, "newmtl Skin", "newmtl Cloth"), "\nd 1\n")) << mtl;
  EXPECT_TRUE(has(part(mtl, "newmtl Cloth", "newmtl material"), "\nmap_d ../textures/image_000.png\n"))
      << mtl;
  EXPECT_TRUE(has(part(mtl, "newmtl material", "no such text"), "\nd 0.5\n")) << mtl;
}

TEST(SurfaceObjects, RefuseAFileThatDoesNotFit) {
  const TemporaryFolder folder;
  write_dressed(folder / "character.glb");
  EXPECT_THROW(formats::read_surface_objects(two_tetrahedra(), folder / "character.glb"), bake::BakeError);
}

TEST(SurfaceObjects, NamesOfTexturesAreTold) {
  EXPECT_TRUE(formats::is_texture_name("image_000.png"));
  EXPECT_TRUE(formats::is_texture_name("image_1234.jpg"));
  for (const char* name : {"image_00.png", "image_00a.png", "picture.png", "image_000.gif", "image_.png"})
    EXPECT_FALSE(formats::is_texture_name(name)) << name;
}

// The rule in its plainest form, which takes time by the square of the number of equal names.
std::vector<std::string> unique_by_search(const std::vector<std::string>& wanted) {
  std::set<std::string> taken;
  std::vector<std::string> names;
  for (const std::string& one : wanted) {
    std::string name = one;
    for (int k = 2; !taken.insert(name).second; ++k) name = one + '_' + std::to_string(k);
    names.push_back(name);
  }
  return names;
}

std::vector<std::string> unique_names(const std::vector<std::string>& wanted) {
  formats::UniqueNames unique;
  std::vector<std::string> names;
  for (const std::string& one : wanted) names.push_back(unique.take(one));
  return names;
}

TEST(UniqueNames, AreThoseOfAPlainSearch) {
  const std::vector<std::string> collisions{"m", "m_3",   "m", "m", "m_2", "m_2",
                                            "m", "m_2_2", "",  "",  "_2",  "m_1"};
  EXPECT_EQ(unique_names(collisions), (std::vector<std::string>{"m", "m_3", "m_2", "m_4", "m_2_2", "m_2_3",
                                                                "m_5", "m_2_2_2", "", "_2", "_2_2", "m_1"}));
  EXPECT_EQ(unique_names(collisions), unique_by_search(collisions));
  // Few different names, so that they meet in every order.
  std::mt19937 random(20170524);
  for (int round = 0; round < 200; ++round) {
    std::vector<std::string> wanted;
    for (int k = 0; k < 60; ++k) {
      std::string name = random() % 2 == 0 ? "m" : "";
      for (auto more = random() % 3; more > 0; --more) name += '_' + std::to_string(1 + random() % 4);
      wanted.push_back(name);
    }
    ASSERT_EQ(unique_names(wanted), unique_by_search(wanted)) << "round " << round;
  }
}

// A plain search tries 1.25 thousand million names, for several minutes.
TEST(UniqueNames, OfManyEqualOnesAreQuick) {
  const std::vector<std::string> names = unique_names(std::vector<std::string>(50'000, "m"));
  EXPECT_EQ(names[0], "m");
  for (std::size_t k = 1; k < names.size(); ++k) ASSERT_EQ(names[k], "m_" + std::to_string(k + 1));
}

TEST(SurfaceNormals, KeepCreasesAndTurnWithTheBody) {
  const model::Model model = dressed_model();
  const formats::SurfaceNormals normals(model, dressed().normals);
  for (std::uint64_t k = 0; k < 4; ++k) expect_normals(normals.of(turned(model, k).surface), k, 0);
  // The control: smooth normals are off by more than 30 degrees at the crease. The tilted normal catches a
  // shortest rotation, which would leave it behind when the surface spins about its normal.
  const std::vector<float> smooth = formats::SurfaceNormals(model).of(turned(model, 0).surface);
  double cosine = 0.0;
  for (std::size_t axis = 0; axis < 3; ++axis) cosine += double{smooth[axis]} * dressed_normals[axis];
  EXPECT_LT(cosine, std::sqrt(0.75));
}

// Each side of a crease follows its own faces: the second face swings about the common edge.
TEST(SurfaceNormals, SidesOfACreaseTurnApart) {
  const model::Model model = dressed_model();
  const formats::SurfaceNormals normals(model, dressed().normals);
  std::vector<float> positions = model.rest;
  // The edge is along y. Vertex 3 moves from (0, 0, 1) to (-0.6, 0, 0.8), and the face normal from (1, 0, 0)
  // to (0.8, 0, 0.6).
  positions[9] = -0.6f;
  positions[11] = 0.8f;
  const std::vector<float> found = normals.of(formats::embed(model, positions));
  for (std::size_t i = 0; i < 9; ++i) EXPECT_NEAR(found[i], dressed_normals[i], normal_error) << i;
  for (std::size_t i = 9; i < 18; i += 3) {
    EXPECT_NEAR(found[i], 0.8, normal_error);
    EXPECT_NEAR(found[i + 2], 0.6, normal_error);
  }
}

TEST(SurfaceVelocities, AreTheDerivativeOfWhatIsWritten) {
  formats::SurfaceVelocities velocities(4.0);
  EXPECT_TRUE(velocities.next({1, 10}).empty());
  EXPECT_EQ(velocities.last(), (std::vector<float>{0, 0}));
  EXPECT_EQ(velocities.next({2, 10}), (std::vector<float>{4, 0}));
  EXPECT_EQ(velocities.next({5, 9}), (std::vector<float>{8, -2}));
  EXPECT_EQ(velocities.last(), (std::vector<float>{12, -4}));
}

TEST(Alembic, HoldsObjectsFaceSetsUvsAndVelocities) {
  const TemporaryFolder folder;
  write_dressed_frames(formats::format_named("abc").make(), folder / "", {.first_number = 1001});
  const OgawaArchive archive = read_ogawa(read_text(folder / "surface.abc"));
  EXPECT_EQ(archive.samplings[1].period, 0.125);
  EXPECT_EQ(archive.samplings[1].times, std::vector<double>{1001.0 / 8.0});
  const OgawaProperty& all = archive.top.properties.property(".childBnds");
  EXPECT_EQ(all.metadata, "interpretation=box");
  ASSERT_EQ(archive.top.children.size(), 2u);
  for (std::size_t object = 0; object < 2; ++object) {
    const OgawaObject& mesh = archive.top.children[object];
    EXPECT_EQ(mesh.name, object == 0 ? "Body.001" : "Body.001_2");
    const OgawaProperty& geometry = mesh.properties.property(".geom");
    const std::size_t first = 6 * object;
    for (std::uint32_t k = 0; k < 4; ++k) {
      expect_points(values_in<float>(geometry.property("P").at(k).bytes), k, first);
      expect_normals(values_in<float>(geometry.property("N").at(k).bytes), k, first);
      expect_velocities(values_in<float>(geometry.property(".velocities").at(k).bytes), k, first);
      const auto box = values_in<double>(all.at(k).bytes);
      const auto own = values_in<double>(geometry.property(".selfBnds").at(k).bytes);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        EXPECT_LE(box[axis], own[axis]);
        EXPECT_GE(box[3 + axis], own[3 + axis]);
      }
    }
    EXPECT_EQ(geometry.property(".velocities").stored.size(), 4u);
    EXPECT_EQ(geometry.property(".velocities").metadata, "interpretation=vector");
  }
  const OgawaProperty& uvs = archive.top.children[0].properties.property(".geom").property("uv");
  EXPECT_EQ(uvs.extent, 2u);
  EXPECT_NE(uvs.metadata.find("geoScope=vtx;interpretation=vector;isGeomParam=true;podExtent=2"),
            std::string::npos);
  const auto found = values_in<float>(uvs.at(3).bytes);
  ASSERT_EQ(found.size(), 12u);
  for (std::size_t i = 0; i < 12; ++i) EXPECT_EQ(found[i], i % 2 == 0 ? dressed_uvs[i] : 1 - dressed_uvs[i]);

  std::map<std::string, std::vector<std::int32_t>> sets;
  for (const OgawaObject& mesh : archive.top.children)
    for (const OgawaObject& set : mesh.children) {
      EXPECT_EQ(set.metadata,
                "schema=AbcGeom_FaceSet_v1;schemaBaseType=AbcGeom_GeomBase_v1;"
                "schemaObjTitle=AbcGeom_FaceSet_v1:.faceset");
      const OgawaProperty& faces = set.properties.property(".faceset");
      sets[set.name] = values_in<std::int32_t>(faces.property(".faces").at(0).bytes);
      EXPECT_EQ(values_in<std::uint32_t>(faces.property(".facesExclusive").at(0).bytes),
                std::vector<std::uint32_t>{1});
      EXPECT_EQ(values_in<double>(faces.property(".selfBnds").at(2).bytes).size(), 6u);
    }
  EXPECT_EQ(sets, (std::map<std::string, std::vector<std::int32_t>>{
                      {"Skin", {0}}, {"Cloth_Red", {1}}, {"material 2", {0}}}));
}

TEST(ObjSequence, HoldsObjectsMaterialsAndUvs) {
  const TemporaryFolder folder;
  write_dressed_frames(formats::format_named("obj").make(), folder / "", {.first_number = 1001});
  EXPECT_FALSE(fs::exists(folder / "obj/frame_000000.obj"));
  EXPECT_EQ(read_text(folder / "textures/image_000.png"), "no picture");
  const std::string materials = read_text(folder / "obj/surface.mtl");
  EXPECT_NE(materials.find("newmtl Skin\nKd 0.5 0.25 0.125\n"), std::string::npos) << materials;
  EXPECT_NE(materials.find("map_Kd ../textures/image_000.png\n"), std::string::npos) << materials;
  for (std::uint64_t k = 0; k < 4; ++k) {
    std::istringstream in(read_text(folder / ("obj/frame_00100" + std::to_string(1 + k) + ".obj")));
    std::vector<float> points, normals, uvs;
    std::string structure;
    for (std::string line; std::getline(in, line);) {
      std::istringstream words(line);
      std::string kind;
      words >> kind;
      std::vector<float>* to = kind == "v"    ? &points
                               : kind == "vn" ? &normals
                               : kind == "vt" ? &uvs
                                              : nullptr;
      if (to == nullptr && kind != "#" && kind != "s") structure += line + '\n';
      for (float value = 0; to != nullptr && words >> value;) to->push_back(value);
    }
    EXPECT_EQ(structure,
              "mtllib surface.mtl\no Body.001\nusemtl Skin\nf 1/1/1 2/2/2 3/3/3\nusemtl Cloth_Red\n"
              "f 4/4/4 5/5/5 6/6/6\no Body.001_2\nusemtl material_2\nf 7//7 8//8 9//9\n");
    ASSERT_EQ(points.size(), 27u);
    ASSERT_EQ(normals.size(), 27u);
    expect_points(points, k, 0);
    expect_normals(normals, k, 0);
    ASSERT_EQ(uvs.size(), 12u);
    for (std::size_t i = 0; i < 12; ++i) EXPECT_EQ(uvs[i], i % 2 == 0 ? dressed_uvs[i] : 1 - dressed_uvs[i]);
  }
}

TEST(VtpSeries, HoldsObjectsMaterialsAndUvs) {
  const TemporaryFolder folder;
  write_dressed_frames(formats::format_named("vtp").make(), folder / "", {.first_number = 1001});
  EXPECT_NE(read_text(folder / "vtp/series.pvd").find("timestep=\"1.625\" file=\"frame_001002.vtp\""),
            std::string::npos);
  for (std::uint64_t k = 0; k < 4; ++k) {
    VtkFile vtp = read_vtk(folder / ("vtp/frame_00100" + std::to_string(1 + k) + ".vtp"));
    EXPECT_NE(vtp.xml.find("NumberOfPoints=\"9\" NumberOfPolys=\"3\""), std::string::npos) << vtp.xml;
    EXPECT_NE(vtp.xml.find("<PointData Normals=\"normal\" TCoords=\"uv\">"), std::string::npos);
    EXPECT_EQ(vtp.names["objects"], (std::vector<std::string>{"Body.001", "Body.001_2"}));
    EXPECT_EQ(vtp.names["materials"], (std::vector<std::string>{"Skin", "Cloth_Red", "material 2"}));
    const auto points = values_in<float>(vtp.arrays["position"]);
    ASSERT_EQ(points.size(), 27u);
    expect_points(points, k, 0);
    expect_normals(values_in<float>(vtp.arrays["normal"]), k, 0);
    const auto uvs = values_in<float>(vtp.arrays["uv"]);
    ASSERT_EQ(uvs.size(), 18u);
    for (std::size_t i = 0; i < 18; ++i)
      EXPECT_EQ(uvs[i], i >= 12 ? 0.0f : i % 2 == 0 ? dressed_uvs[i] : 1 - dressed_uvs[i]);
    EXPECT_EQ(values_in<std::int32_t>(vtp.arrays["object"]), (std::vector<std::int32_t>{0, 0, 1}));
    EXPECT_EQ(values_in<std::int32_t>(vtp.arrays["material"]), (std::vector<std::int32_t>{0, 1, 2}));
    EXPECT_EQ(values_in<std::int32_t>(vtp.arrays["connectivity"]),
              (std::vector<std::int32_t>{0, 1, 2, 3, 4, 5, 6, 7, 8}));
    EXPECT_EQ(values_in<std::int32_t>(vtp.arrays["offsets"]), (std::vector<std::int32_t>{3, 6, 9}));
  }
}

TEST(RestMesh, HasUvsAndMaterials) {
  const TemporaryFolder folder;
  formats::write_rest_mesh(folder / "", dressed_model(), dressed());
  const std::string text = read_text(folder / "rest.obj");
  EXPECT_NE(text.find("mtllib rest.mtl\n"), std::string::npos) << text;
  EXPECT_NE(text.find("vt 1 1\n"), std::string::npos) << text;
  EXPECT_NE(text.find("g Body.001_2\nusemtl material_2\nf 7 8 9\n"), std::string::npos) << text;
  EXPECT_NE(read_text(folder / "rest.mtl").find("map_Kd textures/image_000.png\n"), std::string::npos);
}

TEST(Usd, HoldsObjectsMaterialsUvsAndVelocities) {
  FASCICLE_NEEDS_NODE_READERS;
  const TemporaryFolder folder;
  write_dressed_frames(formats::format_named("usda").make(), folder / "", {.first_number = 1001});
  EXPECT_FALSE(fs::exists(folder / "surface.usda.samples.part"));
  EXPECT_EQ(read_text(folder / "textures/image_000.png"), "no picture");
  const json usd = json::parse(read_by_node("read_usda.mjs", folder / "surface.usda"));
  EXPECT_EQ(usd["meshes"], 2);
  const json& specs = usd["specs"];
  EXPECT_EQ(usd["stage"]["defaultPrim"], "body");
  // The text of the file, for what the first reader ignores.
  const std::string layer = usd["layer"];
  for (const char* text :
       {"kind = \"component\"", "float3[] extentsHint = [(", "point3f[] points = [(10, 0, -3)",
        "normal3f[] normals = [(0, 0, 1)", "interpolation = \"vertex\""})
    EXPECT_NE(layer.find(text), std::string::npos) << text;
  EXPECT_EQ(specs["/body.extentsHint"]["timeSamples"]["times"], (std::vector<int>{1001, 1002, 1003, 1004}));
  for (std::size_t object = 0; object < 2; ++object) {
    const std::string path = object == 0 ? "/body/Body_001" : "/body/Body_001_2";
    const std::size_t first = 6 * object;
    const auto samples = [&](const std::string& attribute) -> const json& {
      return specs[path + '.' + attribute];
    };
    EXPECT_EQ(samples("velocities")["typeName"], "vector3f[]");
    for (std::uint64_t k = 0; k < 4; ++k) {
      const auto at = [&](const std::string& attribute) {
        const json& sampled = samples(attribute)["timeSamples"];
        EXPECT_EQ(sampled["times"][k], 1001 + k) << attribute;
        return sampled["values"][k].get<std::vector<float>>();
      };
      expect_points(at("points"), k, first);
      expect_normals(at("normals"), k, first);
      expect_velocities(at("velocities"), k, first);
    }
  }
  const auto uvs = specs["/body/Body_001.primvars:st"]["default"].get<std::vector<float>>();
  ASSERT_EQ(uvs.size(), 12u);
  for (std::size_t i = 0; i < 12; ++i) EXPECT_EQ(uvs[i], i % 2 == 0 ? dressed_uvs[i] : 1 - dressed_uvs[i]);
  EXPECT_FALSE(specs.contains("/body/Body_001_2.primvars:st"));
  const auto bound = [&](const std::string& prim) {
    return specs[prim + ".material:binding"]["targetPaths"];
  };
  EXPECT_EQ(bound("/body/Body_001/Skin"), json({"/body/Materials/Skin"}));
  EXPECT_EQ(bound("/body/Body_001/Cloth_Red"), json({"/body/Materials/Cloth_Red"}));
  EXPECT_EQ(bound("/body/Body_001_2"), json({"/body/Materials/material_2"}));
  EXPECT_EQ(specs["/body/Body_001/Cloth_Red.indices"]["default"], json({1}));
  EXPECT_EQ(specs["/body/Body_001/Cloth_Red.familyName"]["default"], "materialBind");
  EXPECT_EQ(specs["/body/Body_001_2.doubleSided"]["default"], "1");
  EXPECT_EQ(specs["/body/Materials/Skin/Surface.inputs:diffuseColor"]["default"], json({0.5, 0.25, 0.125}));
  EXPECT_EQ(specs["/body/Materials/Cloth_Red/Texture.inputs:file"]["default"], "./textures/image_000.png");
}

}  // namespace
}  // namespace fascicle::tests
