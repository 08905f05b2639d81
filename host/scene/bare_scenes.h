// Scene files for a mesh or a character that is given without one.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "host/scene/scene.h"

namespace fascicle::scene {

// One soft layer under gravity, with its lowest 5 % pinned. Young's modulus scales with the mesh's size, so
// that the body carries its own weight. `scale` is metres per unit of the mesh. Throws SceneError if the mesh
// is smaller than a micrometre or larger than 1000 km.
std::string scene_for_mesh(const std::filesystem::path& path, const Geometry& mesh, double scale);

// How layers state their stiffness: alpha for the explicit integrator, Young's modulus for the implicit one.
enum class Stiffness { alpha, modulus };
// Follows solver.integrator if the scene names one. Otherwise the modulus, except with solver.weights of the
// paper, which the implicit integrator does not support.
Stiffness stiffness_for(const std::optional<std::string>& integrator,
                        const std::optional<std::string>& weights);

// For several characters, the input of layers_for_character: the vertices of the largest, and everything
// painted on any.
rig::Character what_layers_go_by(const std::vector<rig::Character>& characters);

// [layers.NAME] and [solver] for a character whose scene defines no layers: bone, muscle and fat as in figure
// 9, by relative depth or, where _LAYER is painted, by that (1 bone, 2 muscle, 3 fat). A painted _STIFFNESS
// multiplies. Fibres come from the fibre field, moduli scale with the character's size. Throws SceneError,
// starting with `source`, if the character is smaller than a micrometre or larger than 3 km.
std::string layers_for_character(const rig::Character& character, Stiffness stiffness,
                                 const std::string& source);
std::string scene_for_character(const std::filesystem::path& path, const rig::Character& character,
                                Stiffness stiffness);

}  // namespace fascicle::scene
