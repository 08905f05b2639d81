#include "host/formats/glb_sparse.h"

#include <algorithm>
#include <span>
#include <utility>

#include "host/base/file.h"
#include "host/base/text.h"
#include "host/formats/surface.h"

namespace fascicle::formats {

using nlohmann::json;

std::string GlbSparseTargets::target(const GlbFrame& frame) {
  std::string bytes;
  std::size_t first = 0;
  for (const gltf::RigPart& part : rig_.parts) {
    pieces_.push_back(append_part(part, first, frame, bytes));
    first += part.positions.size();
  }
  ++targets_;
  stream_bytes_ += bytes.size();
  return bytes;
}

GlbSparseTargets::Piece GlbSparseTargets::append_part(const gltf::RigPart& part, std::size_t first,
                                                      const GlbFrame& frame, std::string& bytes) const {
  std::vector<std::uint32_t> indices;
  std::vector<float> moves, turns;
  const std::size_t count = part.positions.size();
  const bool has_normals = !part.normals.empty();
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t v = 3 * (first + i);
    const bool moved = frame.moved[first + i] != 0;
    const bool is_turned = frame.turns[v] != 0.0f || frame.turns[v + 1] != 0.0f || frame.turns[v + 2] != 0.0f;
    // A sparse accessor must replace at least one element.
    const bool last_chance = i + 1 == count && indices.empty();
    if (!moved && !is_turned && !last_chance) continue;
    indices.push_back(static_cast<std::uint32_t>(i));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      moves.push_back(moved ? frame.moves[v + axis] : 0.0f);
      turns.push_back(frame.turns[v + axis]);
    }
  }
  Piece piece{.count = static_cast<std::uint32_t>(indices.size())};
  const std::array<float, 6> box = bounds(moves);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    // Vertices that are not in the target move by 0.
    const bool all = indices.size() == count;
    piece.least[axis] = all ? box[axis] : std::min(box[axis], 0.0f);
    piece.greatest[axis] = all ? box[3 + axis] : std::max(box[3 + axis], 0.0f);
  }
  piece.indices = stream_bytes_ + bytes.size();
  piece.positions = piece.indices + indices.size() * sizeof(std::uint32_t);
  piece.normals = piece.positions + moves.size() * sizeof(float);
  base::append_array(bytes, std::span<const std::uint32_t>(indices));
  base::append_array(bytes, std::span<const float>(moves));
  if (has_normals) base::append_array(bytes, std::span<const float>(turns));
  return piece;
}

json GlbSparseTargets::targets_of(std::size_t part, std::size_t first_accessor) const {
  std::size_t step = 0, before = 0;
  for (std::size_t p = 0; p < rig_.parts.size(); ++p) {
    if (p == part) before = step;
    step += rig_.parts[p].normals.empty() ? 1 : 2;
  }
  json list = json::array();
  for (std::size_t k = 0; k < targets_; ++k) {
    const std::size_t number = first_accessor + k * step + before;
    json target{{"POSITION", number}};
    if (!rig_.parts[part].normals.empty()) target["NORMAL"] = number + 1;
    list.push_back(std::move(target));
  }
  return list;
}

std::string GlbSparseTargets::accessors(json& document, std::uint64_t stream_at) const {
  // Two views of the same bytes: one for indices, one for values.
  json& views = document["bufferViews"];
  const std::size_t view = views.size();
  for (int copy = 0; copy < 2; ++copy)
    views.push_back({{"buffer", 0}, {"byteOffset", stream_at}, {"byteLength", stream_bytes_}});
  const auto triple = [](const std::array<float, 3>& v) {
    return '[' + base::number_text(v[0]) + ',' + base::number_text(v[1]) + ',' + base::number_text(v[2]) +
           ']';
  };
  std::string text;
  for (std::size_t k = 0; k < pieces_.size(); ++k) {
    const Piece& piece = pieces_[k];
    const gltf::RigPart& part = rig_.parts[k % rig_.parts.size()];
    const auto add = [&](std::uint64_t values, const std::string& bounds_text) {
      text +=
          ",{\"componentType\":5126,\"count\":" + base::number_text(std::uint64_t{part.positions.size()}) +
          ",\"type\":\"VEC3\"" + bounds_text + ",\"sparse\":{\"count\":" + base::number_text(piece.count) +
          ",\"indices\":{\"bufferView\":" + base::number_text(std::uint64_t{view}) +
          ",\"byteOffset\":" + base::number_text(piece.indices) +
          ",\"componentType\":5125},\"values\":{\"bufferView\":" +
          base::number_text(std::uint64_t{view} + 1) + ",\"byteOffset\":" + base::number_text(values) + "}}}";
    };
    add(piece.positions, ",\"min\":" + triple(piece.least) + ",\"max\":" + triple(piece.greatest));
    if (!part.normals.empty()) add(piece.normals, "");
  }
  return text;
}

}  // namespace fascicle::formats
