#include "host/build/rigid_parts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <set>
#include <utility>

#include <Eigen/Geometry>

#include "host/base/flat.h"
#include "host/base/nearest_name.h"
#include "host/base/text.h"
#include "host/build/carriers.h"
#include "host/build/message.h"
#include "host/build/skin_weights.h"
#include "host/build/surface_search.h"
#include "host/build/unions.h"
#include "host/scene/scene_table.h"

namespace fascicle::build {

namespace {

constexpr double hard_weight = 0.99, even_weights = 0.05;
constexpr double largest_rigid_share = 0.25, largest_inlay_share = 0.01;
// A hard part's weights are all but equal; with more rows than this it moves by their mean.
constexpr std::size_t most_rows_of_hard = 1000;
constexpr double rigid_share = 0.5, painted_rigid = 0.5;
// Flesh within this many of the body's edges of rigid skin is held.
constexpr double held_edges = 1.0;

// A connected part of a surface; vertices are numbers in the welded skin.
struct Part {
  std::uint32_t first = 0;  // its first vertex in the surface
  std::vector<std::uint32_t> vertices;
  double area = 0.0;
  std::map<std::uint32_t, double> mean;  // weights, by joint
  bool is_hard = false, is_even = false;

  std::uint32_t main_joint() const {
    return std::max_element(mean.begin(), mean.end(),
                            [](const auto& a, const auto& b) { return a.second < b.second; })
        ->first;
  }
};

void weigh(const SkinWeights& weights, Part& part) {
  for (const std::uint32_t v : part.vertices)
    for (const auto& [joint, w] : weight_row(weights, v))
      part.mean[joint] += w / static_cast<double>(part.vertices.size());
  const std::uint32_t main = part.main_joint();
  part.is_hard = part.is_even = true;
  for (const std::uint32_t v : part.vertices) {
    double of_main = 0.0, in_common = 0.0;
    for (const auto& [joint, w] : weight_row(weights, v)) {
      if (joint == main) of_main = w;
      in_common += std::min(w, part.mean[joint]);
    }
    part.is_hard = part.is_hard && of_main >= hard_weight;
    part.is_even = part.is_even && in_common >= 1.0 - even_weights;
  }
}

// `welded_vertex` maps each of the surface's vertices to the welded skin.
std::vector<Part> parts_of(const mesh::SurfaceMesh& surface, const std::vector<std::uint32_t>& welded_vertex,
                           const SkinWeights& weights) {
  Unions unions(surface.vertices.size());
  for (const auto& t : surface.triangles) unions.join(t[0], t[1]), unions.join(t[0], t[2]);
  std::vector<Part> parts;
  std::map<std::uint32_t, std::size_t> part_of;  // root, part
  for (std::uint32_t v = 0; v < surface.vertices.size(); ++v) {
    const auto [entry, is_new] = part_of.try_emplace(unions.find(v), parts.size());
    if (is_new) parts.emplace_back().first = v;
    parts[entry->second].vertices.push_back(welded_vertex[v]);
  }
  for (const auto& t : surface.triangles) {
    const Vector3d& a = surface.vertices[t[0]];
    parts[part_of[unions.find(t[0])]].area +=
        (surface.vertices[t[1]] - a).cross(surface.vertices[t[2]] - a).norm() / 2.0;
  }
  for (Part& part : parts) weigh(weights, part);
  return parts;
}

// Whether a part that is moved as a whole follows the mean of its weights.
bool follows_mean(const SkinWeights& weights, const Part& part) {
  if (!part.is_hard && !part.is_even) return false;
  std::set<WeightRow> rows;
  for (const std::uint32_t v : part.vertices) rows.insert(weight_row(weights, v));
  return rows.size() > (part.is_hard ? most_rows_of_hard : 1);
}

bool is_flat(const std::vector<Vector3d>& place, const Part& part) {
  std::vector<std::array<double, 3>> points;
  for (const std::uint32_t v : part.vertices) points.push_back({place[v][0], place[v][1], place[v][2]});
  return base::is_flat(points);
}

// Floors and walls: flat parts of one joint, each more than a quarter of the skin without larger ones.
struct Floors {
  std::vector<char> is_floor;  // per part
  double rest = 0.0;           // area of the other parts, m^2
};
Floors floors_among(const std::vector<Part>& parts, const std::vector<Vector3d>& place,
                    const std::vector<char>& simulated) {
  Floors floors{std::vector<char>(parts.size(), 0), 0.0};
  std::vector<std::size_t> by_area(parts.size());
  std::iota(by_area.begin(), by_area.end(), std::size_t{0});
  std::stable_sort(by_area.begin(), by_area.end(),
                   [&](std::size_t a, std::size_t b) { return parts[a].area > parts[b].area; });
  for (const Part& part : parts) floors.rest += part.area;
  std::size_t count = 0;
  for (const std::size_t k : by_area) {
    const Part& part = parts[k];
    if (!(part.area > largest_rigid_share * floors.rest)) break;
    if (!part.is_hard || simulated[part.main_joint()] || !is_flat(place, part)) continue;
    floors.is_floor[k] = 1;
    floors.rest -= part.area;
    ++count;
  }
  // Nothing but sheets is no body on a floor.
  if (count == parts.size()) floors = {std::vector<char>(parts.size(), 0), 0.0};
  return floors;
}

std::vector<Part> connected_parts_of(const mesh::SurfaceMesh& surface, const SkinWeights& weights) {
  std::vector<std::uint32_t> itself(surface.vertices.size());
  std::iota(itself.begin(), itself.end(), std::uint32_t{0});
  return parts_of(surface, itself, weights);
}

// Parts of the welded skin that are connected within one object and material; their first vertices are file
// numbers.
std::vector<Part> inlays_of(const rig::Character& character, const WeldedSurface& welded,
                            const SkinWeights& weights) {
  mesh::SurfaceMesh split;
  std::vector<std::uint32_t> welded_vertex, file_vertex;
  for (const rig::SurfacePart& part : character.parts) {
    std::map<std::uint32_t, std::uint32_t> number;  // welded, split
    for (std::uint32_t t = part.first_triangle; t < part.first_triangle + part.triangle_count; ++t) {
      std::array<std::uint32_t, 3> corners{};
      for (std::size_t c = 0; c < 3; ++c) {
        const std::uint32_t of_file = character.surface.triangles[t][c], v = welded.of_vertex[of_file];
        const auto [entry, is_new] = number.try_emplace(v, static_cast<std::uint32_t>(split.vertices.size()));
        if (is_new) {
          split.vertices.push_back(welded.surface.vertices[v]);
          welded_vertex.push_back(v);
          file_vertex.push_back(of_file);
        }
        corners[c] = entry->second;
      }
      split.triangles.push_back(corners);
    }
  }
  std::vector<Part> inlays = parts_of(split, welded_vertex, weights);
  for (Part& inlay : inlays) inlay.first = file_vertex[inlay.first];
  return inlays;
}

// The object of a vertex of the file, with its material if the object has several.
std::string name_of_vertex(const rig::Character& character, std::uint32_t vertex) {
  for (const rig::SurfacePart& part : character.parts)
    if (vertex >= part.first_vertex && vertex - part.first_vertex < part.vertex_count)
      return part.object + (part.material.empty() ? "" : " / " + part.material);
  return "the skin";
}

// The rigid skin that the user requested, one flag per vertex of the welded skin.
std::vector<char> asked_for(const rig::Character& character, const WeldedSurface& welded,
                            const SkinWeights& weights, const scene::Scene& scene) {
  std::vector<char> is_asked(welded.surface.vertices.size(), 0);
  std::vector<char> joints(character.skeleton.size(), 0);
  std::set<std::string> known;
  for (const rig::Joint& joint : character.skeleton) known.insert(joint.name);
  for (const rig::SurfacePart& part : character.parts) known.insert({part.object, part.material});
  known.erase("");
  for (const std::string& name : scene.skeleton.rigid) {
    if (!known.contains(name))
      fail(scene.source, "skeleton.rigid: no joint, object or material is called \"" + name + "\"" +
                             base::nearest_name_hint(name, {known.begin(), known.end()}) +
                             "; `fascicle inspect` lists the joints");
    for (std::size_t j = 0; j < joints.size(); ++j)
      if (character.skeleton[j].name == name) joints[j] = 1;
    for (const rig::SurfacePart& part : character.parts) {
      if (part.object != name && part.material != name) continue;
      for (std::uint32_t v = 0; v < part.vertex_count; ++v)
        is_asked[welded.of_vertex[part.first_vertex + v]] = 1;
    }
  }
  for (std::size_t j = 0; j < joints.size(); ++j)
    if (const std::int32_t parent = character.skeleton[j].parent; parent >= 0)
      joints[j] = joints[j] || joints[static_cast<std::size_t>(parent)];
  for (std::uint32_t v = 0; v < is_asked.size(); ++v) {
    double share = 0.0;
    for (const auto& [joint, w] : weight_row(weights, v)) share += joints[joint] ? w : 0.0;
    if (share >= rigid_share) is_asked[v] = 1;
  }
  for (const rig::PaintedAttribute& painted : character.painted) {
    if (painted.name != "_RIGID" || painted.width != 1) continue;
    for (std::size_t v = 0; v < painted.values.size(); ++v)
      if (painted.values[v] >= painted_rigid) is_asked[welded.of_vertex[v]] = 1;
  }
  return is_asked;
}

std::vector<char> with_all_below(const rig::Character& character, const std::vector<std::string>& names) {
  std::vector<char> is(character.skeleton.size(), 0);
  for (std::size_t j = 0; j < is.size(); ++j) {
    const rig::Joint& joint = character.skeleton[j];
    is[j] = std::find(names.begin(), names.end(), joint.name) != names.end() ||
            (joint.parent >= 0 && is[static_cast<std::size_t>(joint.parent)]);
  }
  return is;
}

bool is_robot(const std::vector<Part>& parts) {
  std::set<std::uint32_t> joints;
  for (const Part& part : parts) {
    if (!part.is_hard) return false;
    joints.insert(part.main_joint());
  }
  return parts.size() > 1 && joints.size() > 1;
}

}  // namespace

RigidSkin find_rigid_parts(const rig::Character& character, const WeldedSurface& welded,
                           const SkinWeights& weights, const scene::Scene& scene) {
  RigidSkin rigid;
  rigid.is_rigid = asked_for(character, welded, weights, scene);
  rigid.is_apart.assign(rigid.is_rigid.size(), 0);
  rigid.is_beside.assign(rigid.is_rigid.size(), 0);
  // For each vertex of the welded skin the file's first vertex, and how many there are.
  std::vector<std::uint32_t> first_of(rigid.is_rigid.size()), count_of(rigid.is_rigid.size(), 0);
  for (std::size_t v = welded.of_vertex.size(); v-- > 0;) {
    first_of[welded.of_vertex[v]] = static_cast<std::uint32_t>(v);
    ++count_of[welded.of_vertex[v]];
  }
  const auto in_file = [&](const std::vector<std::uint32_t>& vertices, auto counts) {
    std::uint32_t count = 0;
    for (const std::uint32_t v : vertices) count += counts(v) ? count_of[v] : 0u;
    return count;
  };
  const std::vector<char> simulated = with_all_below(character, scene.skeleton.simulated);
  const std::vector<Part> parts = connected_parts_of(welded.surface, weights);
  const bool all_hard = is_robot(parts);
  double all_area = 0.0;
  for (const Part& part : parts) all_area += part.area;
  const Floors floors = all_hard ? Floors{std::vector<char>(parts.size(), 0), 0.0}
                                 : floors_among(parts, welded.surface.vertices, simulated);
  // Where floors are most of the skin, they say nothing about the rest of it.
  const bool is_on_floors = floors.rest > 0.0 && floors.rest < all_area / 2.0;
  const double whole = is_on_floors ? floors.rest : all_area;
  std::vector<SharedRow> shared;
  for (std::size_t k = 0; k < parts.size(); ++k) {
    const Part& part = parts[k];
    const bool is_floor = floors.is_floor[k] != 0;
    const std::uint32_t joint = part.main_joint();
    const auto every = [](std::uint32_t) { return true; };
    const auto is_asked = [&](std::uint32_t v) { return rigid.is_rigid[v] != 0; };
    const std::size_t asked =
        static_cast<std::size_t>(std::count_if(part.vertices.begin(), part.vertices.end(), is_asked));
    const bool is_found =
        is_floor || (parts.size() > 1 && !simulated[joint] && (part.is_hard || part.is_even) &&
                     (all_hard || part.area <= largest_rigid_share * whole));
    if (asked == 0 && !is_found) continue;
    const bool is_whole = is_found || asked == part.vertices.size();
    RigidReport report{name_of_vertex(character, first_of[part.vertices.front()]),
                       character.skeleton[joint].name, "",
                       is_whole ? in_file(part.vertices, every) : in_file(part.vertices, is_asked)};
    if (asked == part.vertices.size())
      report.reason = "requested";
    else if (!is_found)
      report.reason = "requested; the rest of its part is soft";
    else if (is_floor)
      report.reason = "a separate part that is large and flat, moved by one joint";
    else if (all_hard)
      report.reason = "each part is moved by a single joint: a robot, which has no flesh";
    else
      report.reason = (part.is_hard ? "a separate part moved by one joint"
                                    : "a separate part moved by one blend of joints") +
                      std::string(", ") + base::percent_text(part.area / whole) + " of the skin";
    rigid.report.push_back(std::move(report));
    if (!is_whole) continue;
    const bool is_beside = (is_floor && is_on_floors) ||
                           (asked == part.vertices.size() && part.area > largest_rigid_share * all_area);
    for (const std::uint32_t v : part.vertices) {
      rigid.is_rigid[v] = rigid.is_apart[v] = 1;
      rigid.is_beside[v] = is_beside ? 1 : 0;
    }
    if (follows_mean(weights, part)) shared.push_back({part.vertices, {part.mean.begin(), part.mean.end()}});
  }
  rigid.weights = with_shared_rows(weights, shared);
  // Bones need some skin.
  if (std::all_of(rigid.is_beside.begin(), rigid.is_beside.end(), [](char is) { return is != 0; }))
    rigid.is_beside.assign(rigid.is_beside.size(), 0);
  for (const Part& inlay : inlays_of(character, welded, weights)) {
    const std::uint32_t joint = inlay.main_joint();
    const auto is_rigid = [&](std::uint32_t v) { return rigid.is_rigid[v] != 0; };
    if (!inlay.is_hard || inlay.area > largest_inlay_share * whole || simulated[joint] ||
        std::all_of(inlay.vertices.begin(), inlay.vertices.end(), is_rigid))
      continue;
    rigid.report.push_back({name_of_vertex(character, inlay.first), character.skeleton[joint].name,
                            "a patch of separate material moved by one joint, " +
                                base::percent_text(inlay.area / whole) + " of the skin",
                            in_file(inlay.vertices, [](std::uint32_t) { return true; })});
    for (const std::uint32_t v : inlay.vertices) rigid.is_rigid[v] = 1;
  }
  return rigid;
}

SoftSkin without_rigid_parts(const rig::Character& character, const WeldedSurface& welded,
                             const RigidSkin& rigid) {
  SoftSkin soft;
  soft.character.skeleton = character.skeleton;
  soft.character.clips = character.clips;
  soft.character.root = character.root;
  std::vector<std::uint32_t> number(character.surface.vertices.size()), of_welded(rigid.is_apart.size());
  for (std::uint32_t v = 0; v < rigid.is_apart.size(); ++v) {
    if (rigid.is_apart[v]) continue;
    of_welded[v] = static_cast<std::uint32_t>(soft.welded.surface.vertices.size());
    soft.welded.surface.vertices.push_back(welded.surface.vertices[v]);
  }
  for (const auto& t : welded.surface.triangles)
    if (!rigid.is_apart[t[0]])
      soft.welded.surface.triangles.push_back({of_welded[t[0]], of_welded[t[1]], of_welded[t[2]]});
  for (std::uint32_t v = 0; v < welded.of_vertex.size(); ++v) {
    if (rigid.is_apart[welded.of_vertex[v]]) continue;
    number[v] = static_cast<std::uint32_t>(soft.render_vertex.size());
    soft.render_vertex.push_back(v);
    soft.welded.of_vertex.push_back(of_welded[welded.of_vertex[v]]);
    soft.welded.file_vertex.push_back(v);
    soft.character.surface.vertices.push_back(character.surface.vertices[v]);
    soft.character.joints.push_back(character.joints[v]);
    soft.character.weights.push_back(character.weights[v]);
  }
  for (const auto& t : character.surface.triangles) {
    const auto is_soft = [&](std::uint32_t v) { return !rigid.is_apart[welded.of_vertex[v]]; };
    if (is_soft(t[0]) && is_soft(t[1]) && is_soft(t[2]))
      soft.character.surface.triangles.push_back({number[t[0]], number[t[1]], number[t[2]]});
  }
  return soft;
}

namespace {

double mean_side(const mesh::TetMesh& mesh) {
  double sum = 0.0;
  for (const auto& t : mesh.tetrahedra)
    for (std::size_t a = 0; a < 4; ++a)
      for (std::size_t b = 0; b < a; ++b) sum += (mesh.vertices[t[a]] - mesh.vertices[t[b]]).norm();
  return mesh.tetrahedra.empty() ? 0.0 : sum / (6.0 * static_cast<double>(mesh.tetrahedra.size()));
}

// Marks the flesh within `reach` of rigid skin.
void hold_flesh(const mesh::SurfaceMesh& surface, const std::vector<char>& is_rigid, double reach,
                Body& body) {
  mesh::SurfaceMesh hard{surface.vertices, {}};
  for (const auto& t : surface.triangles)
    if (is_rigid[t[0]] && is_rigid[t[1]] && is_rigid[t[2]]) hard.triangles.push_back(t);
  if (hard.triangles.empty()) return;
  const SurfaceSearch search(hard);
  for (std::size_t i = 0; i < body.mesh.vertices.size(); ++i)
    if (search.is_nearer_than(body.mesh.vertices[i], reach)) body.holding[i] = Holding::covered;
}

}  // namespace

void add_rigid_parts(const rig::Character& character, const WeldedSurface& welded, const RigidSkin& rigid,
                     const SoftSkin& soft, Body& body) {
  body.holding.assign(body.mesh.vertices.size(), Holding::none);
  hold_flesh(welded.surface, rigid.is_rigid, held_edges * mean_side(body.mesh), body);
  if (body.skin.offset.empty()) body.skin.offset.push_back(0);

  RenderMesh render;
  render.triangles = character.surface.triangles;
  render.corners.resize(welded.of_vertex.size());
  render.weights.resize(welded.of_vertex.size());
  for (std::size_t k = 0; k < soft.render_vertex.size(); ++k) {
    render.corners[soft.render_vertex[k]] = body.render.corners[k];
    render.weights[soft.render_vertex[k]] = body.render.weights[k];
  }
  body.render = std::move(render);
  seat_on_carriers(welded, rigid.weights, rigid.is_rigid, Sharing::exact, body);
}

}  // namespace fascicle::build
