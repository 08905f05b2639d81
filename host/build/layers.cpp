#include "host/build/layers.h"

#include <algorithm>
#include <limits>

#include "host/build/bone_layer.h"
#include "host/build/message.h"

namespace fascicle::build {

namespace {

constexpr std::size_t fewest_worth_simulating = 100;  // vertices
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
                             "from the bones), or use a finer mesh");
    warn_of_flesh(report, key + ": holds no vertex");
  }
}

// Warns if skeleton.only names a joint whose skin is narrower than the mesh's edges, which leaves almost
// nothing to simulate.
void check_only(const scene::Scene& scene, const std::vector<char>& kinematic, Report& report) {
  const std::vector<std::string>& only = scene.skeleton.only;
  const auto free = static_cast<std::size_t>(std::count(kinematic.begin(), kinematic.end(), 0));
  if (only.empty() || free >= fewest_worth_simulating) return;
  warn(report, "skeleton.only: only " + std::to_string(free) + " of " + std::to_string(kinematic.size()) +
                   " vertices are simulated; name the joint above " + only.front() +
                   ", or use a finer mesh (--resolution)");
}

bool is_painted(const scene::Shape& shape) {
  return std::holds_alternative<scene::Painted>(shape);
}

bool is_measured_from_bones(const scene::Shape& shape) {
  return std::holds_alternative<scene::BoneDistance>(shape) || std::holds_alternative<scene::Depth>(shape) ||
         std::holds_alternative<scene::VolumeShare>(shape);
}

bool has(const scene::Layer& layer, bool (*is_such)(const scene::Shape&)) {
  return std::any_of(layer.where.begin(), layer.where.end(), is_such);
}

// Assigns each vertex to the last layer whose shapes, painted or others, contain it.
void claim(const scene::Scene& scene, WhereTest& test, bool painted, std::vector<std::uint32_t>& layer_of) {
  for (std::uint32_t l = 0; l < scene.layers.size(); ++l) {
    scene::Where where;
    for (const scene::Shape& shape : scene.layers[l].where)
      if (is_painted(shape) == painted) where.push_back(shape);
    if (painted) {
      const scene::Where& by_paint = scene.layers[l].by_paint;
      where.insert(where.end(), by_paint.begin(), by_paint.end());
    }
    if (where.empty()) continue;
    const std::vector<char> inside = test.contains(where, "layers." + scene.layers[l].name, scene.source);
    for (std::size_t i = 0; i < inside.size(); ++i)
      if (inside[i]) layer_of[i] = l;
  }
}

std::vector<std::uint32_t> numbers_of(std::vector<std::uint32_t> vertices,
                                      const std::vector<std::uint32_t>& source_vertex) {
  for (std::uint32_t& v : vertices) v = source_vertex[v];
  std::sort(vertices.begin(), vertices.end());
  return vertices;
}

std::string name_of(const Body& body, const Bone& bone) {
  const auto name = [&](std::int32_t joint) {
    return joint < 0 ? std::string("the end") : body.joints[static_cast<std::size_t>(joint)].name;
  };
  return bone.owners[0] < 0 ? "a drawn bone" : name(bone.owners[0]) + " to " + name(bone.owners[2]);
}

bool is_of_rigid_member(const Body& body, std::size_t vertex) {
  return !body.members.empty() && body.members[member_of(body, vertex)].is_rigid;
}

void complete_bones(const scene::Scene& scene, Measures& measures, const OneRings& rings,
                    const std::vector<std::uint32_t>& source_vertex, const std::vector<char>& closed,
                    std::vector<std::uint32_t>& layer_of, Report& report) {
  const Body& body = measures.body();
  if (body.skin.offset.empty() || body.bones.empty()) return;
  std::uint32_t bone_layer = no_layer;
  for (std::uint32_t l = 0; l < scene.layers.size(); ++l)
    if (scene.layers[l].kinematic && has(scene.layers[l], is_measured_from_bones)) bone_layer = l;
  if (bone_layer == no_layer) return;

  // Vertices held by rigid parts are not bone and need not be connected to it.
  std::vector<char> is_bone(layer_of.size(), 0), is_closed(layer_of.size(), 0);
  for (std::size_t i = 0; i < is_bone.size(); ++i) {
    is_bone[i] = scene.layers[layer_of[i]].kinematic && holding_of(body, i) == Holding::none;
    is_closed[i] = closed[i] || !scene.skeleton.connect || holding_of(body, i) == Holding::carrier ||
                   is_of_rigid_member(body, i);
  }
  const std::vector<char> before = is_bone;
  const BoneLayerReport found = complete_bone_layer(measures, rings, is_closed, is_bone);
  for (std::size_t i = 0; i < is_bone.size(); ++i)
    if (is_bone[i] && !before[i]) layer_of[i] = bone_layer;

  report.bone_islands_before = static_cast<std::uint32_t>(found.islands_before);
  report.bone_islands = static_cast<std::uint32_t>(found.islands);
  report.bone_vertices_added = static_cast<std::uint32_t>(found.added);
  const std::string key = "layers." + scene.layers[bone_layer].name + ": ";
  if (!found.without.empty()) {
    std::string names;
    for (const std::uint32_t b : found.without)
      names += (names.empty() ? "" : ", ") + name_of(body, body.bones[b]);
    warn_of_flesh(report, key + counted(found.without.size(), "bone owns", "bones own") + " no vertex (" +
                              names + "); widen the layer, or use a finer mesh");
  }
  if (found.islands > 1) {
    std::string names;
    for (const std::uint32_t i : found.island_vertex) {
      const std::string name = name_of(body, body.bones[measures.nearest_bones()[i].bone]);
      if (names.find(name) == std::string::npos) names += (names.empty() ? "" : ", ") + name;
    }
    warn_of_flesh(
        report,
        key + "the bones of " + names +
            " are cut off from the rest: no chain of bone vertices joins them through the flesh; name the "
            "joints between in skeleton.bones, or use a finer mesh",
        numbers_of(found.island_vertex, source_vertex));
  }
}

bool is_implicit(const scene::Scene& scene) {
  return scene.solver.integrator == scene::Integrator::implicit_step;
}

std::vector<double> painted_stiffness(const scene::Scene& scene, Measures& measures,
                                      const std::vector<std::uint32_t>& layer_of) {
  std::vector<double> stiffer;
  if (!is_implicit(scene)) return stiffer;
  for (std::uint32_t l = 0; l < scene.layers.size(); ++l) {
    const scene::Layer& layer = scene.layers[l];
    if (layer.alpha_attribute.empty()) continue;
    const std::vector<double>& painted =
        measures.painted(layer.alpha_attribute, "layers." + layer.name + ".alpha_attribute", scene.source);
    if (stiffer.empty()) stiffer.assign(layer_of.size(), 1.0);
    for (std::size_t i = 0; i < stiffer.size(); ++i)
      if (layer_of[i] == l)
        stiffer[i] = std::clamp(painted[i], least_painted_stiffness, most_painted_stiffness);
  }
  return stiffer;
}

std::vector<double> alphas(const scene::Scene& scene, Measures& measures,
                           const std::vector<std::uint32_t>& layer_of) {
  std::vector<double> alpha(layer_of.size());
  for (std::size_t i = 0; i < alpha.size(); ++i) alpha[i] = scene.layers[layer_of[i]].alpha;
  for (std::uint32_t l = 0; l < scene.layers.size(); ++l) {
    const scene::Layer& layer = scene.layers[l];
    const std::string key = "layers." + layer.name;
    if (layer.alpha_outer) {
      if (measures.body().bones.empty())
        fail(scene.source,
             key +
                 ".alpha_outer: the layer's inner side faces the bones, but there are none; add bones, "
                 "or remove it");
      const bool by_distance = std::any_of(layer.where.begin(), layer.where.end(), [](const scene::Shape& s) {
        return std::holds_alternative<scene::BoneDistance>(s);
      });
      const std::vector<double>& outward = by_distance ? measures.bone_distances() : measures.depths();
      double inner = std::numeric_limits<double>::infinity(), outer = -inner;
      for (std::size_t i = 0; i < alpha.size(); ++i) {
        if (layer_of[i] != l) continue;
        inner = std::min(inner, outward[i]);
        outer = std::max(outer, outward[i]);
      }
      for (std::size_t i = 0; i < alpha.size(); ++i)
        if (layer_of[i] == l && outer > inner)
          alpha[i] += (*layer.alpha_outer - layer.alpha) * ((outward[i] - inner) / (outer - inner));
    }
    if (!layer.alpha_attribute.empty() && !is_implicit(scene)) {
      const std::vector<double>& painted =
          measures.painted(layer.alpha_attribute, key + ".alpha_attribute", scene.source);
      for (std::size_t i = 0; i < alpha.size(); ++i)
        if (layer_of[i] == l) alpha[i] *= std::clamp(painted[i], 0.0, 1.0);
    }
  }
  return alpha;
}

}  // namespace

Layering assign_layers(const scene::Scene& scene, WhereTest& test, Measures& measures, const OneRings& rings,
                       const std::vector<std::uint32_t>& source_vertex, Report& report) {
  if (scene.layers.empty()) fail(scene.source, "layers: at least one is needed");
  if (scene.layers.size() > shader::tag_layer_mask + std::size_t{1})
    fail(scene.source,
         "layers: " + std::to_string(scene.layers.size()) + " are too many; at most 256 are allowed");

  Layering result;
  std::uint32_t rest = no_layer;
  for (std::uint32_t l = 0; l < scene.layers.size(); ++l)
    if (scene.layers[l].where.empty()) rest = l;
  result.layer.assign(source_vertex.size(), rest);
  claim(scene, test, false, result.layer);
  std::vector<std::uint32_t> painted(result.layer.size(), no_layer);
  claim(scene, test, true, painted);
  std::vector<char> is_painted_on(painted.size(), 0);
  for (std::size_t i = 0; i < painted.size(); ++i) {
    if (painted[i] == no_layer) continue;
    is_painted_on[i] = 1;
    result.layer[i] = painted[i];
  }

  std::vector<std::uint32_t> unclaimed;
  for (std::size_t i = 0; i < result.layer.size(); ++i)
    if (result.layer[i] == no_layer) unclaimed.push_back(source_vertex[i]);
  std::sort(unclaimed.begin(), unclaimed.end());
  if (!unclaimed.empty())
    fail(scene.source,
         "layers: no layer covers " + counted(unclaimed.size(), "vertex", "vertices") + " (" +
             list_of(unclaimed) +
             "); widen a layer's shapes, or give one layer no shapes, so that it gets the rest");
  complete_bones(scene, measures, rings, source_vertex, is_painted_on, result.layer, report);
  check_layers_used(scene, result.layer, report);
  result.alpha = alphas(scene, measures, result.layer);
  result.stiffer = painted_stiffness(scene, measures, result.layer);

  result.kinematic.resize(result.layer.size());
  for (std::size_t i = 0; i < result.layer.size(); ++i)
    result.kinematic[i] = scene.layers[result.layer[i]].kinematic;
  for (std::size_t i = 0; i < result.kinematic.size(); ++i)
    if (holding_of(measures.body(), i) == Holding::carrier || is_of_rigid_member(measures.body(), i))
      result.kinematic[i] = 1;
  for (const scene::Pin& pin : scene.pins) {
    const std::vector<char> inside = test.contains(pin.where, "pins." + pin.name, scene.source);
    if (std::none_of(inside.begin(), inside.end(), [](char c) { return c != 0; }))
      fail(scene.source, "pins." + pin.name + ": holds no vertex; widen its shapes");
    for (std::size_t i = 0; i < inside.size(); ++i)
      if (inside[i]) result.kinematic[i] = 1;
  }
  check_only(scene, result.kinematic, report);
  return result;
}

}  // namespace fascicle::build
