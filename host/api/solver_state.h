// A solver's history as bytes, and what it shows.
#pragma once

#include "host/api/handles.h"

namespace fascicle::api {

// Throws bake::NotFinite.
void check_finite(const std::vector<float>& positions, std::uint64_t frame);
// The frame that `state` stands at. Throws bake::NotFinite, and then shows what it did before.
void show(fascicle_solver& solver, const model::State& state);

}  // namespace fascicle::api
