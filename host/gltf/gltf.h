// glTF 2.0 characters, .glb and .gltf.
//
// Meshes: all nodes of the default scene that have a mesh and that move. A node moves if its mesh has a skin,
// if it is at or below a joint, or if a clip animates it. Parts come in node order, then in primitive order;
// a mesh used by two nodes appears twice. Strips and fans become triangles. All JOINTS_n and WEIGHTS_n are
// read. Numeric per-vertex attributes whose names begin with _ or COLOR_ are read as painted attributes. A
// mesh without a skin follows, with weight 1, the nearest node at or above its own that is a joint or is
// animated; that node becomes a joint of the skeleton. Left out: meshes that nothing moves (Character::notes
// lists them; but see Still) and everything about looks. Morph targets are applied to the surface at the
// weights of the mesh or the node; Clip::weights animates them, and read_rig (gltf_rig.h) returns them.
// Joint::skins is set for every joint of a skin, weighted or not, and for every joint that carries a mesh.
//
// The bind pose is the pose of the nodes in the file. Positions are skinned with those transforms, which
// converts raw units to metres and the axes to Y up. In most files the inverse bind matrices and the nodes
// agree, up to one common matrix; the bind pose is then the pose in which the mesh was modelled. Otherwise
// the body is what a viewer shows before any clip plays, and the skin is rebound to it.
#pragma once

#include <filesystem>
#include <vector>

#include "host/rig/character.h"

namespace fascicle::gltf {

// What to do with a file in which nothing moves: no skin, no clip. With `carried`, each topmost node becomes
// a joint, and everything below it follows that joint.
enum class Still { left_out, carried };

// A node with this key in its extras carries the meshes below it, as if a clip animated it. A bake's document
// marks its carriers this way.
inline constexpr const char* carries_mark = "fascicle_carries";

// Reads the skinned meshes, skeleton and clips of a glTF file. Positions are in metres, in the bind pose.
// Throws SceneError with a JSON pointer to the fault. Refuses URIs outside the file's folder. Appends the
// paths of the external buffers it reads to `files_read`. `converter`: as for read_gltf_file.
rig::Character read_gltf(const std::filesystem::path& path,
                         std::vector<std::filesystem::path>* files_read = nullptr,
                         const std::filesystem::path& converter = {}, Still still = Still::left_out);

}  // namespace fascicle::gltf
