// Turns a glTF file's materials into those for drawing.
#pragma once

#include <filesystem>
#include <optional>

#include "host/cli/log.h"
#include "host/model/model.h"
#include "host/render/looks.h"

namespace fascicle::cli {

// For the model's render mesh, which was read from `character`. nullopt if the file defines no colours. For
// an unreadable texture, warns and uses the surface's plain colour.
std::optional<render::Looks> looks_of(const std::filesystem::path& character, const model::Model& model,
                                      Log& log);

}  // namespace fascicle::cli
