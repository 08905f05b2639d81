#include "tests/gltf/gltf_viewer.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <utility>

#include <Eigen/Geometry>

namespace fascicle::tests {

using Eigen::Matrix4d;
using Eigen::Vector3d;
using nlohmann::json;

namespace {

double number_at(const unsigned char* at, int type) {
  float f = 0.0f;
  std::uint32_t u = 0;
  std::int16_t s = 0;
  switch (type) {
    case 5120:
      return static_cast<signed char>(*at);
    case 5122:
      std::memcpy(&s, at, 2);
      return s;
    case 5126:
      std::memcpy(&f, at, 4);
      return static_cast<double>(f);
    case 5125:
      std::memcpy(&u, at, 4);
      return u;
    case 5123:
      std::memcpy(&u, at, 2);
      return u;
    default:
      return *at;
  }
}

std::size_t bytes_of(int type) {
  return type == 5126 || type == 5125 ? 4 : type == 5123 || type == 5122 ? 2 : 1;
}

// The value of an integer type that means 1 when normalised.
double largest_of(int type) {
  return type == 5120 ? 127.0 : type == 5121 ? 255.0 : type == 5122 ? 32767.0 : 65535.0;
}

}  // namespace

GltfViewer::GltfViewer(const std::filesystem::path& glb) {
  std::ifstream file(glb, std::ios::binary);
  const std::vector<char> all((std::istreambuf_iterator<char>(file)), {});
  std::uint32_t length = 0;
  std::memcpy(&length, all.data() + 12, 4);
  document = json::parse(all.begin() + 20, all.begin() + 20 + length);
  binary_.assign(all.begin() + 28 + length, all.end());
  find_parents();
}

GltfViewer::GltfViewer(json of, std::vector<unsigned char> binary)
    : document(std::move(of)), binary_(std::move(binary)) {
  find_parents();
}

void GltfViewer::find_parents() {
  parents_.assign(document["nodes"].size(), -1);
  for (std::size_t i = 0; i < parents_.size(); ++i)
    for (const int child : document["nodes"][i].value("children", std::vector<int>{}))
      parents_[static_cast<std::size_t>(child)] = static_cast<int>(i);
}

std::vector<double> GltfViewer::numbers(const json& accessor) const {
  const json& a = document["accessors"][accessor.get<std::size_t>()];
  const std::string shape = a["type"];
  const std::size_t width = shape == "SCALAR" ? 1
                            : shape == "MAT4" ? 16
                                              : static_cast<std::size_t>(shape[3] - '0');
  const int type = a["componentType"];
  const std::size_t size = bytes_of(type), count = a["count"];
  std::vector<double> result(count * width, 0.0);
  const auto start = [&](const json& of) {
    const json& view = document["bufferViews"][of["bufferView"].get<std::size_t>()];
    return binary_.data() + view.value("byteOffset", 0u) + of.value("byteOffset", 0u);
  };
  if (a.contains("bufferView")) {
    const json& view = document["bufferViews"][a["bufferView"].get<std::size_t>()];
    const std::size_t stride = view.value("byteStride", size * width);
    for (std::size_t i = 0; i < count * width; ++i)
      result[i] = number_at(start(a) + i / width * stride + i % width * size, type);
  }
  if (a.contains("sparse")) {
    const json &indices = a["sparse"]["indices"], &values = a["sparse"]["values"];
    const int index_type = indices["componentType"];
    for (std::size_t k = 0; k < a["sparse"]["count"].get<std::size_t>(); ++k) {
      const auto at =
          static_cast<std::size_t>(number_at(start(indices) + k * bytes_of(index_type), index_type));
      for (std::size_t c = 0; c < width; ++c)
        result[at * width + c] = number_at(start(values) + (k * width + c) * size, type);
    }
  }
  if (a.value("normalized", false))
    for (double& number : result) number = std::max(number / largest_of(type), -1.0);
  return result;
}

std::vector<double> GltfViewer::morphed(const json& primitive, const std::string& attribute,
                                        const std::vector<double>& weights) const {
  std::vector<double> values = numbers(primitive["attributes"][attribute]);
  const json targets = primitive.value("targets", json::array());
  for (std::size_t k = 0; k < targets.size(); ++k) {
    if (!targets[k].contains(attribute)) continue;
    const std::vector<double> moves = numbers(targets[k][attribute]);
    for (std::size_t i = 0; i < values.size(); ++i) values[i] += weights[k] * moves[i];
  }
  return values;
}

std::vector<double> GltfViewer::weights(int clip, double time, std::size_t node) const {
  const json& mesh = document["meshes"][document["nodes"][node]["mesh"].get<std::size_t>()];
  const std::size_t count = mesh["primitives"][0].value("targets", json::array()).size();
  return value(clip, time, node, "weights", mesh.value("weights", std::vector<double>(count, 0.0)));
}

std::vector<Vector3d> GltfViewer::raw_normals(int clip, double time) const {
  std::vector<Vector3d> result;
  for (std::size_t n = 0; n < parents_.size(); ++n) {
    if (!document["nodes"][n].contains("mesh")) continue;
    const std::vector<double> shares = weights(clip, time, n);
    for (const json& primitive :
         document["meshes"][document["nodes"][n]["mesh"].get<std::size_t>()]["primitives"]) {
      const std::vector<double> values = morphed(primitive, "NORMAL", shares);
      for (std::size_t i = 0; i < values.size(); i += 3)
        result.emplace_back(values[i], values[i + 1], values[i + 2]);
    }
  }
  return result;
}

std::vector<double> GltfViewer::value(int clip, double time, std::size_t node, const std::string& path,
                                      std::vector<double> fallback) const {
  const json& n = document["nodes"][node];
  if (clip >= 0) {
    const json& animation = document["animations"][static_cast<std::size_t>(clip)];
    for (const json& channel : animation["channels"]) {
      if (channel["target"]["node"] != node || channel["target"]["path"] != path) continue;
      const json& sampler = animation["samplers"][channel["sampler"].get<std::size_t>()];
      const std::vector<double> times = numbers(sampler["input"]), values = numbers(sampler["output"]);
      const std::size_t width = fallback.size();
      const auto at = [&](std::size_t k) {
        const auto from = values.begin() + static_cast<std::ptrdiff_t>(k * width);
        return std::vector<double>(from, from + static_cast<std::ptrdiff_t>(width));
      };
      if (time <= times.front()) return at(0);
      if (time >= times.back()) return at(times.size() - 1);
      std::size_t k = 0;
      while (times[k + 1] <= time) ++k;
      if (sampler.value("interpolation", "LINEAR") == "STEP") return at(k);
      const double u = (time - times[k]) / (times[k + 1] - times[k]);
      std::vector<double> a = at(k), b = at(k + 1);
      if (path == "rotation") {
        const Eigen::Quaterniond from(a[3], a[0], a[1], a[2]), to(b[3], b[0], b[1], b[2]);
        const Eigen::Quaterniond q = from.normalized().slerp(u, to.normalized());
        return {q.x(), q.y(), q.z(), q.w()};
      }
      for (std::size_t c = 0; c < width; ++c) a[c] += u * (b[c] - a[c]);
      return a;
    }
  }
  return n.value(path, fallback);
}

Matrix4d GltfViewer::global(int clip, double time, std::size_t node) const {
  const json& n = document["nodes"][node];
  Matrix4d local = Matrix4d::Identity();
  if (n.contains("matrix")) {
    local = Eigen::Map<const Matrix4d>(n["matrix"].get<std::vector<double>>().data());
  } else {
    const std::vector<double> q = value(clip, time, node, "rotation", {0, 0, 0, 1}),
                              s = value(clip, time, node, "scale", {1, 1, 1}),
                              t = value(clip, time, node, "translation", {0, 0, 0});
    local.topLeftCorner<3, 3>() = Eigen::Quaterniond(q[3], q[0], q[1], q[2]).normalized().toRotationMatrix() *
                                  Vector3d(s[0], s[1], s[2]).asDiagonal();
    local.topRightCorner<3, 1>() = Vector3d(t[0], t[1], t[2]);
  }
  const int parent = parents_[node];
  return parent < 0 ? local : Matrix4d(global(clip, time, static_cast<std::size_t>(parent)) * local);
}

std::vector<Matrix4d> GltfViewer::maps(int clip, double time, std::size_t n) const {
  const json& node = document["nodes"][n];
  if (!node.contains("skin")) return {global(clip, time, n)};
  const json& skin = document["skins"][node["skin"].get<std::size_t>()];
  std::vector<Matrix4d> maps;
  std::vector<double> matrices;
  if (skin.contains("inverseBindMatrices")) matrices = numbers(skin["inverseBindMatrices"]);
  for (std::size_t k = 0; k < skin["joints"].size(); ++k) {
    maps.push_back(global(clip, time, skin["joints"][k]));
    if (!matrices.empty())
      maps.back() = (maps.back() * Eigen::Map<const Matrix4d>(matrices.data() + 16 * k)).eval();
  }
  return maps;
}

std::vector<Vector3d> GltfViewer::normals(int clip, double time) const {
  std::vector<Vector3d> result = raw_normals(clip, time);
  std::size_t at = 0;
  for (std::size_t n = 0; n < parents_.size(); ++n) {
    const json& node = document["nodes"][n];
    if (!node.contains("mesh")) continue;
    const std::vector<Matrix4d> maps = this->maps(clip, time, n);
    for (const json& primitive : document["meshes"][node["mesh"].get<std::size_t>()]["primitives"]) {
      const std::vector<double> joints = numbers(primitive["attributes"]["JOINTS_0"]),
                                weights = numbers(primitive["attributes"]["WEIGHTS_0"]);
      for (std::size_t i = 0; i < joints.size(); i += 4, ++at) {
        Eigen::Matrix3d blend = Eigen::Matrix3d::Zero();
        for (std::size_t k = i; k < i + 4; ++k)
          blend += weights[k] * maps[static_cast<std::size_t>(joints[k])].topLeftCorner<3, 3>();
        result[at] = (blend * result[at]).normalized();
      }
    }
  }
  return result;
}

std::vector<Vector3d> GltfViewer::shown(int clip, double time) const {
  std::vector<Vector3d> result;
  for (std::size_t n = 0; n < parents_.size(); ++n) {
    const json& node = document["nodes"][n];
    if (!node.contains("mesh")) continue;
    const json& mesh = document["meshes"][node["mesh"].get<std::size_t>()];
    const std::vector<Matrix4d> maps = this->maps(clip, time, n);
    const std::vector<double> shares = weights(clip, time, n);
    for (const json& primitive : mesh["primitives"]) {
      const json& attributes = primitive["attributes"];
      const std::vector<double> p = morphed(primitive, "POSITION", shares);
      std::vector<double> j, w;
      if (node.contains("skin")) {
        j = numbers(attributes["JOINTS_0"]);
        w = numbers(attributes["WEIGHTS_0"]);
      }
      for (std::size_t i = 0; i < p.size() / 3; ++i) {
        const Eigen::Vector4d raw(p[3 * i], p[3 * i + 1], p[3 * i + 2], 1);
        Eigen::Vector4d sum = w.empty() ? Eigen::Vector4d(maps[0] * raw) : Eigen::Vector4d::Zero();
        double weights = w.empty() ? 1.0 : 0.0;
        for (std::size_t k = 4 * i; k < 4 * i + 4 && !w.empty(); ++k) {
          sum += w[k] * (maps[static_cast<std::size_t>(j[k])] * raw);
          weights += w[k];
        }
        // Not all files have weights that sum to 1, as glTF requires; viewers divide by the sum.
        result.push_back(sum.head<3>() / weights);
      }
    }
  }
  return result;
}

}  // namespace fascicle::tests
