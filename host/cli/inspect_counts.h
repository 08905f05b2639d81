// What fascicle inspect counts and measures of a built model.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "host/model/model.h"
#include "host/scene/scene.h"

namespace fascicle::cli {

// 0 of an empty whole.
double share_of(double part, double whole);

// Entries of the longest one-ring.
std::size_t longest_ring(const model::Model& model);

// A muscle of the scene, as built.
struct MuscleCount {
  std::string name, bone;
  double bone_length = 0.0;              // m
  std::size_t regions = 0, bulging = 0;  // regions that it acts on, and those of them that bulge
};

// One per muscle; none without a character.
std::vector<MuscleCount> count_muscles(const scene::Scene& scene, const model::Model& model);

}  // namespace fascicle::cli
