// From a glTF file's materials to what pictures are painted with.
#pragma once

#include <filesystem>
#include <optional>

#include "host/cli/log.h"
#include "host/model/model.h"
#include "host/render/looks.h"

namespace fascicle::cli {

// Of the model's render mesh, which was read from `character`. Nothing where the file says nothing of colour.
// A texture that cannot be read is a warning, and its surface gets its plain colour.
std::optional<render::Looks> looks_of(const std::filesystem::path& character, const model::Model& model,
                                      Log& log);

}  // namespace fascicle::cli
