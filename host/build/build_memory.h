// What BuildMemory holds: each part with a key that identifies the scenes it is valid for. build_model.cpp
// requests the parts; without a memory they are made on demand, and the model is the same.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/build/body.h"
#include "host/build/build.h"
#include "host/build/contact_groups.h"
#include "host/build/layers.h"
#include "host/build/one_ring.h"
#include "host/build/stiffness.h"
#include "host/build/weights.h"
#include "host/build/where.h"

namespace fascicle::build {

// Everything that depends only on the body, not on its layers or what moves it. Measures refer to the body,
// so it must not move in memory.
struct Ground {
  Body body;           // in the model's numbering
  model::Model model;  // numbering, unit, rest shape and tetrahedra
  OneRings rings;
  std::vector<double> volume;                          // of each vertex, m^3
  std::vector<std::array<std::uint32_t, 3>> boundary;  // its triangles
  Report report;                                       // findings so far
  std::optional<Measures> measures;
  std::optional<WhereTest> test;
};

// Inputs of weights and stiffness beyond the body, for scenes that differ only in moduli, frequencies and
// damping.
struct WeightMemory {
  std::string key;
  RegionWeights weights;
  ElasticMemory elastic;
};

struct FibreMemory {
  std::string key;
  std::vector<float> directions;
  FibreReport report;
  std::vector<Warning> warnings;
};

// Contact depends only on which flesh moves freely, what meets what and what shares regions.
struct ContactMemory {
  std::string key;
  model::Model arrays;  // those of contact, and no others
};

struct BuildMemory::Impl {
  std::string key;  // body_key of the ground's scene
  std::unique_ptr<Ground> ground;
  FibreMemory fibres;
  WeightMemory weights;
  ContactMemory contact;
};

// Cached fibre_directions. `memory` may be null, here and below.
std::vector<float> fibres_of(const scene::Scene& scene, const Layering& layering, Ground& ground,
                             FibreMemory* memory, Report& report);

// Cached region_weights of the model's rest shape, masses and fibres.
RegionWeights weights_of(const scene::Scene& scene, const Layering& layering, const OneRings& rings,
                         WeightMemory* memory, const model::Model& model);

// Cached write_contact.
void add_contact(const scene::Scene& scene, const ContactGroups& groups, ContactMemory* memory,
                 model::Model& model);

}  // namespace fascicle::build
