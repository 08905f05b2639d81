// model.fascicle: the model that a bake moved, so that pictures and exports need nothing but the bake's
// folder.
//
// Little-endian. char[8] "FASCMODL", then the fields in the order of host/model/model_arrays.h, then the
// XXH3-64 of everything before. A field is the length of its name (uint32), its name, the bytes of an element
// (uint32), the number of elements (uint64) and the elements. A file whose names or element sizes differ from
// this program's belongs to another version.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "host/bake/read_frame_cache.h"
#include "host/model/model.h"

namespace fascicle::bake {

inline constexpr const char* model_file_name = "model.fascicle";

std::string encode_model(const model::Model& model);
std::uint64_t encoded_bytes(const model::Model& model);

// Decodes a model, which passes model::check_model. Throws BakeError with what is wrong.
model::Model decode_model(std::string_view bytes);

// The model in a bake's folder; its hash must be `model_hash` (of the frame cache), if given, and it passes
// model::check_model. Throws BakeError with what is wrong and what to do, std::system_error if it cannot be
// read.
model::Model read_model_file(const std::filesystem::path& path, std::optional<std::uint64_t> model_hash);

// The same for the folder of a frame cache with this header; vertex count and unit must match too. Also
// throws BakeError if the file is missing.
model::Model read_model_of_frames(const std::filesystem::path& folder, const CacheHeader& header);

}  // namespace fascicle::bake
