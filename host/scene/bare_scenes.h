// Scene files for a mesh or a character given without one.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "host/scene/scene.h"

namespace fascicle::scene {

// One soft layer under gravity, its lowest 5 % held.
// Its Young's modulus is chosen by the mesh's size, so that it stands under its own weight; `scale` is the
// metres of its unit. Throws SceneError for a mesh below a micrometre or above 1000 km.
std::string scene_for_mesh(const std::filesystem::path& path, const Geometry& mesh, double scale);

// By what the layers state theirs: alpha for the explicit integrator, Young's modulus for the implicit one.
enum class Stiffness { alpha, modulus };
// By solver.integrator, where the scene names one. Else the modulus, but alpha where solver.weights are the
// paper's, which the implicit integrator does not know, and where _STIFFNESS is painted, which multiplies
// alpha and has no part in a modulus.
Stiffness stiffness_for(const rig::Character& character, const std::optional<std::string>& integrator,
                        const std::optional<std::string>& weights);

// Of several characters what the next function asks for: the size of the largest, and what is painted on any.
rig::Character what_layers_go_by(const std::vector<rig::Character>& characters);

// What a character gets whose scene says nothing of layers: [layers.NAME] and [solver].
// Bone, muscle and fat as in figure 9, by relative depth, or where _LAYER is painted (1 bone, 2 muscle, 3
// fat) by that. Fibres from the field. Moduli by the character's size. Throws SceneError, which begins with
// `source`, for a character below a micrometre or above 3 km.
std::string layers_for_character(const rig::Character& character, Stiffness stiffness,
                                 const std::string& source);
std::string scene_for_character(const std::filesystem::path& path, const rig::Character& character,
                                Stiffness stiffness);

}  // namespace fascicle::scene
