// A solver's state as bytes, and the frame it shows.
#pragma once

#include "host/api/handles.h"

namespace fascicle::api {

// Throws bake::NotFinite.
void check_finite(const std::vector<float>& positions, double unit, std::uint64_t frame);
// Shows the frame of `state`. If it throws bake::NotFinite, the shown frame is unchanged.
void show(fascicle_solver& solver, const model::State& state);

}  // namespace fascicle::api
