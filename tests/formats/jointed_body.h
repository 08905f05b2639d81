// The fake body with a skeleton, as a generated character.
#pragma once

#include <filesystem>
#include <string>

#include <nlohmann/json.hpp>

#include "host/bake/bake.h"
#include "host/model/model.h"
#include "host/scene/scene.h"

namespace fascicle::tests {

// Two joints: the first moves along x, the second turns about z by 90 degrees in one second.
model::Model jointed_model();
scene::Scene jointed_scene(std::uint64_t frames);
bake::BakeResult bake_jointed(const bake::BakeOptions& options, std::uint64_t frames);

struct GlbChunks {
  nlohmann::json document;
  std::string binary;
};
GlbChunks read_glb(const std::filesystem::path& path);

}  // namespace fascicle::tests
