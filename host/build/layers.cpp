#include "host/build/layers.h"

#include <algorithm>
#include <limits>

#include "host/build/message.h"

namespace fascicle::build {

namespace {

constexpr std::uint32_t no_layer = std::numeric_limits<std::uint32_t>::max();

void check_layers_used(const scene::Scene& scene, const std::vector<std::uint32_t>& layer, Report& report) {
  std::vector<std::size_t> vertices(scene.layers.size(), 0);
  for (const std::uint32_t l : layer) ++vertices[l];
  for (std::size_t l = 0; l < scene.layers.size(); ++l) {
    if (vertices[l] > 0) continue;
    const std::string key = "layers." + scene.layers[l].name;
    if (scene.layers[l].kinematic)
      fail(scene.source, key +
                             ": this kinematic layer holds no vertex; widen its shapes (a larger distance "
                             "from the bones), or "
                             "ask for a finer mesh");
    warn(report, key + ": holds no vertex");
  }
}

}  // namespace

Layering assign_layers(const scene::Scene& scene, WhereTest& test,
                       const std::vector<std::uint32_t>& source_vertex, Report& report) {
  if (scene.layers.empty()) fail(scene.source, "layers: at least one is needed");
  if (scene.layers.size() > shader::tag_layer_mask + std::size_t{1})
    fail(scene.source,
         "layers: " + std::to_string(scene.layers.size()) + " are more than the 256 there can be");

  Layering result;
  std::uint32_t rest = no_layer;
  for (std::uint32_t l = 0; l < scene.layers.size(); ++l)
    if (scene.layers[l].where.empty()) rest = l;
  result.layer.assign(source_vertex.size(), rest);
  for (std::uint32_t l = 0; l < scene.layers.size(); ++l) {
    const scene::Layer& layer = scene.layers[l];
    if (layer.where.empty()) continue;
    const std::vector<char> inside = test.contains(layer.where, "layers." + layer.name, scene.source);
    for (std::size_t i = 0; i < inside.size(); ++i)
      if (inside[i]) result.layer[i] = l;
  }

  std::vector<std::uint32_t> unclaimed;
  for (std::size_t i = 0; i < result.layer.size(); ++i)
    if (result.layer[i] == no_layer) unclaimed.push_back(source_vertex[i]);
  std::sort(unclaimed.begin(), unclaimed.end());
  if (!unclaimed.empty())
    fail(scene.source, "layers: no layer takes " + counted(unclaimed.size(), "vertex", "vertices") + " (" +
                           list_of(unclaimed) +
                           "); widen a layer's shapes, or give one layer none, which makes it take the rest");
  check_layers_used(scene, result.layer, report);

  result.kinematic.resize(result.layer.size());
  for (std::size_t i = 0; i < result.layer.size(); ++i)
    result.kinematic[i] = scene.layers[result.layer[i]].kinematic;
  for (const scene::Pin& pin : scene.pins) {
    const std::vector<char> inside = test.contains(pin.where, "pins." + pin.name, scene.source);
    if (std::none_of(inside.begin(), inside.end(), [](char c) { return c != 0; }))
      fail(scene.source, "pins." + pin.name + ": holds no vertex; widen its shapes");
    for (std::size_t i = 0; i < inside.size(); ++i)
      if (inside[i]) result.kinematic[i] = 1;
  }
  return result;
}

}  // namespace fascicle::build
