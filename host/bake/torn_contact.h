// Contact that tears the skin: found before a bake, by trial. Where the clip moves a limb's bone through a
// body, as when an arm swings through a belly, contact drags the skin along. Skinning's own overlap then
// looks better. How deep the overlap is does not settle it: deep flesh may yield. Frames have to be tried.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "host/bake/expected_look.h"
#include "host/drive/drive_source.h"
#include "host/model/model.h"
#include "host/scene/scene.h"

namespace fascicle::bake {

// The pose of a clip whose skinning lays flesh deepest into other flesh.
struct DrivenFlesh {
  double depth = 0.0;       // m
  std::uint64_t frame = 0;  // of this pose
  std::uint64_t first = 0;  // a frame before it where flesh is not yet half as deep as contact can bear, if
                            // there is one in the half second before
};

// Looks at about ten poses per second, at most 200, of one cycle. Empty if none is deeper than
// deepest_for_contact, or without contact or skeleton.
std::optional<DrivenFlesh> driven_flesh(const scene::Scene& scene, const model::Model& model,
                                        drive::DriveSource& drives);

// Those that have to be baked to see what contact does there.
TriedFrames frames_to_try(const scene::Scene& scene, const DrivenFlesh& driven);

// A trial needs no more frames over the limit.
inline constexpr std::uint64_t enough_frames_over = 5;

// Whether a bake should leave contact out, by trials of the same frames with it and without it.
bool tears(const TriedLook& with_contact, const TriedLook& without);

// One line that says what was tried, and how to keep contact.
std::string torn_contact_warning(const DrivenFlesh& driven, const TriedLook& with_contact,
                                 const TriedLook& without);

// The same for a bake that is resumed, which is not tried again.
inline constexpr const char* left_out_before =
    "contact of the body with itself is left out, as in the frames before: it would tear the skin";

}  // namespace fascicle::bake
