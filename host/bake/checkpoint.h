// The file `checkpoint`: what a solver needs to continue, and the identity of the bake.
//
// Little-endian: char[8] "FASCCKPT", uint32 version 4, uint32 size of the identity in bytes, the identity (a
// JSON array of name and value pairs), uint64 frame, float64[3] origin (m), then positions, velocities,
// rotations, skinned, skinned velocities, positions and velocities before the last substep, each a uint64
// count and float32 values, float64 length of that substep (s), the skinned positions of the frame before the
// last and of the last frame, each again a count and values, and the XXH3-64 of all preceding bytes.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "host/bake/identity.h"
#include "host/model/solver.h"

namespace fascicle::bake {

inline constexpr const char* checkpoint_name = "checkpoint";

struct Checkpoint {
  Identity identity;
  model::State state;
  // The skinned positions that sinks got for the last two frames written, the older one first: a resumed bake
  // measures its look against them. Empty if no look is measured.
  std::array<std::vector<float>, 2> skinned = {};
};

// A view of the same, for writing.
struct CheckpointView {
  const Identity& identity;
  const model::State& state;
  const std::array<std::vector<float>, 2>& skinned;
};
inline CheckpointView view_of(const Checkpoint& checkpoint) {
  return {checkpoint.identity, checkpoint.state, checkpoint.skinned};
}

// Encodes the file's bytes, and decodes them. The latter throws BakeError, naming `path`, if they are not a
// whole checkpoint.
std::string checkpoint_text(const Checkpoint& checkpoint);
Checkpoint parse_checkpoint(std::string_view bytes, const std::filesystem::path& path);

// Replaces the file atomically.
void write_checkpoint(const std::filesystem::path& path, const CheckpointView& checkpoint);
// Empty if there is no such file. Throws BakeError if it is not a whole checkpoint.
std::optional<Checkpoint> read_checkpoint(const std::filesystem::path& path);
// Throws BakeError, naming `path`, if a bake of this model with this many frames cannot continue from it.
void check_checkpoint(const Checkpoint& checkpoint, const model::Model& model, std::uint64_t frames,
                      const std::filesystem::path& path);
// Whether the file begins like a checkpoint. False if it cannot be read.
bool is_checkpoint(const std::filesystem::path& path);

// The estimated size of the file, not below it for a scene of the usual length.
std::uint64_t checkpoint_bytes(const model::Model& model);

}  // namespace fascicle::bake
