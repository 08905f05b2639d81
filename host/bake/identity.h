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

struct Difference {
  std::string name, was, is;  // empty: nothing; "absent" where it has no such name
};
// By name.
std::vector<Difference> differences(const Identity& before, const Identity& now);
// "fps was 60 and is 30; ..."
std::string text_of(const std::vector<Difference>& differences);

// Whether the frames that are done are those of the bake now asked for, so that it can go on with them: more
// formats of those that the frames hold all of, files written another way, a later end, or an earlier one
// that does not come before `frames_done`. Not the end of a motion that is held there, or that repeats: there
// it decides what comes before.
bool leaves_frames(const Difference& difference, const scene::Scene& scene, std::uint64_t frames_done);
// What a checkpoint says while files are written that the identity asks for and the folder may lack: that no
// format is there but those that cannot be written from the frames.
Identity without_files(Identity identity);

}  // namespace fascicle::bake
