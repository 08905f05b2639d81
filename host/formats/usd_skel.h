// Plain skinning as UsdSkel, in addition to the baked points: a SkelRoot with purpose "guide" that has the
// skeleton, its motion and the meshes, bound in the bind pose.
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

// The times of the samples.
struct UsdTimes {
  std::uint64_t frames = 0;        // not counting the first
  std::uint64_t first_number = 0;  // time code of the first
  double fps = 60.0;
};

class UsdSkel {
 public:
  // `character`: a character.glb with the surface's objects. `path`: the SkelRoot prim. `materials`: the
  // scope of the surface's materials.
  UsdSkel(const std::filesystem::path& character, const SurfaceObjects& surface, std::string path,
          std::string materials);

  // Writes the prim and everything below it. Computes poses as it writes them, so memory does not grow with
  // the frames.
  void write(base::PartFile& file, const UsdTimes& times, int level) const;

 private:
  // The world bind pose of each joint that a skin defines; skins that disagree get separate skeletons.
  using BindPose = std::vector<std::optional<Eigen::Matrix4d>>;

  void bind_objects();
  // The transform from the part's raw space to the bind pose in the world; adds joints that no earlier skin
  // bound to `pose`. Nullopt if the part contradicts `pose`.
  std::optional<Eigen::Matrix4d> bound(const gltf::RigPart& part, BindPose& pose) const;
  std::string skeleton(std::size_t number, int level) const;
  void write_motion(base::PartFile& file, const UsdTimes& times, int level) const;
  std::string mesh(std::size_t object, int level) const;
  std::string joint_list() const;

  const SurfaceObjects& surface_;
  std::string path_, materials_;
  gltf::Rig rig_;
  bool has_clip_ = false;
  bool has_top_ = false;                  // readers expect one root, so several get a static joint above them
  std::vector<std::string> tokens_;       // per joint: root/child/...
  std::vector<Eigen::Matrix4d> rest_;     // per joint, in the world
  std::vector<BindPose> poses_;           // per skeleton, at least one
  std::vector<std::size_t> skeleton_of_;  // per object
  std::vector<Eigen::Matrix4d> raw_to_world_;  // per part: to the bind pose
};

}  // namespace fascicle::formats
