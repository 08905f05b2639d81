// A model's tetrahedra as a VTK file, for ParaView.
#pragma once

#include <filesystem>
#include <string>

#include "host/model/model.h"

namespace fascicle::cli {

// Text of a .vtu file, in ASCII because our own mesh reader accepts nothing else. Rest positions are in
// metres and in the model's order. Point data: source_vertex, layer, kinematic, alpha, beta, fibre and mass
// (kg). Cell data: the layer of most of a cell's vertices (the lowest if tied).
std::string model_vtu_text(const model::Model& model);

// Writes all or nothing. Throws std::system_error.
void write_model_vtu(const std::filesystem::path& path, const model::Model& model);

}  // namespace fascicle::cli
