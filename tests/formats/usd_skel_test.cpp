// UsdSkel next to the baked points: evaluated by the schema, it is skinning by the file's skeleton.
#include <cmath>
#include <cstdlib>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include "host/bake/export.h"
#include "host/formats/formats.h"
#include "tests/bake/fake_solver.h"
#include "tests/formats/dressed_model.h"
#include "tests/formats/jointed_body.h"
#include "tests/gltf/gltf_viewer.h"
#include "tests/support/readers.h"

namespace fascicle::tests {
namespace {

namespace fs = std::filesystem;
using Eigen::Matrix4d;
using Eigen::Vector3d;
using nlohmann::json;

// Scales near 1 in half precision, and floats of about 10 m.
constexpr double skel_rounding = 2e-5;

json read_usd(const fs::path& file) {
  const fs::path out = file.parent_path() / "usd.json";
  const std::string command = "node '" + (node_readers() / "read_usda.mjs").string() + "' '" + file.string() +
                              "' > '" + out.string() + "'";
  EXPECT_EQ(std::system(command.c_str()), 0);
  return json::parse(read_text(out));
}

// USD has row vectors; this transposes to column vectors.
Matrix4d matrix_of(const json& numbers, std::size_t number = 0) {
  Matrix4d m;
  const std::vector<double> flat = [&] {
    std::vector<double> values;
    const std::function<void(const json&)> add = [&](const json& part) {
      if (part.is_array())
        for (const json& item : part) add(item);
      else
        values.push_back(part.get<double>());
    };
    add(numbers);
    return values;
  }();
  EXPECT_GE(flat.size(), 16 * (number + 1));
  for (Eigen::Index k = 0; k < 16; ++k) m.data()[k] = flat.at(16 * number + static_cast<std::size_t>(k));
  return m;
}

// The skinned points of a mesh at time sample k, in the world, by UsdSkel's equation.
std::vector<Vector3d> skinned(const json& usd, const std::string& root, const std::string& mesh,
                              std::size_t k) {
  const auto field = [&](const std::string& path, const char* key) -> const json& {
    const auto found = usd["specs"].find(path);
    if (found == usd["specs"].end() || !found->contains(key)) throw std::runtime_error(path + ": no " + key);
    return (*found)[key];
  };
  const Matrix4d to_world = matrix_of(field(root + ".xformOp:transform", "default"));
  const auto joints = field(root + "/Skeleton_0.joints", "default").get<std::vector<std::string>>();
  const json& bind = field(root + "/Skeleton_0.bindTransforms", "default");
  const auto sample = [&](const char* name) {
    return field(root + "/Motion." + name, "timeSamples")["values"][k].get<std::vector<double>>();
  };
  const std::vector<double> t = sample("translations"), r = sample("rotations"), s = sample("scales");
  std::vector<Matrix4d> pose;
  // The parser reorders the file's quaternions from (w, x, y, z) to (x, y, z, w).
  for (std::size_t j = 0; j < joints.size(); ++j) {
    Eigen::Affine3d local = Eigen::Translation3d(t[3 * j], t[3 * j + 1], t[3 * j + 2]) *
                            Eigen::Quaterniond(r[4 * j + 3], r[4 * j], r[4 * j + 1], r[4 * j + 2]) *
                            Eigen::Scaling(s[3 * j], s[3 * j + 1], s[3 * j + 2]);
    const std::size_t slash = joints[j].rfind('/');
    Matrix4d above = Matrix4d::Identity();
    if (slash != std::string::npos)
      for (std::size_t p = 0; p < j; ++p)
        if (joints[p] == joints[j].substr(0, slash)) above = pose[p];
    pose.push_back(above * local.matrix());
  }
  const std::string at = root + "/Meshes/" + mesh;
  const auto points = field(at + ".points", "default").get<std::vector<double>>();
  const auto indices = field(at + ".primvars:skel:jointIndices", "default").get<std::vector<std::size_t>>();
  const auto weights = field(at + ".primvars:skel:jointWeights", "default").get<std::vector<double>>();
  const Matrix4d placed = matrix_of(field(at + ".primvars:skel:geomBindTransform", "default"));
  const std::size_t width = indices.size() / (points.size() / 3);
  std::vector<Vector3d> result;
  for (std::size_t i = 0; i < points.size() / 3; ++i) {
    const Eigen::Vector4d place(points[3 * i], points[3 * i + 1], points[3 * i + 2], 1.0);
    Eigen::Vector4d sum = Eigen::Vector4d::Zero();
    for (std::size_t w = width * i; w < width * (i + 1); ++w)
      sum += weights[w] * (pose[indices[w]] * matrix_of(bind, indices[w]).inverse() * placed * place);
    result.push_back((to_world * sum).head<3>());
  }
  return result;
}

// This viewer also applies morph targets; a file without any shows plain skinning.
std::vector<Vector3d> skinned_by_gltf(const fs::path& character, double time) {
  return GltfViewer(character).shown(0, time);
}

TEST(UsdSkel, IsSkinningByTheFilesSkeleton) {
  FASCICLE_NEEDS_NODE_READERS;
  const TemporaryFolder folder;
  bake::BakeOptions options = options_for(folder / "out");
  options.formats = {"usda"};
  options.first_number = 1001;
  options.usd_skel = true;
  bake_jointed(options, 6);
  const json usd = read_usd(folder / "out/surface.usda");
  EXPECT_EQ(usd["specs"]["/body/Skinning"]["typeName"], "SkelRoot");
  EXPECT_EQ(usd["specs"]["/body/Skinning.purpose"]["default"], "guide");
  EXPECT_EQ(usd["specs"]["/body/Skinning/Skeleton_0.joints"]["default"],
            (std::vector<std::string>{"root", "root/tip"}));
  EXPECT_EQ(usd["specs"]["/body/Skinning/Motion.rotations"]["timeSamples"]["times"],
            (std::vector<int>{1001, 1002, 1003, 1004, 1005, 1006, 1007}));
  for (std::size_t k = 0; k <= 6; ++k) {
    const std::vector<Vector3d> by_usd = skinned(usd, "/body/Skinning", "body", k),
                                by_gltf = skinned_by_gltf(
                                    folder / "out/character.glb",
                                    static_cast<double>(static_cast<float>(static_cast<double>(k) / 24.0)));
    ASSERT_EQ(by_usd.size(), by_gltf.size());
    for (std::size_t i = 0; i < by_usd.size(); ++i)
      EXPECT_LT((by_usd[i] - by_gltf[i]).norm(), skel_rounding) << "frame " << k << ", vertex " << i;
  }
  // The baked points are the same without the option.
  options.folder = folder / "plain";
  options.usd_skel = false;
  bake_jointed(options, 6);
  const std::string with = read_text(folder / "out/surface.usda"),
                    without = read_text(folder / "plain/surface.usda");
  EXPECT_EQ(without.find("Skel"), std::string::npos);
  const std::size_t from = with.find("    def SkelRoot"), end = with.rfind("\n    }\n}") + 7;
  ASSERT_NE(from, std::string::npos);
  EXPECT_EQ(with.substr(0, from) + with.substr(end), without);
  // So they are in an export of a finished bake.
  bake::export_bake({.bake = folder / "plain",
                     .folder = folder / "exported",
                     .formats = {"usda"},
                     .first_number = 1001,
                     .usd_skel = true});
  EXPECT_EQ(read_text(folder / "exported/surface.usda"), with);
}

TEST(UsdSkel, ObjectsAreBoundWhereTheFileHasThemInItsOwnAxes) {
  FASCICLE_NEEDS_NODE_READERS;
  const TemporaryFolder folder;
  write_dressed_frames(formats::format_named("usda").make(), folder / "", {.usd_skel = true});
  const json usd = read_usd(folder / "surface.usda");
  std::vector<Vector3d> shown;
  for (const char* mesh : {"Body_001", "Body_001_2"})
    for (const Vector3d& place : skinned(usd, "/body/Skinning", mesh, 1)) shown.push_back(place);
  ASSERT_EQ(shown.size(), 9u);
  // The file has no clip, so they stay in the bind pose, which is frame 0.
  for (std::size_t i = 0; i < shown.size(); ++i)
    for (std::size_t axis = 0; axis < 3; ++axis)
      EXPECT_NEAR(shown[i][static_cast<Eigen::Index>(axis)], dressed_point(0, i)[axis], skel_rounding) << i;
}

TEST(UsdSkel, TakesACharacter) {
  const TemporaryFolder folder;
  const model::Model model = two_tetrahedra();
  const model::Frame initial = turned(model, 0);
  const auto sink = formats::format_named("usda").make();
  EXPECT_THROW(sink->begin({.model = &model,
                            .folder = folder / "",
                            .scene_name = "s",
                            .fps = 8.0,
                            .start = 0.0,
                            .frames = 0,
                            .first = 0,
                            .initial = &initial,
                            .usd_skel = true}),
               bake::BakeError);
}

}  // namespace
}  // namespace fascicle::tests
