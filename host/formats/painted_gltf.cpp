#include "host/formats/painted_gltf.h"

#include <algorithm>
#include <map>

#include <Eigen/LU>

#include "host/formats/glb_document.h"
#include "host/formats/gltf_writer.h"
#include "host/gltf/gltf_rig.h"
#include "host/rig/rig_math.h"

namespace fascicle::formats {
namespace {

using Eigen::Vector3d;
using nlohmann::json;

// The same rotations from a part's raw space to the bind pose that read_gltf applies to directions.
class Turns {
 public:
  Turns(const gltf::RigPart& part, const rig::Character& character) : character_(character) {
    for (std::size_t slot = 0; slot < part.skin_joint.size(); ++slot) {
      const std::uint32_t joint = part.skin_joint[slot];
      const Eigen::Matrix4d bind = rig::affine_inverse(character.skeleton[joint].inverse_bind);
      turn_of_.emplace(joint, (bind * part.inverse_bind[slot]).topLeftCorner<3, 3>());
    }
  }

  // Inverse rotation, keeping the length; 0 if skinning collapses the direction.
  Vector3d back(std::size_t vertex, const Vector3d& direction) const {
    Eigen::Matrix3d turn = Eigen::Matrix3d::Zero();
    for (std::size_t k = 0; k < character_.weights[vertex].size(); ++k) {
      const auto found = turn_of_.find(character_.joints[vertex][k]);
      if (found != turn_of_.end()) turn += character_.weights[vertex][k] * found->second;
    }
    const Vector3d raw = turn.inverse() * direction;
    if (!raw.allFinite() || !(raw.norm() > 0.0)) return Vector3d::Zero();
    return raw * (direction.norm() / raw.norm());
  }

 private:
  const rig::Character& character_;
  std::map<std::uint32_t, Eigen::Matrix3d> turn_of_;
};

std::vector<float> values_of_part(const rig::PaintedAttribute& attribute, bool is_direction,
                                  const gltf::RigPart& part, std::size_t first,
                                  const rig::Character& character) {
  std::vector<float> values;
  const Turns turns(part, character);
  for (std::size_t i = first; i < first + part.positions.size(); ++i) {
    const double* value = attribute.values.data() + attribute.width * i;
    if (!is_direction) {
      values.push_back(static_cast<float>(*value));
      continue;
    }
    const Vector3d raw = turns.back(i, Vector3d(value[0], value[1], value[2]));
    for (int axis = 0; axis < 3; ++axis) values.push_back(static_cast<float>(raw[axis]));
  }
  return values;
}

}  // namespace

std::string painted_glb(const std::filesystem::path& file, const rig::Character& character,
                        const rig::Paint& paint, std::vector<std::string>& missing) {
  gltf::GltfDocument document = gltf::pack_gltf(file, missing);
  const gltf::Rig rig = gltf::read_rig(file);
  // A mesh shared by several nodes may be painted differently on each.
  const std::vector<std::size_t> meshes = own_meshes(document.json, rig);
  std::size_t first = 0;
  for (std::size_t p = 0; p < rig.parts.size(); ++p) {
    const gltf::RigPart& part = rig.parts[p];
    json& mesh = document.json["meshes"][meshes[p]];
    json& attributes = mesh["primitives"][part.primitive]["attributes"];
    for (const rig::PaintedVertices& painted : paint.attributes) {
      const rig::PaintKind& kind = *rig::find_paint_kind(painted.name);
      const auto laid_over =
          std::find_if(character.painted.begin(), character.painted.end(),
                       [&](const rig::PaintedAttribute& a) { return a.name == painted.name; });
      const std::vector<float> values = values_of_part(*laid_over, kind.is_direction, part, first, character);
      attributes[painted.name] = add_accessor(document, std::span<const float>(values), kind.width);
    }
    first += part.positions.size();
  }
  return glb_text(std::move(document));
}

}  // namespace fascicle::formats
