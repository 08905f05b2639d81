#include "host/formats/glb_document.h"

#include <algorithm>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <utility>

#include "host/base/errors.h"
#include "host/base/text.h"
#include "host/formats/gltf_writer.h"

namespace fascicle::formats {

using nlohmann::json;

void drop_weight_channels(json& document, const std::vector<std::size_t>& meshes, std::size_t kept) {
  const std::set<std::size_t> of(meshes.begin(), meshes.end());
  const auto is_baked = [&](const json& target) {
    if (target.value("path", std::string()) != "weights") return false;
    if (!target.contains("node")) return true;
    const json& node = document["nodes"].at(target["node"].get<std::size_t>());
    return !node.contains("mesh") || of.contains(node["mesh"].get<std::size_t>());
  };
  json& animations = document["animations"];
  for (json& animation : animations) {
    json others = json::array();
    for (const json& channel : animation.value("channels", json::array()))
      if (!is_baked(channel.value("target", json::object()))) others.push_back(channel);
    animation["channels"] = std::move(others);
  }
  auto& list = animations.get_ref<json::array_t&>();
  const auto first = list.begin() + static_cast<std::ptrdiff_t>(std::min(kept, list.size()));
  list.erase(
      std::remove_if(first, list.end(), [](const json& animation) { return animation["channels"].empty(); }),
      list.end());
}

std::size_t primitive_count(const json& document, const gltf::Rig& rig) {
  std::size_t count = 0;
  for (std::size_t p = 0; p < rig.parts.size(); ++p) {
    const gltf::RigPart& part = rig.parts[p];
    if (p == 0 || part.node != rig.parts[p - 1].node)
      count += document["meshes"][part.mesh]["primitives"].size();
  }
  return count;
}

std::vector<std::size_t> own_meshes(json& document, const gltf::Rig& rig) {
  if (const std::size_t count = primitive_count(document, rig); count > most_primitives)
    throw base::BakeError("glb: the character's nodes show " + base::number_text(std::uint64_t{count}) +
                          " primitives; join meshes");
  std::vector<std::size_t> meshes;
  std::set<std::uint32_t> taken;
  for (std::size_t p = 0; p < rig.parts.size(); ++p) {
    const gltf::RigPart& part = rig.parts[p];
    if (p > 0 && part.node == rig.parts[p - 1].node) {
      meshes.push_back(meshes.back());
      continue;
    }
    std::size_t mesh = part.mesh;
    if (!taken.insert(part.mesh).second) {
      document["meshes"].push_back(json(document["meshes"][part.mesh]));
      mesh = document["meshes"].size() - 1;
      document["nodes"][part.node]["mesh"] = mesh;
    }
    meshes.push_back(mesh);
  }
  return meshes;
}

void add_still_targets(json& document, const gltf::Rig& rig, const std::vector<std::size_t>& meshes,
                       std::size_t count) {
  std::map<std::size_t, std::set<std::size_t>> in_rig;
  for (std::size_t p = 0; p < rig.parts.size(); ++p) in_rig[meshes[p]].insert(rig.parts[p].primitive);
  for (const auto& [mesh, primitives] : in_rig) {
    json& list = document["meshes"][mesh]["primitives"];
    for (std::size_t k = 0; k < list.size(); ++k) {
      if (primitives.contains(k) || !list[k]["attributes"].contains("POSITION")) continue;
      const std::size_t position = list[k]["attributes"]["POSITION"];
      const std::size_t still = add_still_accessor(document, document["accessors"][position]["count"]);
      list[k]["targets"] = std::vector<json>(count, json{{"POSITION", still}});
    }
  }
}

}  // namespace fascicle::formats
