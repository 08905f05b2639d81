// A model's tetrahedra as a VTK file, for ParaView.
#pragma once

#include <filesystem>
#include <string>

#include "host/model/model.h"

namespace fascicle::cli {

// Text of a .vtu, in ASCII because our own reader of meshes takes no other: rest positions in metres in the
// model's order; at the points source_vertex, layer, kinematic, alpha, beta, fibre and mass (kg); in each
// cell the layer that most of its vertices have (the lowest of equals).
std::string model_vtu_text(const model::Model& model);

// Whole or not at all. Throws std::system_error.
void write_model_vtu(const std::filesystem::path& path, const model::Model& model);

}  // namespace fascicle::cli
