// What must be the same for a bake to be resumed.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "host/bake/bake.h"
#include "host/model/model.h"
#include "host/scene/scene.h"

namespace fascicle::bake {

// XXH3-64 of everything in the model: two models with one hash give the same bake for the same drives.
std::uint64_t model_hash(const model::Model& model);

// Named values that decide every byte of the result files, in a fixed order. The device is not among them
// where it is exact: there any exact device goes on with the same bits.
using Identity = std::vector<std::pair<std::string, std::string>>;
Identity identity_of(const scene::Scene& scene, std::uint64_t model_hash, const BakeOptions& options);

// "fps was 60 and is 30; ...", or empty if both are the same.
std::string differences(const Identity& before, const Identity& now);

}  // namespace fascicle::bake
