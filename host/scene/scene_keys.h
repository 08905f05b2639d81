// The tables of the scene file and the readers of the structs they fill. A struct's table, reader and json_of
// (scene_json.h) are made from the same rows, in scene_keys_*.cpp.
//
// read_keys sets the members whose keys are present, and leaves the others. check_scene has checked types and
// ranges. It skips what depends on more than a key's own text: RowTraits::by_hand in scene_rows.h.
#pragma once

#include "host/scene/scene.h"
#include "host/scene/scene_table.h"
#include "host/scene/toml.h"

namespace fascicle::scene {

// scene_keys_body.cpp
const Table& general_table();
const Table& bar_table();
const Table& mesh_table();
const Table& character_table();
const Table& placed_character_table();
const Table& body_table();
void read_general_keys(const toml::table& table, Scene& scene);
void read_mesh_keys(const toml::table& table, Scene& scene);
void read_character_keys(const toml::table& table, Scene& scene);
void read_keys(const toml::table& table, Bar& bar);
void read_keys(const toml::table& table, CharacterSettings& character);
void read_keys(const toml::table& table, BodySettings& body);

// scene_keys_layer.cpp
const Table& layer_table();
const Table& flesh_table();
const Table& contact_table();
void read_keys(const toml::table& table, Layer& layer);
void read_keys(const toml::table& table, FleshSettings& flesh);
void read_keys(const toml::table& table, ContactSettings& contact);

// scene_keys_collider.cpp
const Table& collider_table();
void read_keys(const toml::table& table, Collider& collider);

// scene_keys_motion.cpp
const Table& solver_table();
const Table& motion_table();
void read_keys(const toml::table& table, SolverSettings& solver);
void read_keys(const toml::table& table, Motion& motion);

// scene_keys_rig.cpp
const Table& bone_table();
const Table& skeleton_table();
const Table& fibre_curve_table();
const Table& muscle_table();
const Table& pin_table();
const Table& probe_table();
const Table& force_table();
void read_keys(const toml::table& table, BoneSegment& bone);
void read_keys(const toml::table& table, SkeletonSettings& skeleton);
void read_keys(const toml::table& table, FibreCurve& curve);
void read_keys(const toml::table& table, Muscle& muscle);
void read_keys(const toml::table& table, Force& force);

// scene_keys_shapes.cpp
const Table& shape_table();
void read_keys(const toml::table& table, Box& box);
void read_keys(const toml::table& table, Sphere& sphere);
void read_keys(const toml::table& table, Capsule& capsule);
void read_keys(const toml::table& table, HalfSpace& half_space);
void read_keys(const toml::table& table, BoneDistance& distance);
void read_keys(const toml::table& table, Depth& depth);
void read_keys(const toml::table& table, VolumeShare& share);
void read_keys(const toml::table& table, JointSet& set);
void read_keys(const toml::table& table, PartSet& set);
void read_keys(const toml::table& table, Painted& painted);

}  // namespace fascicle::scene
