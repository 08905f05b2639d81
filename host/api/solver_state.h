// A solver's history as bytes, and what it shows.
#pragma once

#include "host/api/handles.h"

namespace fascicle::api {

// The frame that `state` stands at.
void show(fascicle_solver& solver, const model::State& state);

}  // namespace fascicle::api
