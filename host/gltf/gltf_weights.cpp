#include "host/gltf/gltf_weights.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "host/gltf/gltf_attributes.h"
#include "host/gltf/gltf_document.h"
#include "host/gltf/gltf_library.h"
#include "host/gltf/gltf_parts.h"
#include "host/gltf/gltf_triangles.h"
#include "host/gltf/weightless.h"

namespace fascicle::gltf {
namespace {

using nlohmann::json;

// Four numbers per vertex. Returns the accessor's index.
template <class Number>
std::size_t add_fours(GltfDocument& document, std::span<const Number> numbers, int component_type) {
  constexpr int array_buffer = 34962;
  const std::size_t view = add_view(document, reinterpret_cast<const unsigned char*>(numbers.data()),
                                    numbers.size() * sizeof(Number));
  document.json["bufferViews"][view]["target"] = array_buffer;
  json& accessors = document.json["accessors"];
  accessors.push_back({{"bufferView", view},
                       {"componentType", component_type},
                       {"count", numbers.size() / 4},
                       {"type", "VEC4"}});
  return accessors.size() - 1;
}

// The weights' sum of each vertex.
std::vector<double> sums_of(const std::vector<InfluenceSet>& sets, std::size_t count) {
  std::vector<double> sums(count, 0.0);
  for (const InfluenceSet& set : sets)
    for (std::size_t k = 0; k < 4 * count; ++k) sums[k / 4] += set.weights[k];
  return sums;
}

// Vertices that nothing connects with a weight keep none.
void repair(const std::vector<double>& sums, const std::vector<std::uint32_t>& source, InfluenceSet& set) {
  const InfluenceSet before = set;
  for (std::size_t i = 0; i < source.size(); ++i) {
    if (source[i] == no_vertex) continue;
    for (std::size_t k = 0; k < 4; ++k) {
      const std::size_t from = 4 * source[i] + k;
      set.weights[4 * i + k] = before.weights[from] / sums[source[i]];
      set.joints[4 * i + k] = before.weights[from] > 0.0 ? before.joints[from] : 0.0;
    }
  }
}

}  // namespace

void repair_weights(const std::filesystem::path& path, const tinygltf::Model& model, GltfDocument& document) {
  std::set<std::pair<std::size_t, std::size_t>> done;  // nodes may share a mesh
  for (const GltfPart& part : find_parts(path, model, document.json, Still::left_out).parts) {
    if (part.skin < 0 || !done.insert({part.mesh, part.primitive}).second) continue;
    const tinygltf::Primitive& primitive = model.meshes[part.mesh].primitives[part.primitive];
    const std::string pointer =
        "/meshes/" + std::to_string(part.mesh) + "/primitives/" + std::to_string(part.primitive);
    const std::size_t count = read_positions(path, model, primitive, pointer).size() / 3;
    const std::size_t joints = model.skins[static_cast<std::size_t>(part.skin)].joints.size();
    std::vector<InfluenceSet> sets;
    while (auto set = read_influence_set(path, model, primitive, pointer, static_cast<int>(sets.size()),
                                         count, joints))
      sets.push_back(std::move(*set));
    const std::vector<double> sums = sums_of(sets, count);
    if (std::all_of(sums.begin(), sums.end(),
                    [](double sum) { return std::abs(sum - 1.0) <= weight_sum_tolerance; }))
      continue;
    std::vector<bool> has_weights;
    for (const double sum : sums) has_weights.push_back(sum > 0.0);
    const std::vector<std::uint32_t> source =
        weighted_neighbours(has_weights, read_triangles(path, model, primitive, pointer, count));
    for (std::size_t k = 0; k < sets.size(); ++k) {
      repair(sums, source, sets[k]);
      const std::vector<std::uint16_t> numbers(sets[k].joints.begin(), sets[k].joints.end());
      const std::vector<float> weights(sets[k].weights.begin(), sets[k].weights.end());
      json& attributes = document.json["meshes"][part.mesh]["primitives"][part.primitive]["attributes"];
      attributes["JOINTS_" + std::to_string(k)] =
          add_fours<std::uint16_t>(document, numbers, TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT);
      attributes["WEIGHTS_" + std::to_string(k)] =
          add_fours<float>(document, weights, TINYGLTF_COMPONENT_TYPE_FLOAT);
    }
  }
}

}  // namespace fascicle::gltf
