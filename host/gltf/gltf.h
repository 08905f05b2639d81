// glTF 2.0 characters, .glb and .gltf.
//
// What is read: the default scene's nodes that have a mesh and are moved by a skin, by standing on or below a
// joint, or by a clip; in the order of the nodes, their primitives one after the other, a mesh that two nodes
// show twice; strips and fans become triangles; all JOINTS_n and WEIGHTS_n; attributes with numbers for each
// vertex whose names begin with _ or COLOR_, as painted. A mesh without a skin follows with weight 1 the
// nearest node at or above its own that is a joint or that a clip moves; such a node is a joint of the
// skeleton. What is left out: meshes that nothing moves (Character::notes says which; but Still) and
// everything about looks. Morph targets stand in the surface at the weights of the mesh or the node;
// Clip::weights moves them, and read_rig (gltf_rig.h) has them. Joint::skins holds for every joint of a skin,
// weighted or not, and for every joint that carries a mesh.
//
// The bind pose is the pose of the nodes as the file holds them: positions are put through the skin with
// those transforms, which turns raw units into metres and the axes to Y up. Where the file's inverse bind
// matrices and its nodes agree (most files; they then differ by one common matrix), that is the pose the mesh
// was modelled in. Where they do not, the body is what a viewer shows before any clip plays, and the skin is
// bound to it anew.
#pragma once

#include <filesystem>
#include <vector>

#include "host/rig/character.h"

namespace fascicle::gltf {

// What becomes of the meshes of a file in which nothing moves: no skin, no clip. Carried, each topmost node
// is a joint, and what is below it follows that one.
enum class Still { left_out, carried };

// A node whose extras have this carries the meshes below it, as one that a clip moves. It is how the document
// of a bake says what is carried in it.
inline constexpr const char* carries_mark = "fascicle_carries";

// Reads the skinned mesh, skeleton and clips of a glTF file; positions come out in metres in the bind pose.
// Throws SceneError with a JSON pointer to what is wrong. URIs outside the file's folder are refused. Appends
// the paths of the external buffers it reads to `files_read`. `converter`: read_gltf_file.
rig::Character read_gltf(const std::filesystem::path& path,
                         std::vector<std::filesystem::path>* files_read = nullptr,
                         const std::filesystem::path& converter = {}, Still still = Still::left_out);

}  // namespace fascicle::gltf
