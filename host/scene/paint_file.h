// A file with the paint of a character: JSON, indexed by vertex, valid only for the mesh it was painted on.
//
//   {"fascicle_paint": 1,
//    "surface": "...",              rig::surface_hash, 32 hex digits
//    "vertices": 3215,              of that surface
//    "attributes": {
//      "_LAYER": {"vertex": [3, 4], "value": [3, 3]},
//      "_FIBER": {"vertex": [7], "value": [0, 1, 0]}}}
//
// Vertices are in ascending order. Numbers are rounded to single precision, so that the same values fit into
// glTF.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "host/rig/paint.h"

namespace fascicle::scene {

inline constexpr std::uint64_t most_paint_bytes = std::uint64_t{64} << 20;

// Checks everything before it returns. Throws InputFileError "FILE: POINTER: what is wrong" with a JSON
// pointer. `file` is for messages.
rig::Paint parse_paint(std::string_view text, const std::filesystem::path& file,
                       const mesh::SurfaceMesh& surface);

// The text of a paint that parse_paint would accept.
std::string paint_text(const rig::Paint& paint);

}  // namespace fascicle::scene
