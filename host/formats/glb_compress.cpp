#include "host/formats/glb_compress.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <set>
#include <span>

#include <Eigen/Geometry>

#include "host/base/errors.h"
#include "host/base/text.h"
#include "host/formats/gltf_writer.h"
#include "host/gltf/gltf_codecs.h"
#include "host/gltf/gltf_material.h"

namespace fascicle::formats {

using Eigen::Matrix4d;
using Eigen::Vector3d;
using nlohmann::json;

namespace {

constexpr double most_steps = 32767.0;  // in either direction
constexpr double normal_steps = 127.0;
// The unit for normal offsets too large for 8 bits: a power of two, so that the floats compress well.
constexpr double turn_grain = 1.0 / 256.0;
constexpr int byte_type = 5120, short_type = 5122, float_type = 5126;

// Rounding moves a vertex by up to half a step along each axis.
double step_for(double bound, double stretch) {
  // Of joints of an absurd size, steps would be too short for moves to be whole numbers of them.
  constexpr double least_step = 1e-15, greatest_step = 1e15;
  const double step = 2.0 * bound / (std::sqrt(3.0) * stretch);
  return std::exp2(std::floor(std::log2(std::clamp(step, least_step, greatest_step))));
}

double bound_for(double step, double stretch) {
  return step * std::sqrt(3.0) / 2.0 * stretch;
}

template <class T>
void append_value(std::string& bytes, double value) {
  const auto number = static_cast<T>(value);
  bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
}

// Three values, padded to a multiple of 4 bytes.
void append_triple(std::string& bytes, int type, const std::array<double, 3>& values) {
  for (const double value : values) {
    if (type == float_type) append_value<float>(bytes, value);
    if (type == short_type) append_value<std::int16_t>(bytes, value);
    if (type == byte_type) append_value<std::int8_t>(bytes, value);
  }
  bytes.append(type == float_type ? 0 : type == short_type ? 2 : 1, '\0');
}

std::span<const unsigned char> as_bytes(const std::string& text) {
  return {reinterpret_cast<const unsigned char*>(text.data()), text.size()};
}

// Nodes on whose transform a joint, a clip, a child or a camera depends: they cannot take the dequantisation.
std::vector<bool> depended_on(const json& document) {
  const json& nodes = gltf::json_member(document, "nodes");
  std::vector<bool> is_needed;
  for (const json& n : nodes)
    is_needed.push_back(!n.value("children", json::array()).empty() || n.contains("camera") ||
                        n.contains("extensions"));
  for (const json& skin : document.value("skins", json::array()))
    for (const json& joint : skin["joints"]) is_needed.at(joint.get<std::size_t>()) = true;
  for (const json& animation : document.value("animations", json::array()))
    for (const json& channel : animation.value("channels", json::array())) {
      const json target = channel.value("target", json::object());
      if (target.contains("node") && target["path"] != "weights")
        is_needed.at(target["node"].get<std::size_t>()) = true;
    }
  return is_needed;
}

// The meshes and skins of nodes that have a primitive outside the rig, which would be shown at grid
// coordinates.
struct Outside {
  std::set<std::size_t> meshes;
  std::set<std::int64_t> skins;
};

Outside outside_rig(const json& document, const gltf::Rig& rig) {
  const json& nodes = gltf::json_member(document, "nodes");
  std::vector<std::size_t> parts(nodes.size(), 0);
  for (const gltf::RigPart& part : rig.parts) ++parts.at(part.node);
  Outside outside;
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    if (!nodes[n].contains("mesh")) continue;
    const std::size_t mesh = nodes[n]["mesh"];
    if (parts[n] == document["meshes"][mesh]["primitives"].size()) continue;
    outside.meshes.insert(mesh);
    outside.skins.insert(nodes[n].value("skin", std::int64_t{-1}));
  }
  return outside;
}

Matrix4d from_steps(double step, const Vector3d& origin) {
  Matrix4d map = Matrix4d::Identity();
  map.topLeftCorner<3, 3>() *= step;
  map.topRightCorner<3, 1>() = origin;
  return map;
}

// Adds dequantisation to the node's transform.
void place_steps(json& node, double step, const Vector3d& origin) {
  if (node.contains("matrix")) {
    auto numbers = node["matrix"].get<std::vector<double>>();
    const Matrix4d map = Eigen::Map<const Matrix4d>(numbers.data()) * from_steps(step, origin);
    node["matrix"] = std::vector<double>(map.data(), map.data() + 16);
    return;
  }
  const auto value = [&](const char* key, std::vector<double> fallback) {
    return node.value(key, std::move(fallback));
  };
  const std::vector<double> t = value("translation", {0, 0, 0}), s = value("scale", {1, 1, 1}),
                            r = value("rotation", {0, 0, 0, 1});
  const Eigen::Quaterniond rotation(r[3], r[0], r[1], r[2]);
  const Vector3d scale(s[0], s[1], s[2]);
  const Vector3d place =
      Vector3d(t[0], t[1], t[2]) + rotation.normalized() * Vector3d(scale.cwiseProduct(origin));
  node["translation"] = {place.x(), place.y(), place.z()};
  node["scale"] = {scale.x() * step, scale.y() * step, scale.z() * step};
}

std::size_t add_triples(gltf::GltfDocument& document, const std::string& bytes, int type, std::size_t count) {
  const std::size_t view = add_view(document, bytes);
  document.json["bufferViews"][view]["byteStride"] = bytes.size() / count;
  json& accessors = document.json["accessors"];
  accessors.push_back({{"bufferView", view}, {"componentType", type}, {"count", count}, {"type", "VEC3"}});
  return accessors.size() - 1;
}

double normal_step(double value) {
  return std::clamp(std::round(value * normal_steps), -normal_steps, normal_steps);
}

}  // namespace

GlbCompression::GlbCompression(const gltf::Rig& rig, const json& document, const std::vector<double>& stretch,
                               double bound)
    : rig_(rig), stretch_(stretch) {
  if (!gltf::has_meshopt())
    throw base::BakeError(
        "--glb-compress: this build of fascicle has no meshoptimizer; leave it out, or use a build "
        "that is not portable");
  choose_grids(document, stretch, bound);
}

void GlbCompression::choose_grids(const json& document, const std::vector<double>& stretch, double bound) {
  struct Group {
    Vector3d least = Vector3d::Constant(INFINITY), greatest = Vector3d::Constant(-INFINITY);
    double stretch = 0.0;
    std::set<std::size_t> meshes;
    bool has_steps = true;
  };
  const std::vector<bool> is_needed = depended_on(document);
  const Outside outside = outside_rig(document, rig_);
  std::map<std::int64_t, Group> groups;
  for (std::size_t p = 0; p < rig_.parts.size(); ++p) {
    const gltf::RigPart& part = rig_.parts[p];
    const json& node = document["nodes"][part.node];
    const bool has_skin = node.contains("skin");
    // Skins have numbers >= 0, unskinned nodes < 0.
    groups_.push_back(has_skin ? node["skin"].get<std::int64_t>() : -1 - std::int64_t{part.node});
    Group& group = groups[groups_.back()];
    group.meshes.insert(part.mesh);
    group.has_steps = has_skin || !is_needed[part.node];
    group.stretch = std::max(group.stretch, stretch[p]);
    for (const Vector3d& place : part.positions) {
      group.least = group.least.cwiseMin(place);
      group.greatest = group.greatest.cwiseMax(place);
    }
  }
  for (auto& [number, group] : groups) {
    const bool is_whole = std::none_of(group.meshes.begin(), group.meshes.end(),
                                       [&](std::size_t mesh) { return outside.meshes.contains(mesh); }) &&
                          (number < 0 || !outside.skins.contains(number));
    group.has_steps = group.has_steps && is_whole;
  }
  double least_bound = 0.0;
  for (const std::int64_t number : groups_) {
    const Group& group = groups[number];
    Grid grid{.has_steps = group.has_steps,
              .step = step_for(bound, group.stretch > 0.0 ? group.stretch : 1.0),
              .origin = Vector3d::Zero()};
    if (grid.has_steps) {
      const Vector3d middle = 0.5 * (group.least + group.greatest);
      for (int axis = 0; axis < 3; ++axis)
        grid.origin[axis] = grid.step * std::round(middle[axis] / grid.step);
      // One step less, because the middle is rounded to the grid.
      const double half = (0.5 * (group.greatest - group.least)).maxCoeff() / (most_steps - 1.0);
      if (half > grid.step)
        least_bound = std::max(least_bound, bound_for(std::exp2(std::ceil(std::log2(half))), group.stretch));
    }
    grids_.push_back(grid);
  }
  if (least_bound > 0.0)
    throw base::BakeError("--glb-compress " + base::number_text(bound) +
                          ": is finer than 16-bit coordinates allow for a body of this size; give at least " +
                          base::number_text(std::ceil(least_bound * 1e7) / 1e7));
}

std::size_t GlbCompression::view_of(Kind kind) {
  return kind == Kind::bytes ? 0 : kind == Kind::shorts ? 1 : 2;
}

int GlbCompression::type_of(Kind kind) {
  return kind == Kind::bytes ? byte_type : kind == Kind::shorts ? short_type : float_type;
}

double GlbCompression::largest(const std::vector<Steps>& values) {
  double most = 0.0;
  for (const Steps& value : values)
    for (const double x : value) most = std::max(most, std::abs(x));
  return most;
}

GlbCompression::Steps GlbCompression::steps_at(std::size_t part, const Vector3d& place) const {
  const Grid& grid = grids_[part];
  Steps steps{};
  for (int axis = 0; axis < 3; ++axis)
    steps[static_cast<std::size_t>(axis)] = std::round((place[axis] - grid.origin[axis]) / grid.step);
  return steps;
}

void GlbCompression::note_error(const GlbFrame& frame, std::size_t part, std::size_t vertex,
                                const Vector3d& off) {
  if (stretch_[part] * off.norm() <= error_) return;
  const Matrix4d blend = blend_of(rig_.parts[part], frame.slots[part], vertex);
  error_ = std::max(error_, (blend.topLeftCorner<3, 3>() * off).norm());
}

GlbCompression::PartSteps GlbCompression::steps_of(const GlbFrame& frame, std::size_t part,
                                                   std::size_t first) {
  const Grid& grid = grids_[part];
  const std::vector<Vector3d>&positions = rig_.parts[part].positions, &normals = rig_.parts[part].normals;
  PartSteps steps{.moves = std::vector<Steps>(positions.size()), .turns = std::vector<Steps>(normals.size())};
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const Vector3d move = frame.moved[first + i] != 0 ? vector_at(frame.moves, first + i) : Vector3d::Zero();
    const Vector3d from = grid.has_steps ? positions[i] : Vector3d::Zero();
    const Steps start = grid.has_steps ? steps_at(part, from) : Steps{}, end = steps_at(part, from + move);
    Vector3d shown;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      steps.moves[i][axis] = end[axis] - start[axis];
      const auto a = static_cast<Eigen::Index>(axis);
      shown[a] = grid.origin[a] + grid.step * end[axis];
    }
    note_error(frame, part, i, shown - (from + move));
    const Vector3d turn = vector_at(frame.turns, first + i);
    if (normals.empty() || turn.isZero(0.0)) continue;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<Eigen::Index>(axis);
      steps.turns[i][axis] = normal_step(normals[i][a] + turn[a]) - normal_step(normals[i][a]);
    }
  }
  return steps;
}

std::vector<GlbCompression::Steps> GlbCompression::grains_of(const GlbFrame& frame, std::size_t part,
                                                             std::size_t first) const {
  const std::vector<Vector3d>& normals = rig_.parts[part].normals;
  std::vector<Steps> turns(normals.size());
  for (std::size_t i = 0; i < normals.size(); ++i) {
    const Vector3d turn = vector_at(frame.turns, first + i);
    if (turn.isZero(0.0)) continue;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<Eigen::Index>(axis);
      const double from = normal_step(normals[i][a]) / normal_steps;
      turns[i][axis] = turn_grain * std::round((normals[i][a] + turn[a] - from) / turn_grain);
    }
  }
  return turns;
}

std::string GlbCompression::target(const GlbFrame& frame) {
  std::array<std::string, 3> plain;
  const auto put = [&](Kind kind, const std::vector<Steps>& values) {
    if (kind == Kind::none) return std::uint32_t{0};
    std::string& to = plain[view_of(kind)];
    const auto at = static_cast<std::uint32_t>(to.size());
    for (const Steps& value : values) append_triple(to, type_of(kind), value);
    return at;
  };
  std::size_t first = 0;
  for (std::size_t p = 0; p < rig_.parts.size(); ++p) {
    const Grid& grid = grids_[p];
    auto [moves, turns] = steps_of(frame, p, first);
    Piece piece;
    const double far = largest(moves), round = largest(turns);
    piece.moves = far == 0.0                            ? Kind::none
                  : !grid.has_steps || far > most_steps ? Kind::floats
                  : far > 127.0                         ? Kind::shorts
                                                        : Kind::bytes;
    piece.turns = round == 0.0 ? Kind::none : round > normal_steps ? Kind::floats : Kind::bytes;
    if (!grid.has_steps)
      for (Steps& move : moves)
        for (double& x : move) x *= grid.step;
    if (piece.turns == Kind::floats) turns = grains_of(frame, p, first);
    for (std::size_t axis = 0; axis < 3 && !moves.empty(); ++axis) {
      const auto by = [axis](const Steps& a, const Steps& b) { return a[axis] < b[axis]; };
      const auto [least, greatest] = std::minmax_element(moves.begin(), moves.end(), by);
      piece.least[axis] = (*least)[axis];
      piece.greatest[axis] = (*greatest)[axis];
    }
    piece.moves_at = put(piece.moves, moves);
    piece.turns_at = put(piece.turns, turns);
    pieces_.push_back(piece);
    first += moves.size();
  }
  std::string bytes;
  Target& target = targets_.emplace_back();
  for (std::size_t s = 0; s < strides.size(); ++s) {
    if (plain[s].empty()) continue;
    const std::vector<unsigned char> stream = gltf::encode_meshopt(as_bytes(plain[s]), strides[s]);
    target.views[s] = {.offset = stream_bytes_ + bytes.size(),
                       .bytes = stream.size(),
                       .count = plain[s].size() / strides[s],
                       .stride = strides[s]};
    bytes += packed_bytes(stream);
  }
  stream_bytes_ += bytes.size();
  return bytes;
}

std::size_t GlbCompression::add_positions(gltf::GltfDocument& document, std::size_t part) const {
  const std::vector<Vector3d>& positions = rig_.parts[part].positions;
  std::string bytes;
  Steps least, greatest;
  least.fill(INFINITY);
  greatest.fill(-INFINITY);
  for (const Vector3d& place : positions) {
    const Steps steps = steps_at(part, place);
    append_triple(bytes, short_type, steps);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      least[axis] = std::min(least[axis], steps[axis]);
      greatest[axis] = std::max(greatest[axis], steps[axis]);
    }
  }
  const std::size_t number = add_triples(document, bytes, short_type, positions.size());
  document.json["accessors"][number]["min"] = least;
  document.json["accessors"][number]["max"] = greatest;
  return number;
}

void GlbCompression::quantise(gltf::GltfDocument& document, const std::vector<std::size_t>& mesh) {
  // Primitives may share vertices: old accessor and grid to new accessor.
  std::map<std::pair<std::size_t, std::int64_t>, std::size_t> positions;
  std::map<std::size_t, std::size_t> normals;
  std::set<std::int64_t> placed;
  for (std::size_t p = 0; p < rig_.parts.size(); ++p) {
    const gltf::RigPart& part = rig_.parts[p];
    const std::size_t count = part.positions.size();
    const auto primitive = [&]() -> json& {
      return document.json["meshes"][mesh[p]]["primitives"][part.primitive];
    };
    for (const json& target : primitive().value("targets", json::array()))
      for (const json& number : target) perhaps_unused_.insert(number.get<std::size_t>());
    still_.push_back(add_still_accessor(document.json, count));
    if (!part.normals.empty()) {
      const std::size_t old = primitive()["attributes"]["NORMAL"];
      if (!normals.contains(old)) {
        std::string bytes;
        for (const Vector3d& normal : part.normals)
          append_triple(bytes, byte_type,
                        {normal_step(normal.x()), normal_step(normal.y()), normal_step(normal.z())});
        normals[old] = add_triples(document, bytes, byte_type, count);
        document.json["accessors"][normals[old]]["normalized"] = true;
      }
      primitive()["attributes"]["NORMAL"] = normals[old];
      perhaps_unused_.insert(old);
    }
    const Grid& grid = grids_[p];
    if (!grid.has_steps) continue;
    const std::size_t old = primitive()["attributes"]["POSITION"];
    const auto key = std::pair(old, groups_[p]);
    if (!positions.contains(key)) positions[key] = add_positions(document, p);
    primitive()["attributes"]["POSITION"] = positions[key];
    perhaps_unused_.insert(old);
    if (!placed.insert(groups_[p]).second) continue;
    json& node = document.json["nodes"][part.node];
    if (!node.contains("skin")) {
      place_steps(node, grid.step, grid.origin);
      continue;
    }
    std::vector<float> matrices;
    for (const Matrix4d& inverse_bind : part.inverse_bind) {
      const Matrix4d map = inverse_bind * from_steps(grid.step, grid.origin);
      for (Eigen::Index k = 0; k < 16; ++k) matrices.push_back(static_cast<float>(map.data()[k]));
    }
    json& skin = document.json["skins"][node["skin"].get<std::size_t>()];
    if (skin.contains("inverseBindMatrices"))
      perhaps_unused_.insert(skin["inverseBindMatrices"].get<std::size_t>());
    skin["inverseBindMatrices"] = add_accessor(document, std::span<const float>(matrices), 16);
  }
}

json GlbCompression::targets_of(std::size_t part, std::size_t first_accessor) const {
  json list = json::array();
  std::size_t number = first_accessor;
  for (std::size_t k = 0; k < pieces_.size(); ++k) {
    const Piece& piece = pieces_[k];
    const std::size_t moves = piece.moves == Kind::none ? 0 : 1, turns = piece.turns == Kind::none ? 0 : 1;
    if (k % rig_.parts.size() == part) {
      json target{{"POSITION", moves == 1 ? number : still_[part]}};
      if (!rig_.parts[part].normals.empty()) target["NORMAL"] = turns == 1 ? number + moves : still_[part];
      list.push_back(std::move(target));
    }
    number += moves + turns;
  }
  return list;
}

std::string GlbCompression::accessors(std::size_t first_view) const {
  std::string text;
  std::size_t view = first_view;
  for (std::size_t t = 0; t < targets_.size(); ++t) {
    std::array<std::size_t, 3> number{};
    for (std::size_t s = 0; s < strides.size(); ++s)
      if (targets_[t].views[s].count > 0) number[s] = view++;
    for (std::size_t p = 0; p < rig_.parts.size(); ++p) {
      const Piece& piece = pieces_[t * rig_.parts.size() + p];
      const auto add = [&](Kind kind, std::uint32_t at, const std::string& more) {
        if (kind == Kind::none) return;
        text += ",{\"bufferView\":" + base::number_text(number[view_of(kind)]) +
                ",\"byteOffset\":" + base::number_text(at) +
                ",\"componentType\":" + base::number_text(type_of(kind)) +
                ",\"count\":" + base::number_text(rig_.parts[p].positions.size()) + ",\"type\":\"VEC3\"" +
                more + '}';
      };
      const auto triple = [](const std::array<double, 3>& v) {
        return '[' + base::number_text(static_cast<float>(v[0])) + ',' +
               base::number_text(static_cast<float>(v[1])) + ',' +
               base::number_text(static_cast<float>(v[2])) + ']';
      };
      add(piece.moves, piece.moves_at,
          ",\"min\":" + triple(piece.least) + ",\"max\":" + triple(piece.greatest));
      add(piece.turns, piece.turns_at, piece.turns == Kind::bytes ? ",\"normalized\":true" : "");
    }
  }
  return text;
}

void GlbCompression::pack(gltf::GltfDocument& document, std::uint64_t stream_bytes) {
  PackedViews views;
  pack_views(document, perhaps_unused_, views);
  json& list = document.json["bufferViews"];
  for (const Target& target : targets_)
    for (PackedView packed : target.views) {
      if (packed.count == 0) continue;
      packed.offset += document.binary.size();
      list.push_back(views.view(packed, true));
    }
  views.declare(document.json, document.binary.size() + stream_bytes);
}

}  // namespace fascicle::formats
