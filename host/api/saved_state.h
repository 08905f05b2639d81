// The bytes of fascicle_solver_save, for fascicle_solver_load.
//
// Little-endian: char[8] "FASCSTP2", the hash of all that follows (32 hex digits), uint64 frame, uint64
// `driven`, uint64 count of the pose's numbers, float64 time (s), the last pose given (float64), then a
// checkpoint's bytes (host/bake/checkpoint.h) with the identity of the model and the solver's options.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "host/bake/identity.h"
#include "host/drive/timeline.h"
#include "host/model/solver.h"

namespace fascicle::api {

// What moves a solver. The numbers are part of the format.
enum class Driven { no, by_clip, by_poses, by_drives };

struct SavedState {
  std::uint64_t frame = 0;
  Driven driven = Driven::no;
  double time = 0.0;      // s; scene time at the end of the frame
  drive::Pose pose = {};  // the last one given, if driven by poses; else empty
  model::State state = {};
};

// Whose states can be loaded. A model without a scene is moved by drives only.
struct StateOwner {
  const model::Model& model;
  bool has_scene = false;
  bake::Identity identity;
};

std::string saved_state_bytes(const SavedState& saved, const bake::Identity& identity);
// Throws bake::BakeError if the bytes are not a whole state of this owner, or if its time, origin or pose is
// not finite. Its positions may be anything.
SavedState parse_saved_state(std::string_view bytes, const StateOwner& owner);

}  // namespace fascicle::api
