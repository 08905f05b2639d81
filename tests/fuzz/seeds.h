// The parts of seeds(), one per room.
#pragma once

#include <vector>

#include "tests/fuzz/readers.h"

namespace fascicle::fuzz {

void add_api_seeds(std::vector<Seed>& seeds);
void add_mesh_seeds(std::vector<Seed>& seeds);
void add_gltf_seeds(std::vector<Seed>& seeds);
void add_scene_seeds(std::vector<Seed>& seeds);
void add_bake_seeds(std::vector<Seed>& seeds);
void add_build_seeds(std::vector<Seed>& seeds);
void add_cli_seeds(std::vector<Seed>& seeds);
void add_studio_seeds(std::vector<Seed>& seeds);

}  // namespace fascicle::fuzz
