#include "tests/fuzz/seeds.h"

namespace fascicle::fuzz {

std::vector<Seed> seeds() {
  std::vector<Seed> all;
  add_mesh_seeds(all);
  add_gltf_seeds(all);
  add_scene_seeds(all);
  add_bake_seeds(all);
  add_build_seeds(all);
  add_cli_seeds(all);
  add_api_seeds(all);
  add_studio_seeds(all);
  return all;
}

}  // namespace fascicle::fuzz
