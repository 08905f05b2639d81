// model.fascicle: the model that a bake moved, so that pictures and exports need nothing but the bake's
// folder.
//
// Little-endian. char[8] "FASCMODL", then the fields in the order of host/model/model_arrays.h, then the
// XXH3-64 of everything before. A field is the length of its name (uint32), its name, the bytes of an element
// (uint32), the number of elements (uint64) and the elements. A file whose names or element sizes are not
// those of this program belongs to another version.
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

// The model of such bytes, which passes model::check_model. Throws BakeError with what is wrong.
model::Model decode_model(std::string_view bytes);

// The model of a bake's folder; its hash must be `model_hash` (of the frame cache) where there is one, and it
// passes model::check_model. Throws BakeError with what is wrong and what to do, std::system_error if it
// cannot be read.
model::Model read_model_file(const std::filesystem::path& path, std::optional<std::uint64_t> model_hash);

// The same of the folder that the frames lie in, whose header this is: they are of as many vertices, in the
// same unit. Throws BakeError where the file is missing too.
model::Model read_model_of_frames(const std::filesystem::path& folder, const CacheHeader& header);

}  // namespace fascicle::bake
