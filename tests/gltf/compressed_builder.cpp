#include "tests/gltf/compressed_builder.h"

#include <array>
#include <memory>
#include <stdexcept>

#include <draco/compression/expert_encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>
#include <meshoptimizer.h>

namespace fascicle::tests {

using nlohmann::json;

json with_meshopt(const GltfBuilder& b, const char* extension) {
  json document = b.document;
  std::vector<unsigned char> packed;
  const auto stride_of = [&](std::size_t view) -> std::size_t {
    for (const json& a : b.document["accessors"]) {
      if (!a.contains("bufferView") || a["bufferView"] != view) continue;
      const std::string type = a["type"];
      const std::size_t width = type == "SCALAR" ? 1
                                : type == "MAT4" ? 16
                                                 : static_cast<std::size_t>(type.back() - '0');
      const int component = a["componentType"];
      return width * (component == 5126 ? 4u : component == 5123 ? 2u : 1u);
    }
    return 0;
  };
  for (std::size_t v = 0; v < document["bufferViews"].size(); ++v) {
    json& view = document["bufferViews"][v];
    const std::size_t offset = view["byteOffset"], length = view["byteLength"], stride = stride_of(v);
    const unsigned char* from = b.bytes.data() + offset;
    const std::size_t count = length / stride;
    std::vector<unsigned char> bytes;
    json how{{"buffer", 0}, {"byteStride", stride}, {"count", count}};
    if (stride == 2) {
      std::vector<unsigned> indices;
      for (std::size_t i = 0; i < count; ++i)
        indices.push_back(from[2 * i] | static_cast<unsigned>(from[2 * i + 1]) << 8);
      bytes.resize(meshopt_encodeIndexBufferBound(count, 12));
      bytes.resize(meshopt_encodeIndexBuffer(bytes.data(), bytes.size(), indices.data(), count));
      how["mode"] = "TRIANGLES";
    } else {
      bytes.resize(meshopt_encodeVertexBufferBound(count, stride));
      bytes.resize(meshopt_encodeVertexBuffer(bytes.data(), bytes.size(), from, count, stride));
      how["mode"] = "ATTRIBUTES";
    }
    while (packed.size() % 4 != 0) packed.push_back(0);
    how["byteOffset"] = packed.size();
    how["byteLength"] = bytes.size();
    packed.insert(packed.end(), bytes.begin(), bytes.end());
    view["buffer"] = 1;
    view["extensions"][extension] = std::move(how);
  }
  document["buffers"] = json::array(
      {{{"byteLength", packed.size()}, {"uri", "data:application/octet-stream;base64," + base64(packed)}},
       {{"byteLength", b.bytes.size()}, {"extensions", {{extension, {{"fallback", true}}}}}}});
  document["extensionsUsed"] = {extension};
  document["extensionsRequired"] = {extension};
  return document;
}

namespace {

// The column's triangles as a Draco stream of positions (id 0), joints (1) and weights (2).
std::vector<unsigned char> draco_stream(const GltfBuilder& b, int method) {
  const auto view = [&](std::size_t accessor) {
    const json& of =
        b.document["bufferViews"][b.document["accessors"][accessor]["bufferView"].get<std::size_t>()];
    return b.bytes.data() + of["byteOffset"].get<std::size_t>();
  };
  draco::TriangleSoupMeshBuilder builder;
  const std::size_t corners = b.document["accessors"][3]["count"];
  builder.Start(static_cast<int>(corners / 3));
  const int position = builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
  const int joint = builder.AddAttribute(draco::GeometryAttribute::GENERIC, 4, draco::DT_UINT8);
  const int weight = builder.AddAttribute(draco::GeometryAttribute::GENERIC, 4, draco::DT_FLOAT32);
  for (std::size_t t = 0; t < corners / 3; ++t) {
    std::array<std::size_t, 3> v{};
    for (std::size_t k = 0; k < 3; ++k) v[k] = view(3)[2 * (3 * t + k)];
    const draco::FaceIndex face(static_cast<std::uint32_t>(t));
    const auto set = [&](int attribute, const unsigned char* from, std::size_t size) {
      builder.SetAttributeValuesForFace(attribute, face, from + v[0] * size, from + v[1] * size,
                                        from + v[2] * size);
    };
    set(position, view(0), 12);
    set(joint, view(1), 4);
    set(weight, view(2), 16);
  }
  const std::unique_ptr<draco::Mesh> mesh = builder.Finalize();
  draco::ExpertEncoder encoder(*mesh);
  encoder.SetEncodingMethod(method);
  draco::EncoderBuffer buffer;
  if (!encoder.EncodeToBuffer(&buffer).ok()) throw std::runtime_error("Draco did not encode the column");
  return {buffer.data(), buffer.data() + buffer.size()};
}

}  // namespace

GltfBuilder with_draco(int method) {
  GltfBuilder b = column();
  const std::size_t view = b.add_view(draco_stream(b, method));
  json& primitive = b.document["meshes"][0]["primitives"][0];
  primitive["extensions"][draco_name] = {
      {"bufferView", view}, {"attributes", {{"POSITION", 0}, {"JOINTS_0", 1}, {"WEIGHTS_0", 2}}}};
  // Accessors of Draco files have no data.
  for (const std::size_t accessor : {0u, 1u, 2u, 3u}) {
    b.document["accessors"][accessor].erase("bufferView");
    b.document["accessors"][accessor].erase("byteOffset");
  }
  b.document["extensionsUsed"] = {draco_name};
  b.document["extensionsRequired"] = {draco_name};
  return b;
}

}  // namespace fascicle::tests
