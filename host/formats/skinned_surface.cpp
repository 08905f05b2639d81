#include "host/formats/skinned_surface.h"

#include "host/formats/character_file.h"
#include "host/gltf/gltf_file.h"
#include "host/rig/pose.h"

namespace fascicle::formats {

using Eigen::Matrix4d;

SkinnedSurface::SkinnedSurface(const std::filesystem::path& character, const model::Model& model, double fps)
    : rig_(read_kept_rig(character, model)),
      is_moving_(has_baked_clip(gltf::read_gltf_file(character).document)),
      fps_(fps) {}

std::vector<float> SkinnedSurface::positions(std::uint64_t frame) const {
  // Rounded as in the file.
  const auto time = static_cast<float>(static_cast<double>(frame) / fps_);
  const rig::Clip* clip = is_moving_ ? rig::find_clip(rig_.character, "") : nullptr;
  const std::vector<Matrix4d> joints = rig::joint_transforms_at(rig_.character, clip, double{time});
  std::vector<float> positions;
  for (const gltf::RigPart& part : rig_.parts) {
    std::vector<Matrix4d> slots;
    for (std::size_t k = 0; k < part.skin_joint.size(); ++k)
      slots.push_back(joints[part.skin_joint[k]] * part.inverse_bind[k]);
    const std::vector<Eigen::Vector3d> shaped = gltf::shaped_positions(part, clip, double{time});
    for (std::size_t i = 0; i < shaped.size(); ++i) {
      Matrix4d blend = Matrix4d::Zero();
      for (std::size_t k = part.influence_offset[i]; k < part.influence_offset[i + 1]; ++k)
        blend += part.weight[k] * slots[part.slot[k]];
      const Eigen::Vector3d place = blend.topLeftCorner<3, 3>() * shaped[i] + blend.topRightCorner<3, 1>();
      for (int axis = 0; axis < 3; ++axis) positions.push_back(static_cast<float>(place[axis]));
    }
  }
  return positions;
}

}  // namespace fascicle::formats
