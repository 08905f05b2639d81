#include "host/formats/shaped_surface.h"

#include <algorithm>
#include <vector>

#include "host/formats/character_file.h"
#include "host/gltf/gltf_file.h"
#include "host/gltf/gltf_material.h"
#include "host/gltf/gltf_shapes.h"
#include "host/rig/pose.h"

namespace fascicle::formats {

namespace {

using Eigen::Matrix3d;
using Eigen::Matrix4d;
using Eigen::Vector3d;
using nlohmann::json;

bool has_targets(const json& document) {
  for (const json& mesh : gltf::json_member(document, "meshes"))
    for (const json& primitive : gltf::json_member(mesh, "primitives"))
      if (!gltf::json_member(primitive, "targets").is_null()) return true;
  return false;
}

}  // namespace

ShapedSurface::ShapedSurface(const std::filesystem::path& character, const model::Model& model, double fps)
    : unit_(model.unit), fps_(fps) {
  if (character.empty() || model.surface_count() == 0) return;
  const json document = gltf::read_gltf_file(character).document;
  if (!has_targets(document)) return;
  has_clip_ = has_baked_clip(document);
  gltf::Rig rig = read_kept_rig(character, model);
  const bool has_shapes = std::any_of(rig.parts.begin(), rig.parts.end(),
                                      [](const gltf::RigPart& part) { return !part.shapes.empty(); });
  if (has_shapes) rig_ = std::move(rig);
}

void ShapedSurface::add_to(std::uint64_t frame, std::span<float> surface) const {
  if (empty()) return;
  const rig::Clip* clip = has_clip_ ? rig::find_clip(rig_.character, "") : nullptr;
  // Rounded as in the file.
  const double time = double{static_cast<float>(static_cast<double>(frame) / fps_)};
  std::vector<Matrix4d> joints;
  std::size_t first = 0;
  for (const gltf::RigPart& part : rig_.parts) {
    std::vector<double> weights = gltf::shape_weights(part, clip, time);
    for (std::size_t k = 0; k < weights.size(); ++k) weights[k] -= part.rest_weights[k];
    if (std::any_of(weights.begin(), weights.end(), [](double w) { return w != 0.0; })) {
      if (joints.empty()) joints = rig::joint_transforms_at(rig_.character, clip, time);
      std::vector<Matrix3d> slots;
      for (std::size_t k = 0; k < part.skin_joint.size(); ++k)
        slots.emplace_back((joints[part.skin_joint[k]] * part.inverse_bind[k]).topLeftCorner<3, 3>());
      std::vector<Vector3d> moves(part.positions.size(), Vector3d::Zero());
      gltf::add_shapes(part.shapes, weights, moves);
      for (std::size_t i = 0; i < moves.size(); ++i) {
        if (moves[i].isZero(0.0)) continue;
        Matrix3d blend = Matrix3d::Zero();
        for (std::size_t k = part.influence_offset[i]; k < part.influence_offset[i + 1]; ++k)
          blend += part.weight[k] * slots[part.slot[k]];
        const Vector3d moved = blend * moves[i];
        for (std::size_t axis = 0; axis < 3; ++axis) {
          float& value = surface[3 * (first + i) + axis];
          value = static_cast<float>(double{value} + moved[static_cast<Eigen::Index>(axis)] / unit_);
        }
      }
    }
    first += part.positions.size();
  }
}

}  // namespace fascicle::formats
