// Where the scene's solids are in each substep, in the form that solvers take.
#pragma once

#include <cstddef>
#include <vector>

#include "host/drive/timeline.h"
#include "host/model/model.h"
#include "host/model/solver.h"
#include "host/scene/scene.h"
#include "host/scene/solids.h"

namespace fascicle::drive {

// A time of the clip (s) and, with a skeleton, the pose there.
struct Moment {
  double time = 0.0;
  const Pose* pose = nullptr;
};

class ColliderDrive {
 public:
  // The scene must outlive it. `h`: a substep, s.
  ColliderDrive(const scene::Scene& scene, const model::Model& model, double h);

  // Appends each solid's motion through one substep, relative to `origin` (metres of the scene).
  void append(const Moment& before, const Moment& at, const scene::Vector3d& origin,
              std::vector<shader::Collider>& to) const;

  // The solids at that time, metres of the scene.
  std::vector<scene::Solid> solids(const Moment& at) const;

 private:
  struct Moved {
    const scene::Collider* collider;
    scene::Solid solid;  // as in the scene
    std::size_t joint;   // of the character, or none
  };
  static constexpr std::size_t none = static_cast<std::size_t>(-1);

  scene::Solid placed(const Moved& moved, const Moment& at) const;

  const scene::Scene& scene_;
  double unit_;
  float lifted_;
  std::vector<Moved> moved_;
};

}  // namespace fascicle::drive
