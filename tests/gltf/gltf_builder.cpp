#include "tests/gltf/gltf_builder.h"

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <stdexcept>
#include <type_traits>

namespace fascicle::tests {

using nlohmann::json;

namespace {

template <typename T>
constexpr int component_type() {
  if constexpr (std::is_same_v<T, std::int8_t>) return 5120;
  if constexpr (std::is_same_v<T, std::uint8_t>) return 5121;
  if constexpr (std::is_same_v<T, std::int16_t>) return 5122;
  if constexpr (std::is_same_v<T, std::uint16_t>) return 5123;
  if constexpr (std::is_same_v<T, std::uint32_t>) return 5125;
  if constexpr (std::is_same_v<T, float>) return 5126;
}

std::size_t width(const std::string& type) {
  return type == "SCALAR" ? 1 : type == "MAT4" ? 16 : static_cast<std::size_t>(type.back() - '0');
}

void append(std::vector<unsigned char>& bytes, std::uint32_t value) {
  for (int shift = 0; shift < 32; shift += 8) bytes.push_back(static_cast<unsigned char>(value >> shift));
}

}  // namespace

template <typename T>
std::size_t GltfBuilder::add_view(const std::vector<T>& numbers) {
  while (bytes.size() % 4 != 0) bytes.push_back(0);
  const std::size_t offset = bytes.size(), length = numbers.size() * sizeof(T);
  bytes.resize(offset + length);
  std::memcpy(bytes.data() + offset, numbers.data(), length);
  document["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", offset}, {"byteLength", length}});
  return document["bufferViews"].size() - 1;
}

template <typename T>
std::size_t GltfBuilder::add(const std::string& type, const std::vector<T>& numbers, json more) {
  json accessor{{"bufferView", add_view(numbers)},
                {"componentType", component_type<T>()},
                {"type", type},
                {"count", numbers.size() / width(type)}};
  accessor.update(more);
  document["accessors"].push_back(std::move(accessor));
  return document["accessors"].size() - 1;
}

template std::size_t GltfBuilder::add(const std::string&, const std::vector<std::int8_t>&, json);
template std::size_t GltfBuilder::add(const std::string&, const std::vector<std::uint8_t>&, json);
template std::size_t GltfBuilder::add(const std::string&, const std::vector<std::int16_t>&, json);
template std::size_t GltfBuilder::add(const std::string&, const std::vector<std::uint16_t>&, json);
template std::size_t GltfBuilder::add(const std::string&, const std::vector<std::uint32_t>&, json);
template std::size_t GltfBuilder::add(const std::string&, const std::vector<float>&, json);
template std::size_t GltfBuilder::add_view(const std::vector<std::uint8_t>&);
template std::size_t GltfBuilder::add_view(const std::vector<float>&);

json GltfBuilder::with_data_uri() const {
  json result = document;
  result["buffers"] = json::array(
      {{{"byteLength", bytes.size()}, {"uri", "data:application/octet-stream;base64," + base64(bytes)}}});
  return result;
}

std::vector<unsigned char> GltfBuilder::glb() const {
  json with_length = document;
  with_length["buffers"] = json::array({{{"byteLength", bytes.size()}}});
  std::string text = with_length.dump();
  while (text.size() % 4 != 0) text += ' ';
  std::vector<unsigned char> binary = bytes;
  while (binary.size() % 4 != 0) binary.push_back(0);
  std::vector<unsigned char> file;
  append(file, 0x46546C67);
  append(file, 2);
  append(file, static_cast<std::uint32_t>(12 + 8 + text.size() + 8 + binary.size()));
  append(file, static_cast<std::uint32_t>(text.size()));
  append(file, 0x4E4F534A);
  file.insert(file.end(), text.begin(), text.end());
  append(file, static_cast<std::uint32_t>(binary.size()));
  append(file, 0x004E4942);
  file.insert(file.end(), binary.begin(), binary.end());
  return file;
}

GltfBuilder column() {
  GltfBuilder b;
  std::vector<float> positions, weights;
  std::vector<std::uint8_t> joints;
  for (int level = 0; level < 3; ++level) {
    for (int corner = 0; corner < 4; ++corner) {
      const float x = corner == 0 || corner == 3 ? -25.0f : 25.0f, y = corner < 2 ? -25.0f : 25.0f;
      positions.insert(positions.end(), {x, y, 100.0f * static_cast<float>(level)});
      joints.insert(joints.end(), {0, 1, 0, 0});
      const float upper = 0.5f * static_cast<float>(level);
      weights.insert(weights.end(), {1.0f - upper, upper, 0.0f, 0.0f});
    }
  }
  std::vector<std::uint16_t> corners;
  for (int level = 0; level < 2; ++level) {
    for (int side = 0; side < 4; ++side) {
      const int a = 4 * level + side, c = 4 * level + (side + 1) % 4;
      for (const int corner : {a, c, c + 4, a, c + 4, a + 4})
        corners.push_back(static_cast<std::uint16_t>(corner));
    }
  }
  // Column-major: raw centimetres with Z up to each joint's space (metres, Y up).
  const std::vector<float> inverse_bind{0.01f, 0, 0, 0, 0, 0, -0.01f, 0, 0, 0.01f, 0, 0, 0, 0,  0, 1,
                                        0.01f, 0, 0, 0, 0, 0, -0.01f, 0, 0, 0.01f, 0, 0, 0, -1, 0, 1};
  const float r = std::sqrt(0.5f);
  const std::size_t position = b.add("VEC3", positions), joint = b.add("VEC4", joints),
                    weight = b.add("VEC4", weights), index = b.add("SCALAR", corners),
                    matrices = b.add("MAT4", inverse_bind);
  const std::size_t times = b.add("SCALAR", std::vector<float>{0, 1});
  const std::size_t turns = b.add("VEC4", std::vector<float>{0, 0, 0, 1, 0, 0, r, r});
  const std::size_t moves = b.add("VEC3", std::vector<float>{0, 0, 0, 0, 2, 0});
  b.document["asset"] = {{"version", "2.0"}};
  b.document["scene"] = 0;
  b.document["scenes"] = json::parse(R"([{"nodes": [0, 3]}])");
  b.document["nodes"] = json::parse(R"([
    {"name": "armature", "children": [1]},
    {"name": "lower", "children": [2]},
    {"name": "upper", "translation": [0, 1, 0]},
    {"name": "body", "mesh": 0, "skin": 0, "translation": [50, 60, 70]}])");
  b.document["meshes"] = {
      {{"primitives",
        {{{"attributes", {{"POSITION", position}, {"JOINTS_0", joint}, {"WEIGHTS_0", weight}}},
          {"indices", index}}}}}};
  b.document["skins"] = {{{"joints", {1, 2}}, {"inverseBindMatrices", matrices}}};
  const auto clip = [&](const char* name, std::size_t output, int node, const char* path) {
    return json{{"name", name},
                {"samplers", json::array({{{"input", times}, {"output", output}}})},
                {"channels", json::array({{{"sampler", 0}, {"target", {{"node", node}, {"path", path}}}}})}};
  };
  b.document["animations"] = {clip("bend", turns, 2, "rotation"), clip("lift", moves, 1, "translation")};
  return b;
}

GltfBuilder column_with_shapes() {
  GltfBuilder b = column();
  std::vector<float> moves(36, 0.0f);
  moves[3 * 8 + 2] = 40.0f;
  moves[3 * 10] = 60.0f;
  const std::size_t first = b.add("VEC3", moves);
  const std::size_t indices = b.add_view(std::vector<std::uint8_t>{2, 9}),
                    values = b.add_view(std::vector<float>{0, 30, 0, -20, 0, 10});
  b.document["accessors"].push_back({{"componentType", 5126},
                                     {"type", "VEC3"},
                                     {"count", 12},
                                     {"sparse",
                                      {{"count", 2},
                                       {"indices", {{"bufferView", indices}, {"componentType", 5121}}},
                                       {"values", {{"bufferView", values}}}}}});
  const std::size_t second = b.document["accessors"].size() - 1;
  json& mesh = b.document["meshes"][0];
  mesh["primitives"][0]["targets"] = {{{"POSITION", first}}, {{"POSITION", second}}};
  mesh["weights"] = {0.25, 1.0};
  const std::size_t times = b.add("SCALAR", std::vector<float>{0, 0.5f, 1});
  const std::size_t weights = b.add("SCALAR", std::vector<float>{0, 1, 1, 0.5f, 0.25f, -0.5f});
  json& animation = b.document["animations"][0];
  animation["samplers"].push_back({{"input", times}, {"output", weights}});
  animation["channels"].push_back({{"sampler", 1}, {"target", {{"node", 3}, {"path", "weights"}}}});
  return b;
}

TemporaryFolder::TemporaryFolder() {
  std::string name = (std::filesystem::temp_directory_path() / "fascicle-XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder");
  path_ = name;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

std::filesystem::path TemporaryFolder::write(const std::string& name, const std::string& text) const {
  return write(name, std::vector<unsigned char>(text.begin(), text.end()));
}

std::filesystem::path TemporaryFolder::write(const std::string& name,
                                             const std::vector<unsigned char>& data) const {
  const std::filesystem::path path = path_ / name;
  std::filesystem::create_directories(path.parent_path());
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(data.data()), static_cast<std::streamsize>(data.size()));
  file.close();
  if (!file) throw std::runtime_error("cannot write " + path.string());
  return path;
}

std::string base64(const std::vector<unsigned char>& bytes) {
  static constexpr char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    for (std::size_t k = 0; k < 3; ++k) group = group << 8 | (k < count ? bytes[i + k] : 0u);
    for (std::size_t k = 0; k < 4; ++k) text += k <= count ? digits[group >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

}  // namespace fascicle::tests
