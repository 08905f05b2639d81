// Which keys the scene would refuse at present, and why: those of the integrator that it does not use.
#pragma once

#include <string>
#include <vector>

#include "host/scene/scene_edit.h"

namespace fascicle::studio {

class KeyUse {
 public:
  explicit KeyUse(const std::vector<scene::EditedTable>& tables);

  // One sentence for the user; empty if the key can be set. A stated key is always in use.
  std::string why_unused(const scene::EditedTable& table, const scene::EditedKey& key) const;

 private:
  bool is_implicit_ = false;
  bool is_stated_ = false;  // solver.integrator is stated
  bool has_auto_substeps_ = false;
  std::vector<std::string> layers_with_stiffness_;  // paths of layers that state a stiffness
  std::vector<std::string> still_layers_;           // paths of kinematic layers
};

}  // namespace fascicle::studio
