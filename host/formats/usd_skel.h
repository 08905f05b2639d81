// Skinning alone as UsdSkel, beside the baked points: a SkelRoot of the purpose "guide" with the skeleton,
// its motion and the meshes bound to it in the bind pose.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "host/base/part_file.h"
#include "host/formats/surface_objects.h"
#include "host/gltf/gltf_rig.h"

namespace fascicle::formats {

// When the samples are.
struct UsdTimes {
  std::uint64_t frames = 0;        // after the first
  std::uint64_t first_number = 0;  // the first one's time code
  double fps = 60.0;
};

class UsdSkel {
 public:
  // Of a character.glb that has the surface's objects; `path` is the SkelRoot's prim, `materials` the scope
  // of the surface's materials.
  UsdSkel(const std::filesystem::path& character, const SurfaceObjects& surface, std::string path,
          std::string materials);

  // The prim with all below it. Poses are worked out as they are written: nothing grows with the frames.
  void write(base::PartFile& file, const UsdTimes& times, int level) const;

 private:
  // The bind pose of each joint in the world, where a skin says one; skins that disagree have one each.
  using BindPose = std::vector<std::optional<Eigen::Matrix4d>>;

  void bind_objects();
  // From the part's raw space to where its vertices stand in the bind pose; `pose` gets the joints that no
  // skin before has bound. Nothing where the part contradicts it.
  std::optional<Eigen::Matrix4d> bound(const gltf::RigPart& part, BindPose& pose) const;
  std::string skeleton(std::size_t number, int level) const;
  void write_motion(base::PartFile& file, const UsdTimes& times, int level) const;
  std::string mesh(std::size_t object, int level) const;
  std::string joint_list() const;

  const SurfaceObjects& surface_;
  std::string path_, materials_;
  gltf::Rig rig_;
  bool has_clip_ = false;
  bool has_top_ = false;  // readers take one root, so that several get a joint above them, which rests
  std::vector<std::string> tokens_;            // of joints: root/child/...
  std::vector<Eigen::Matrix4d> rest_;          // of joints, in the world
  std::vector<BindPose> poses_;                // of skeletons, at least one
  std::vector<std::size_t> skeleton_of_;       // of objects
  std::vector<Eigen::Matrix4d> raw_to_world_;  // of parts: to where they stand in the bind pose
};

}  // namespace fascicle::formats
