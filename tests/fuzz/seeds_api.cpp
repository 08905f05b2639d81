#include "tests/fuzz/seeds.h"
#include "tests/fuzz/state_owner.h"

namespace fascicle::fuzz {

void add_api_seeds(std::vector<Seed>& seeds) {
  api::SavedState saved;
  saved.frame = 3;
  saved.time = 0.05;
  saved.state.positions = saved.state.velocities = saved.state.skinned = {0, 0, 0, 1, 2, 3};
  saved.state.rotations = {0, 0, 0, 1, 0, 0, 0, 1};
  const auto add = [&](const char* name) {
    seeds.push_back({"state", name, api::saved_state_bytes(saved, identity_of_two())});
  };
  add("rest");
  saved.driven = api::Driven::by_poses;
  saved.pose = {Eigen::Matrix4d::Identity()};
  add("pose");
}

}  // namespace fascicle::fuzz
