#include "host/gltf/gltf_attributes.h"

#include <cstdint>
#include <utility>

#include "host/gltf/gltf_decode.h"
#include "host/gltf/gltf_library.h"

namespace fascicle::gltf {

namespace {

bool is_small_unsigned(int component) {
  return component == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE ||
         component == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT;
}

}  // namespace

int attribute_accessor(const tinygltf::Primitive& primitive, const std::string& name) {
  const auto found = primitive.attributes.find(name);
  return found == primitive.attributes.end() ? -1 : found->second;
}

std::vector<double> attribute_numbers(const std::filesystem::path& path, const tinygltf::Model& model,
                                      const std::string& pointer, int accessor, int type, bool is_allowed,
                                      std::size_t count) {
  const tinygltf::Accessor& a = model.accessors[static_cast<std::size_t>(accessor)];
  if (a.type != type || !is_allowed) {
    gltf_error(path, pointer,
               "accessor " + std::to_string(accessor) + " has a type that glTF does not allow here");
  }
  if (count != 0 && a.count != count) {
    gltf_error(path, pointer,
               std::to_string(a.count) + " elements for " + std::to_string(count) + " positions");
  }
  return accessor_numbers(path, model, accessor);
}

std::vector<double> read_positions(const std::filesystem::path& path, const tinygltf::Model& model,
                                   const tinygltf::Primitive& primitive, const std::string& pointer) {
  const std::string position_pointer = pointer + "/attributes/POSITION";
  const int position = attribute_accessor(primitive, "POSITION");
  if (position < 0) gltf_error(path, position_pointer, "is missing");
  const int component = model.accessors[static_cast<std::size_t>(position)].componentType;
  return attribute_numbers(path, model, position_pointer, position, TINYGLTF_TYPE_VEC3,
                           component != TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT, 0);
}

std::optional<InfluenceSet> read_influence_set(const std::filesystem::path& path,
                                               const tinygltf::Model& model,
                                               const tinygltf::Primitive& primitive,
                                               const std::string& pointer, int set, std::size_t count,
                                               std::size_t joints) {
  const std::string joints_name = "JOINTS_" + std::to_string(set),
                    weights_name = "WEIGHTS_" + std::to_string(set);
  const int joints_accessor = attribute_accessor(primitive, joints_name),
            weights_accessor = attribute_accessor(primitive, weights_name);
  const std::string joints_pointer = pointer + "/attributes/" + joints_name;
  const std::string weights_pointer = pointer + "/attributes/" + weights_name;
  if (joints_accessor < 0 && weights_accessor < 0 && set > 0) return std::nullopt;
  for (const auto& [accessor, missing] :
       {std::pair(joints_accessor, &joints_pointer), std::pair(weights_accessor, &weights_pointer)})
    if (accessor < 0) gltf_error(path, *missing, "is missing; a skinned mesh needs joints and weights");

  const tinygltf::Accessor& j = model.accessors[static_cast<std::size_t>(joints_accessor)];
  const tinygltf::Accessor& w = model.accessors[static_cast<std::size_t>(weights_accessor)];
  InfluenceSet result;
  result.joints = attribute_numbers(path, model, joints_pointer, joints_accessor, TINYGLTF_TYPE_VEC4,
                                    is_small_unsigned(j.componentType) && !j.normalized, count);
  result.weights = attribute_numbers(path, model, weights_pointer, weights_accessor, TINYGLTF_TYPE_VEC4,
                                     w.componentType == TINYGLTF_COMPONENT_TYPE_FLOAT ||
                                         (is_small_unsigned(w.componentType) && w.normalized),
                                     count);
  for (std::size_t i = 0; i < 4 * count; ++i) {
    const std::string vertex = "vertex " + std::to_string(i / 4);
    if (result.weights[i] < 0.0) gltf_error(path, weights_pointer, vertex + " has a negative weight");
    if (result.weights[i] == 0.0) continue;  // the joint of a zero weight is ignored
    if (result.joints[i] >= static_cast<double>(joints)) {
      gltf_error(path, joints_pointer,
                 vertex + " follows joint " + std::to_string(static_cast<std::uint32_t>(result.joints[i])) +
                     " of a skin of " + std::to_string(joints));
    }
  }
  return result;
}

}  // namespace fascicle::gltf
