// What must be the same for a bake to be resumed.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/bake/bake.h"
#include "host/model/model.h"
#include "host/scene/scene.h"

namespace fascicle::bake {

// XXH3-64 of everything in the model: two models with the same hash give the same bake for the same drives.
std::uint64_t model_hash(const model::Model& model);

// The same for devices that make the same bits: all exact ones, or one that is not.
std::string identity_of(const DeviceDescription& device);

// Named values that determine every byte of the result files, in a fixed order.
using Identity = std::vector<std::pair<std::string, std::string>>;
Identity identity_of(const scene::Scene& scene, std::uint64_t model_hash, const BakeOptions& options);

// BakeOptions::contact_left_out of a bake with this identity; nullopt if contact.unless_torn decided nothing.
std::optional<std::string> contact_left_out(const Identity& identity);

struct Difference {
  std::string name, was, is;  // empty: nothing; "absent" if the name is missing there
};
// Sorted by name.
std::vector<Difference> differences(const Identity& before, const Identity& now);
// "fps was 60 and is 30; ..."
std::string text_of(const std::vector<Difference>& differences);

// Whether the finished frames are also those of the requested bake, so that it can be resumed: with more
// formats, if they can be written from frames alone, with files written in another way, with a later end, or
// with an earlier one that is not before `frames_done`. Not with another end if the motion is held there or
// repeats, or bends muscles: the end then affects earlier frames.
bool leaves_frames(const Difference& difference, const scene::Scene& scene, std::uint64_t frames_done);

// If the identities differ in such a way: the formats whose files must be rewritten from frame 0.
std::vector<std::string> formats_begun_anew(const Identity& before, const Identity& now);
// The identity in a checkpoint until these files have caught up with the frames: a difference that the next
// checkpoint removes.
Identity while_begun_anew(Identity identity, const std::vector<std::string>& formats);

}  // namespace fascicle::bake
