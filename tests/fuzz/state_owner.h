// The solver whose saved states the fuzzer reads: a model of two vertices and a joint.
#pragma once

#include "host/api/saved_state.h"
#include "host/model/model.h"

namespace fascicle::fuzz {

inline model::Model model_of_two() {
  model::Model model;
  model.vertex_count = 2;
  model.joint_count = 1;
  return model;
}

inline bake::Identity identity_of_two() {
  return {{"model", "a"}};
}

}  // namespace fascicle::fuzz
