// A soft trunk with parts that the rig moves rigidly: a round column from y = 0 to 1.4, with a plate in front
// of its chest.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "host/build/build.h"
#include "host/build/rigid_parts.h"
#include "host/build/skin_weights.h"
#include "host/scene/scene.h"
#include "tests/build/made_surfaces.h"
#include "tests/build/surfaces.h"

namespace fascicle::tests::rigid_parts_test {

using scene::Vector3d;

inline constexpr double trunk_radius = 0.2, trunk_height = 1.4;
inline constexpr std::uint32_t trunk_around = 24;
enum Joint : std::uint32_t { pelvis, chest, plate_joint };

// A part attached to the trunk: surface, position and weights.
struct Piece {
  mesh::SurfaceMesh surface;
  Vector3d place;
  std::vector<std::pair<std::uint32_t, double>> weights;
  std::string object, material;
};

inline Piece plate() {
  mesh::SurfaceMesh box = cube_surface(0.2);
  for (Vector3d& p : box.vertices) p[2] *= 0.1;
  return {box, {0, 0.9, trunk_radius + 0.02}, {{plate_joint, 1.0}}, "Plate", "Steel"};
}

inline void add(rig::Character& c, const Piece& piece) {
  rig::SurfacePart part{piece.object,
                        piece.material,
                        static_cast<std::uint32_t>(c.parts.size()),
                        static_cast<std::uint32_t>(c.surface.vertices.size()),
                        static_cast<std::uint32_t>(piece.surface.vertices.size()),
                        static_cast<std::uint32_t>(c.surface.triangles.size()),
                        static_cast<std::uint32_t>(piece.surface.triangles.size())};
  c.parts.push_back(part);
  append(c.surface, piece.surface, piece.place);
  for (std::size_t v = 0; v < piece.surface.vertices.size(); ++v) {
    std::array<std::uint32_t, 8> joints{};
    std::array<double, 8> weights{};
    for (std::size_t k = 0; k < piece.weights.size(); ++k)
      joints[k] = piece.weights[k].first, weights[k] = piece.weights[k].second;
    c.joints.push_back(joints);
    c.weights.push_back(weights);
  }
}

// The trunk's lower half follows the pelvis and its upper half the chest, with a hard border or blended over
// 0.4 m.
inline rig::Character trunk_with(const std::vector<Piece>& pieces, bool is_hard = false) {
  std::vector<Vector3d> line;
  for (int k = 0; k <= 28; ++k) line.emplace_back(0, trunk_height * k / 28, 0);
  rig::Character c;
  add(c, {tube(line, trunk_radius, trunk_around), Vector3d::Zero(), {{pelvis, 1.0}}, "Body", "Skin"});
  for (std::size_t v = 0; v < c.surface.vertices.size(); ++v) {
    double up = std::clamp((c.surface.vertices[v][1] - 0.5) / 0.4, 0.0, 1.0);
    if (is_hard) up = std::round(up);
    c.joints[v] = {pelvis, chest};
    c.weights[v] = {1.0 - up, up};
  }
  c.skeleton = {joint_at("Pelvis", -1, {0, 0.1, 0}), joint_at("Chest", pelvis, {0, 0.7, 0}),
                joint_at("PlateJoint", chest, {0, 0.9, 0.1})};
  for (const Piece& piece : pieces) add(c, piece);
  return c;
}

inline scene::Scene scene_of(rig::Character character) {
  scene::Scene scene;
  scene.name = "trunk";
  scene.source = "test";
  scene.geometry = std::move(character);
  scene.resolution = 0.05;
  scene::Layer flesh, bone;
  flesh.name = "flesh";
  bone.name = "bone";
  bone.kinematic = true;
  bone.where = {scene::Depth{0.0, 0.3}};
  scene.layers = {flesh, bone};
  return scene;
}

struct Found {
  build::RigidSkin rigid;
  build::WeldedSurface welded;
};
inline Found find_in(const scene::Scene& scene) {
  const auto& character = std::get<rig::Character>(scene.geometry);
  build::Report report;
  Found found;
  found.welded = build::weld(character.surface, "test", report);
  const build::SkinWeights weights = build::welded_skin_weights(character, found.welded.of_vertex,
                                                                found.welded.surface.vertices.size(), "test");
  found.rigid = build::find_rigid_parts(character, found.welded, weights, scene);
  return found;
}

inline std::size_t count_rigid(const scene::Scene& scene) {
  const Found found = find_in(scene);
  return static_cast<std::size_t>(
      std::count(found.rigid.is_rigid.begin(), found.rigid.is_rigid.end(), char{1}));
}

}  // namespace fascicle::tests::rigid_parts_test
