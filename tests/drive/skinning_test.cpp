// Skinning compared with an independent evaluation: a glTF file's own matrices, read here and multiplied in
// double, sum over joints of w_k G_k(t) IBM_k p.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <functional>
#include <iterator>
#include <map>
#include <optional>
#include <ostream>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "cpu_reference/solver/cpu_solver.h"
#include "host/drive/drive_source.h"
#include "host/gltf/gltf.h"
#include "host/scene/scene.h"
#include "tests/support/assets.h"

namespace fascicle::tests {

namespace {

using Eigen::Matrix4d;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using nlohmann::json;

// Minimal glTF reader for files with float or unsigned accessors in one binary chunk.
class Glb {
 public:
  explicit Glb(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    bytes_.assign(std::istreambuf_iterator<char>(file), {});
    const std::uint32_t length = word(12);
    document = json::parse(bytes_.substr(20, length));
    binary_ = 20 + length + 8;
  }

  std::vector<double> numbers(std::size_t accessor) const {
    const json& a = document["accessors"][accessor];
    const json& view = document["bufferViews"][a["bufferView"].get<std::size_t>()];
    const std::map<std::string, std::size_t> widths{{"SCALAR", 1}, {"VEC3", 3}, {"VEC4", 4}, {"MAT4", 16}};
    const std::size_t width = widths.at(a["type"]), type = a["componentType"], count = a["count"];
    const std::size_t size = type == 5126 || type == 5125 ? 4 : type == 5123 ? 2 : 1;
    const std::size_t stride = view.value("byteStride", width * size);
    const std::size_t start = binary_ + view.value("byteOffset", 0u) + a.value("byteOffset", 0u);
    std::vector<double> values;
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t c = 0; c < width; ++c) {
        const char* at = bytes_.data() + start + i * stride + c * size;
        if (type == 5126) {
          float f = 0.0f;
          std::memcpy(&f, at, 4);
          values.push_back(double{f});
        } else {
          std::uint32_t n = 0;
          std::memcpy(&n, at, size);
          values.push_back(static_cast<double>(n));
        }
      }
    return values;
  }

  json document;

 private:
  std::uint32_t word(std::size_t at) const {
    std::uint32_t value = 0;
    std::memcpy(&value, bytes_.data() + at, 4);
    return value;
  }
  std::string bytes_;
  std::size_t binary_ = 0;
};

struct Trs {
  Vector3d translation = Vector3d::Zero(), scale = Vector3d::Ones();
  Quaterniond rotation = Quaterniond::Identity();
};

// World matrices of all nodes: at rest, or at time t of the first animation with linear channels.
std::vector<Matrix4d> world_matrices(const Glb& glb, std::optional<double> time = {}) {
  const json& nodes = glb.document["nodes"];
  std::vector<Trs> trs(nodes.size());
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    if (nodes[n].contains("translation"))
      for (int c = 0; c < 3; ++c)
        trs[n].translation[c] = nodes[n]["translation"][static_cast<std::size_t>(c)];
    if (nodes[n].contains("scale"))
      for (int c = 0; c < 3; ++c) trs[n].scale[c] = nodes[n]["scale"][static_cast<std::size_t>(c)];
    if (nodes[n].contains("rotation")) {
      const json& r = nodes[n]["rotation"];
      trs[n].rotation = Quaterniond(r[3], r[0], r[1], r[2]);
    }
  }
  const json& animation = glb.document["animations"][0];
  for (const json& channel : animation["channels"]) {
    if (!time) break;
    const double t = *time;
    const json& sampler = animation["samplers"][channel["sampler"].get<std::size_t>()];
    const std::vector<double> times = glb.numbers(sampler["input"]), values = glb.numbers(sampler["output"]);
    const std::string path = channel["target"]["path"];
    const std::size_t width = path == "rotation" ? 4 : 3;
    std::size_t key = 0;
    while (key + 2 < times.size() && times[key + 1] <= t) ++key;
    const std::size_t next = std::min(key + 1, times.size() - 1);
    const double span = times[next] - times[key];
    const double u = span > 0.0 ? std::clamp((t - times[key]) / span, 0.0, 1.0) : 0.0;
    const auto value = [&](std::size_t k, std::size_t c) { return values[k * width + c]; };
    Trs& node = trs[channel["target"]["node"].get<std::size_t>()];
    if (path == "rotation") {
      const Quaterniond a(value(key, 3), value(key, 0), value(key, 1), value(key, 2));
      const Quaterniond b(value(next, 3), value(next, 0), value(next, 1), value(next, 2));
      node.rotation = a.normalized().slerp(u, b.normalized());
      continue;
    }
    Vector3d& target = path == "scale" ? node.scale : node.translation;
    for (std::size_t c = 0; c < 3; ++c)
      target[static_cast<int>(c)] = value(key, c) + u * (value(next, c) - value(key, c));
  }
  std::vector<Matrix4d> world(nodes.size(), Matrix4d::Identity());
  const std::function<void(std::size_t, const Matrix4d&)> walk = [&](std::size_t n, const Matrix4d& above) {
    Matrix4d local = Matrix4d::Identity();
    if (nodes[n].contains("matrix")) {
      for (std::size_t k = 0; k < 16; ++k)
        local(static_cast<int>(k % 4), static_cast<int>(k / 4)) = nodes[n]["matrix"][k];
    } else {
      local.topLeftCorner<3, 3>() =
          trs[n].rotation.normalized().toRotationMatrix() * trs[n].scale.asDiagonal();
      local.topRightCorner<3, 1>() = trs[n].translation;
    }
    world[n] = above * local;
    if (nodes[n].contains("children"))
      for (const json& child : nodes[n]["children"]) walk(child, world[n]);
  };
  for (const json& top : glb.document["scenes"][0]["nodes"]) walk(top, Matrix4d::Identity());
  return world;
}

// The first primitive of the first skinned mesh, skinned at time t.
std::vector<Vector3d> skinned_by_file(const Glb& glb, double t) {
  const std::vector<Matrix4d> world = world_matrices(glb, t);
  const json& nodes = glb.document["nodes"];
  const auto body =
      std::find_if(nodes.begin(), nodes.end(), [](const json& n) { return n.contains("skin"); });
  const json& skin = glb.document["skins"][(*body)["skin"].get<std::size_t>()];
  const json& attributes =
      glb.document["meshes"][(*body)["mesh"].get<std::size_t>()]["primitives"][0]["attributes"];
  const std::vector<double> inverse_bind = glb.numbers(skin["inverseBindMatrices"]);
  const std::vector<double> p = glb.numbers(attributes["POSITION"]),
                            joint = glb.numbers(attributes["JOINTS_0"]),
                            weight = glb.numbers(attributes["WEIGHTS_0"]);
  std::vector<Vector3d> points;
  for (std::size_t i = 0; i < p.size() / 3; ++i) {
    double sum = 0.0;
    for (std::size_t k = 0; k < 4; ++k) sum += weight[4 * i + k];
    const auto blended = [&](const auto& map_of, const Eigen::Vector4d& point) {
      Eigen::Vector4d q = Eigen::Vector4d::Zero();
      for (std::size_t k = 0; k < 4; ++k) {
        const auto j = static_cast<std::size_t>(joint[4 * i + k]);
        const Matrix4d inverse = Eigen::Map<const Matrix4d>(inverse_bind.data() + 16 * j);
        q += weight[4 * i + k] / sum * (map_of(skin["joints"][j].get<std::size_t>(), inverse) * point);
      }
      return q;
    };
    Eigen::Vector4d q(p[3 * i], p[3 * i + 1], p[3 * i + 2], 1.0);
    q = blended([&](std::size_t node, const Matrix4d& inverse) { return Matrix4d(world[node] * inverse); },
                q);
    points.emplace_back(q.head<3>());
  }
  return points;
}

// The render mesh itself as the body: every vertex kinematic, without neighbours.
model::Model model_of(const rig::Character& character) {
  model::Model m;
  m.vertex_count = static_cast<std::uint32_t>(character.surface.vertices.size());
  m.layers = {{"bone", 0.0, 1000.0, true}};
  m.joint_count = static_cast<std::uint32_t>(character.skeleton.size());
  m.ring_offset.assign(m.vertex_count + 1, 0);
  m.skin_offset = {0};
  Vector3d low = character.surface.vertices[0], high = low;
  for (const Vector3d& p : character.surface.vertices) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  m.unit = std::ldexp(1.0, std::ilogb((high - low).maxCoeff()));
  const Vector3d middle = low + (high - low) / 2.0;
  m.rest_origin = {middle.x(), middle.y(), middle.z()};
  for (std::uint32_t i = 0; i < m.vertex_count; ++i) {
    for (int c = 0; c < 3; ++c)
      m.rest.push_back(static_cast<float>((character.surface.vertices[i][c] - middle[c]) / m.unit));
    for (std::size_t k = 0; k < 8; ++k) {
      if (character.weights[i][k] == 0.0) continue;
      m.skin_joint.push_back(character.joints[i][k]);
      m.skin_weight.push_back(static_cast<float>(character.weights[i][k]));
    }
    m.skin_offset.push_back(static_cast<std::uint32_t>(m.skin_joint.size()));
    m.source_vertex.push_back(i);
    m.tag.push_back(shader::tag_kinematic);
  }
  m.mass.assign(m.vertex_count, 1.0);
  m.alpha.assign(m.vertex_count, 0.0f);
  m.beta.assign(m.vertex_count, 0.0f);
  m.fibre.assign(3 * std::size_t{m.vertex_count}, 0.0f);
  m.pull.assign(m.vertex_count, 1.0f);
  m.region_rest.assign(4 * std::size_t{m.vertex_count}, 0.0f);
  return m;
}

class Skinning : public ::testing::TestWithParam<const char*> {};

TEST_P(Skinning, IsTheFilesOwnToAMillionthOfTheHeight) {
  FASCICLE_NEEDS_ASSET(asset(GetParam()));
  const Glb glb(asset(GetParam()));
  scene::Scene scene;
  scene.geometry = gltf::read_gltf(asset(GetParam()));
  const auto& character = std::get<rig::Character>(scene.geometry);
  scene.fps = 60.0;
  scene.solver.substeps = 2;
  scene.end = 1.0;
  const model::Model model = model_of(character);
  model::check_model(model);
  drive::DriveSource drives(scene, model);
  const auto solver = cpu_reference::make_cpu_solver(model, {}, 2);
  solver->load(drives.initial_state());
  double height = 0.0;
  for (std::size_t c = 0; c < 3; ++c) {
    double low = 1e9, high = -1e9;
    for (const Vector3d& p : character.surface.vertices) {
      low = std::min(low, p[static_cast<int>(c)]);
      high = std::max(high, p[static_cast<int>(c)]);
    }
    height = std::max(height, high - low);
  }
  double moved = 0.0;
  const std::vector<Vector3d> first = skinned_by_file(glb, 0.0);
  for (std::uint64_t k = 1; k <= 40; ++k) {
    solver->submit(drives.drive(k), {.positions = true, .skinned = true});
    const model::Frame frame = solver->collect();
    if (k % 8 != 0) continue;
    const std::vector<Vector3d> expected = skinned_by_file(glb, static_cast<double>(k) / 60.0);
    ASSERT_LE(expected.size(), model.vertex_count);
    for (std::size_t i = 0; i < expected.size(); ++i) {
      Vector3d got, skinned;
      for (std::size_t c = 0; c < 3; ++c) {
        got[static_cast<int>(c)] = frame.origin[c] + model.unit * double{frame.positions[3 * i + c]};
        skinned[static_cast<int>(c)] = frame.origin[c] + model.unit * double{frame.skinned[3 * i + c]};
      }
      ASSERT_LT((got - expected[i]).norm(), 1e-6 * height) << "frame " << k << " vertex " << i;
      ASSERT_EQ(got, skinned);
      moved = std::max(moved, (expected[i] - first[i]).norm());
    }
  }
  EXPECT_GT(moved, 0.05 * height) << "the clip moves it";
}

INSTANTIATE_TEST_SUITE_P(Assets, Skinning,
                         ::testing::Values("CesiumMan.glb", "animals_pack_Fox.glb", "mh_fat.glb"),
                         [](const auto& of) { return std::filesystem::path(of.param).stem().string(); });

}  // namespace

}  // namespace fascicle::tests
