// Which keys would be refused as the scene stands, and why: those of the integrator that it does not use.
#pragma once

#include <string>
#include <vector>

#include "host/scene/scene_edit.h"

namespace fascicle::studio {

class KeyUse {
 public:
  explicit KeyUse(const std::vector<scene::EditedTable>& tables);

  // One sentence for people; empty where the key can be set. A key that is stated is in use.
  std::string why_unused(const scene::EditedTable& table, const scene::EditedKey& key) const;

 private:
  bool is_implicit_ = false;
  bool is_stated_ = false;  // by solver.integrator
  bool has_auto_substeps_ = false;
  std::vector<std::string> layers_with_stiffness_;  // paths of the layers that say how stiff they are
  std::vector<std::string> still_layers_;           // paths of the kinematic ones
};

}  // namespace fascicle::studio
