// Contact that tears the skin: found before a bake, by trial. Where the clip moves a limb's bone through a
// body, as when an arm swings through a belly, contact drags the skin along. Skinning's own overlap then
// looks better. How deep the overlap is does not settle it: deep flesh may yield. Frames have to be tried.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "host/bake/expected_look.h"
#include "host/drive/drive_source.h"
#include "host/model/model.h"
#include "host/scene/scene.h"

namespace fascicle::bake {

// A pose of a clip whose skinning lays flesh deep into other flesh.
struct DrivenFlesh {
  double depth = 0.0;        // m
  std::uint64_t frame = 0;   // of this pose
  std::uint64_t first = 0;   // a frame up to half a second before it; if possible, flesh is not half as deep
                             // there as contact can bear
  bool starts_deep = false;  // it is deeper even there
};

// The deepest poses of one cycle that are deeper than deepest_for_contact, a second or more apart, the
// deepest first: at most two. About ten poses per second are looked at, in long clips fewer. None without
// contact or a skeleton, or in a scene of several characters: its model also has contact between them.
std::vector<DrivenFlesh> driven_flesh(const scene::Scene& scene, const model::Model& model,
                                      drive::DriveSource& drives, const std::function<bool()>& goes_on = {});

// Those that have to be baked to see what contact does there.
TriedFrames frames_to_try(const scene::Scene& scene, const DrivenFlesh& driven);

// A trial needs no more frames over the limit.
inline constexpr std::uint64_t enough_frames_over = 5;

// Whether a bake should leave contact out, by trials of the same frames with it and without it. Flesh that
// does not stay finite is torn.
bool tears(const TriedLook& with_contact, const TriedLook& without);

// One line that says what was tried, and how to keep contact.
std::string torn_contact_warning(const scene::Scene& scene, const DrivenFlesh& driven,
                                 const TriedLook& with_contact, const TriedLook& without);

}  // namespace fascicle::bake
