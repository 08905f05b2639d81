#include "host/gltf/gltf_rig.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <utility>

#include "host/base/errors.h"
#include "host/gltf/gltf_attributes.h"
#include "host/gltf/gltf_check.h"
#include "host/gltf/gltf_decode.h"
#include "host/gltf/gltf_document.h"
#include "host/gltf/gltf_images.h"
#include "host/gltf/gltf_library.h"
#include "host/gltf/gltf_material.h"
#include "host/gltf/gltf_parts.h"
#include "host/gltf/gltf_shapes.h"
#include "host/gltf/gltf_skeleton.h"
#include "host/gltf/gltf_weights.h"

namespace fascicle::gltf {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// A PNG of a single white pixel.
constexpr std::array<unsigned char, 67> white_pixel{
    0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0x00, 0x00, 0x0d, 0x49, 0x48, 0x44, 0x52, 0x00,
    0x00, 0x00, 0x01, 0x00, 0x00, 0x00, 0x01, 0x08, 0x00, 0x00, 0x00, 0x00, 0x3a, 0x7e, 0x9b, 0x55, 0x00,
    0x00, 0x00, 0x0a, 0x49, 0x44, 0x41, 0x54, 0x78, 0xda, 0x63, 0xf8, 0x0f, 0x00, 0x01, 0x01, 0x01, 0x00,
    0x1c, 0xb0, 0x8c, 0x99, 0x00, 0x00, 0x00, 0x00, 0x49, 0x45, 0x4e, 0x44, 0xae, 0x42, 0x60, 0x82};

void append_aligned(std::string& binary, const unsigned char* bytes, std::size_t count) {
  binary.resize((binary.size() + 7) / 8 * 8, '\0');
  binary.append(reinterpret_cast<const char*>(bytes), count);
}

void pack_images(const fs::path& path, GltfDocument& document, std::vector<std::string>& missing) {
  if (!document.json.contains("images")) return;
  std::size_t number = 0;
  ImagesBeside beside(path);
  const ImageBytes white =
      std::make_shared<const std::vector<unsigned char>>(white_pixel.begin(), white_pixel.end());
  std::map<ImageBytes, std::size_t> view_of;  // many images may name one file
  for (json& image : document.json["images"]) {
    const std::string pointer = "/images/" + std::to_string(number++) + "/uri";
    if (!image.is_object() || !image.contains("uri") || !image["uri"].is_string()) continue;
    const std::string uri = image["uri"];
    ImageBytes bytes = white;
    if (uri.starts_with("data:")) {
      bytes = std::make_shared<const std::vector<unsigned char>>(data_uri_bytes(uri));
      if (bytes->empty()) continue;
    } else {
      try {
        bytes = beside.read(pointer, uri);
      } catch (const base::SceneError&) {
        missing.push_back(uri);
      }
      // A view has at least one byte.
      if (bytes->empty()) {
        missing.push_back(uri);
        bytes = white;
      }
    }
    const auto [view, is_new] = view_of.try_emplace(bytes);
    if (is_new) view->second = add_view(document, bytes->data(), bytes->size());
    image.erase("uri");
    image["bufferView"] = view->second;
    const std::string type = media_type_of(*bytes);
    const std::string stated = uri.starts_with("data:") ? uri.substr(5, uri.find_first_of(";,") - 5) : "";
    image["mimeType"] =
        !type.empty() ? type
                      : json_text(json_member(image, "mimeType"), stated.empty() ? "image/jpeg" : stated);
  }
}

class RigReader {
 public:
  RigReader(const fs::path& path, const json& document, const tinygltf::Model& model)
      : path_(path), document_(document), model_(model), shape_limits_(model) {}

  Rig run(Still still) {
    const GltfParts found = find_parts(path_, model_, document_, still);
    const std::vector<std::int32_t> joint_of = read_skeleton(path_, model_, found, rig_.character);
    rig_.joint_node.resize(rig_.character.skeleton.size());
    for (std::size_t n = 0; n < joint_of.size(); ++n)
      if (joint_of[n] >= 0)
        rig_.joint_node[static_cast<std::size_t>(joint_of[n])] = static_cast<std::uint32_t>(n);
    for (const GltfPart& part : found.parts) rig_.parts.push_back(read_part(part, joint_of));
    return std::move(rig_);
  }

 private:
  std::vector<double> numbers(int accessor) const { return accessor_numbers(path_, model_, accessor); }

  static std::vector<Eigen::Vector3d> vectors(const std::vector<double>& values) {
    std::vector<Eigen::Vector3d> result;
    for (std::size_t i = 0; i + 2 < values.size(); i += 3)
      result.emplace_back(values[i], values[i + 1], values[i + 2]);
    return result;
  }

  // Reads the document, because the decoder's copy has no looks.
  int looks_accessor(std::size_t mesh, std::size_t primitive, const std::string& name, int type,
                     std::size_t count) const {
    const json& attributes = document_["meshes"][mesh]["primitives"][primitive]["attributes"];
    const auto found = attributes.find(name);
    if (found == attributes.end() || !found->is_number_unsigned()) return -1;
    const auto accessor = found->get<std::size_t>();
    if (accessor >= model_.accessors.size()) return -1;
    const tinygltf::Accessor& a = model_.accessors[accessor];
    return a.type == type && a.count == count ? static_cast<int>(accessor) : -1;
  }

  std::vector<Eigen::Vector2d> read_uvs(std::size_t mesh, std::size_t primitive, std::size_t count) {
    const json& materials = json_member(document_, "materials");
    const auto material =
        json_index(json_member(document_["meshes"][mesh]["primitives"][primitive], "material"), materials);
    TextureUse use;
    if (material) {
      const auto [known, is_new] = texture_use_.try_emplace(*material);
      if (is_new) known->second = read_material(document_, materials[*material]).texture.value_or(use);
      use = known->second;
    }
    std::vector<Eigen::Vector2d> uvs;
    const int accessor =
        looks_accessor(mesh, primitive, "TEXCOORD_" + std::to_string(use.uv_set), TINYGLTF_TYPE_VEC2, count);
    if (accessor < 0) return uvs;
    const std::vector<double> values = numbers(accessor);
    for (std::size_t i = 0; i + 1 < values.size(); i += 2)
      uvs.emplace_back(use.transform * Eigen::Vector3d(values[i], values[i + 1], 1.0));
    return uvs;
  }

  RigPart read_part(const GltfPart& source, const std::vector<std::int32_t>& joint_of) {
    const std::size_t mesh = source.mesh, p = source.primitive;
    const tinygltf::Primitive& primitive = model_.meshes[mesh].primitives[p];
    RigPart part;
    part.node = static_cast<std::uint32_t>(source.node);
    part.mesh = static_cast<std::uint32_t>(mesh);
    part.primitive = static_cast<std::uint32_t>(p);
    const std::string pointer = "/meshes/" + std::to_string(mesh) + "/primitives/" + std::to_string(p);
    part.positions = vectors(read_positions(path_, model_, primitive, pointer));
    const std::size_t count = part.positions.size();
    if (const int accessor = looks_accessor(mesh, p, "NORMAL", TINYGLTF_TYPE_VEC3, count); accessor >= 0)
      part.normals = vectors(numbers(accessor));
    part.uvs = read_uvs(mesh, p, count);
    part.shapes = read_shapes(path_, model_, primitive, pointer, count, shape_limits_);
    part.rest_weights = rest_weights(document_, source.node, mesh, part.shapes.size());
    if (source.skin < 0) {
      part.skin_joint = {static_cast<std::uint32_t>(joint_of[static_cast<std::size_t>(source.carrier)])};
      part.inverse_bind = {source.to_carrier};
      part.slot.assign(count, 0);
      part.weight.assign(count, 1.0);
      for (std::size_t i = 0; i <= count; ++i) part.influence_offset.push_back(static_cast<std::uint32_t>(i));
      return part;
    }
    read_influences(source, joint_of, pointer, part);
    return part;
  }

  void read_influences(const GltfPart& source, const std::vector<std::int32_t>& joint_of,
                       const std::string& pointer, RigPart& part) const {
    const tinygltf::Primitive& primitive = model_.meshes[source.mesh].primitives[source.primitive];
    const tinygltf::Skin& skin = model_.skins[static_cast<std::size_t>(source.skin)];
    const std::size_t count = part.positions.size();
    std::vector<double> matrices;
    if (skin.inverseBindMatrices >= 0) matrices = numbers(skin.inverseBindMatrices);
    for (std::size_t k = 0; k < skin.joints.size(); ++k) {
      const auto node = static_cast<std::size_t>(skin.joints[k]);
      part.skin_joint.push_back(static_cast<std::uint32_t>(joint_of[node]));
      Eigen::Matrix4d inverse_bind = Eigen::Matrix4d::Identity();
      if (!matrices.empty()) inverse_bind = Eigen::Map<const Eigen::Matrix4d>(matrices.data() + 16 * k);
      part.inverse_bind.push_back(inverse_bind);
    }
    std::vector<InfluenceSet> sets;
    while (std::optional<InfluenceSet> set = read_influence_set(
               path_, model_, primitive, pointer, static_cast<int>(sets.size()), count, skin.joints.size()))
      sets.push_back(std::move(*set));
    part.influence_offset.push_back(0);
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t first = part.weight.size();
      double sum = 0.0;
      for (const InfluenceSet& set : sets)
        for (std::size_t k = 4 * i; k < 4 * i + 4; ++k) {
          if (set.weights[k] == 0.0) continue;
          part.slot.push_back(static_cast<std::uint32_t>(set.joints[k]));
          part.weight.push_back(set.weights[k]);
          sum += set.weights[k];
        }
      for (std::size_t k = first; k < part.weight.size(); ++k) part.weight[k] /= sum;
      part.influence_offset.push_back(static_cast<std::uint32_t>(part.weight.size()));
    }
  }

  const fs::path& path_;
  const json& document_;
  const tinygltf::Model& model_;
  Rig rig_;
  std::map<std::size_t, TextureUse> texture_use_;  // by material
  ShapeLimits shape_limits_;
};

}  // namespace

std::size_t add_view(GltfDocument& document, const unsigned char* bytes, std::size_t count) {
  append_aligned(document.binary, bytes, count);
  json& views = document.json["bufferViews"];
  views.push_back({{"buffer", 0}, {"byteOffset", document.binary.size() - count}, {"byteLength", count}});
  return views.size() - 1;
}

GltfDocument pack_gltf(const fs::path& path, std::vector<std::string>& missing, const fs::path& converter) {
  CheckedGltf checked = check_gltf(read_gltf_file(path, converter));
  const auto model = decode_gltf(checked);
  GltfDocument document{.json = std::move(checked.plain), .binary = {}};
  std::vector<std::size_t> offsets;
  for (const tinygltf::Buffer& buffer : model->buffers) {
    append_aligned(document.binary, buffer.data.data(), buffer.data.size());
    offsets.push_back(document.binary.size() - buffer.data.size());
  }
  for (json& view : document.json["bufferViews"]) {
    const std::size_t offset = view.contains("byteOffset") ? view["byteOffset"].get<std::size_t>() : 0;
    view["byteOffset"] = offsets.at(view["buffer"].get<std::size_t>()) + offset;
    view["buffer"] = 0;
  }
  repair_weights(path, *model, document);
  pack_images(path, document, missing);
  document.json["buffers"] = json::array({{{"byteLength", document.binary.size()}}});
  return document;
}

Rig read_rig(const fs::path& path, const fs::path& converter, Still still) {
  const CheckedGltf checked = check_gltf(read_gltf_file(path, converter));
  const auto model = decode_gltf(checked);
  return RigReader(path, checked.plain, *model).run(still);
}

std::vector<double> shape_weights(const RigPart& part, const rig::Clip* clip, double time) {
  if (clip != nullptr && !part.shapes.empty())
    for (const rig::WeightChannel& channel : clip->weights)
      if (channel.node == part.node) return rig::weights_at(channel, time);
  return part.rest_weights;
}

std::vector<Eigen::Vector3d> shaped_positions(const RigPart& part, const rig::Clip* clip, double time) {
  std::vector<Eigen::Vector3d> positions = part.positions;
  add_shapes(part.shapes, shape_weights(part, clip, time), positions);
  return positions;
}

}  // namespace fascicle::gltf
