// What BuildMemory holds: each part with the key that says for which scenes it holds. build_model.cpp asks
// for the parts; without a memory they are made as they are needed, and the model is the same.
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

// What follows from the body alone, whatever its layers are and whatever moves it. Measures refer to the
// body: it stays where it is.
struct Ground {
  Body body;           // in the model's numbering
  model::Model model;  // numbering, unit, rest shape and tetrahedra
  OneRings rings;
  std::vector<double> volume;                          // of each vertex, m^3
  std::vector<std::array<std::uint32_t, 3>> boundary;  // its triangles
  Report report;                                       // what was found so far
  std::optional<Measures> measures;
  std::optional<WhereTest> test;
};

// What weights and stiffness follow from beside the body, where only moduli, frequencies and damping differ.
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

// Contact asks only which flesh moves by itself and what meets what.
struct ContactMemory {
  std::string key;
  model::Model arrays;  // those of contact, and no others
};

struct BuildMemory::Impl {
  std::string key;  // body_key of the scene that the ground is of
  std::unique_ptr<Ground> ground;
  FibreMemory fibres;
  WeightMemory weights;
  ContactMemory contact;
};

// fibre_directions. `memory` may be null, here and below.
std::vector<float> fibres_of(const scene::Scene& scene, const Layering& layering, Ground& ground,
                             FibreMemory* memory, Report& report);

// region_weights of the model's rest shape, masses and fibres.
RegionWeights weights_of(const scene::Scene& scene, const Layering& layering, const OneRings& rings,
                         WeightMemory* memory, const model::Model& model);

// write_contact.
void add_contact(const scene::Scene& scene, const ContactGroups& groups, ContactMemory* memory,
                 model::Model& model);

}  // namespace fascicle::build
