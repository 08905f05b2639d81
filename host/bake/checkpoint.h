// The file `checkpoint`: what a solver needs to go on, and what the bake was.
//
// Little-endian: char[8] "FASCCKPT", uint32 version 2, uint32 bytes of the identity, the identity (a JSON
// array of name and value pairs), uint64 frame, float64[3] origin (m), then positions, velocities, rotations
// skinned and skinned velocities, each a uint64 count and float32 values, and the XXH3-64 of all bytes
// before.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "host/bake/identity.h"
#include "host/model/solver.h"

namespace fascicle::bake {

inline constexpr const char* checkpoint_name = "checkpoint";

struct Checkpoint {
  Identity identity;
  model::State state;
};

// The file's bytes, and back. Throws BakeError, naming `path`, if they are not a whole checkpoint.
std::string checkpoint_text(const Checkpoint& checkpoint);
Checkpoint parse_checkpoint(std::string_view bytes, const std::filesystem::path& path);

// Replaces the file whole.
void write_checkpoint(const std::filesystem::path& path, const Checkpoint& checkpoint);
// Nothing if there is no such file. Throws BakeError if it is not a whole checkpoint.
std::optional<Checkpoint> read_checkpoint(const std::filesystem::path& path);
// Whether a file begins as a checkpoint does. False if it cannot be read.
bool is_checkpoint(const std::filesystem::path& path);

std::uint64_t checkpoint_bytes(const model::Model& model);

}  // namespace fascicle::bake
