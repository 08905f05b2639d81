#include "host/cli/inspect_counts.h"

#include <algorithm>
#include <variant>

#include "host/rig/character.h"
#include "host/scene/muscle_bones.h"

namespace fascicle::cli {

double share_of(double part, double whole) {
  return whole > 0.0 ? part / whole : 0.0;
}

std::size_t longest_ring(const model::Model& model) {
  std::size_t longest = 0;
  for (std::size_t i = 0; i < model.vertex_count; ++i)
    longest = std::max<std::size_t>(longest, model.ring_offset[i + 1] - model.ring_offset[i]);
  return longest;
}

std::vector<MuscleCount> count_muscles(const scene::Scene& scene, const model::Model& model) {
  std::vector<MuscleCount> counts;
  const auto* character = std::get_if<rig::Character>(&scene.geometry);
  if (character == nullptr) return counts;
  for (const scene::Muscle& muscle : scene.muscles) {
    const scene::MuscleBones bones = scene::muscle_bones(*character, muscle);
    counts.push_back({muscle.name, character->skeleton[bones.carrier].name,
                      scene.scale * (bones.to - bones.from).norm(), 0, 0});
  }
  for (const shader::RegionMuscle& entry : model.region_muscle) {
    ++counts[entry.muscle].regions;
    counts[entry.muscle].bulging += entry.bulge != 0.0f ? 1u : 0u;
  }
  return counts;
}

}  // namespace fascicle::cli
