#include "host/cli/model_vtu.h"

#include <array>
#include <cstddef>

#include "host/base/part_file.h"
#include "host/base/text.h"
#include "host/formats/vtk_xml.h"

namespace fascicle::cli {
namespace {

// One <DataArray>; `value(item, component)` returns the numbers.
template <class Value>
void append_data(std::string& out, const std::string& type, const std::string& name, std::size_t items,
                 std::size_t components, Value value) {
  out += "<DataArray type=\"" + type + "\" Name=\"" + name + "\" NumberOfComponents=\"" +
         std::to_string(components) + "\" format=\"ascii\">\n";
  for (std::size_t item = 0; item < items; ++item)
    for (std::size_t component = 0; component < components; ++component) {
      out += base::number_text(value(item, component));
      out += component + 1 < components ? ' ' : '\n';
    }
  out += "</DataArray>\n";
}

std::uint32_t cell_layer(const model::Model& model, std::size_t cell) {
  std::array<std::uint32_t, 4> layers{};
  for (std::size_t corner = 0; corner < 4; ++corner)
    layers[corner] = model.layer_of(model.tetrahedron[4 * cell + corner]);
  std::uint32_t best = layers[0];
  int most = 0;
  for (const std::uint32_t layer : layers) {
    int count = 0;
    for (const std::uint32_t other : layers) count += other == layer ? 1 : 0;
    if (count > most || (count == most && layer < best)) {
      best = layer;
      most = count;
    }
  }
  return best;
}

}  // namespace

std::string model_vtu_text(const model::Model& model) {
  const std::size_t vertices = model.vertex_count;
  const std::size_t cells = model.tetrahedron_count();
  const auto vertex = [](std::size_t item) { return static_cast<std::uint32_t>(item); };

  std::string out =
      "<?xml version=\"1.0\"?>\n"
      "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" "
      "header_type=\"UInt64\">\n"
      "<UnstructuredGrid>\n<Piece NumberOfPoints=\"" +
      std::to_string(vertices) + "\" NumberOfCells=\"" + std::to_string(cells) + "\">\n";

  out += "<Points>\n";
  append_data(out, "Float64", "position", vertices, 3, [&](std::size_t i, std::size_t k) {
    return model.rest_origin[k] + model.unit * static_cast<double>(model.rest[3 * i + k]);
  });
  out += "</Points>\n<Cells>\n";
  append_data(out, "Int64", "connectivity", cells, 4,
              [&](std::size_t c, std::size_t k) { return model.tetrahedron[4 * c + k]; });
  append_data(out, "Int64", "offsets", cells, 1, [](std::size_t c, std::size_t) { return 4 * (c + 1); });
  append_data(out, "UInt8", "types", cells, 1,
              [](std::size_t, std::size_t) { return int{formats::vtk_tetra}; });
  out += "</Cells>\n<CellData Scalars=\"layer\">\n";
  append_data(out, "UInt32", "layer", cells, 1,
              [&](std::size_t c, std::size_t) { return cell_layer(model, c); });
  out += "</CellData>\n<PointData Scalars=\"layer\" Vectors=\"fibre\">\n";
  append_data(out, "UInt32", "source_vertex", vertices, 1,
              [&](std::size_t i, std::size_t) { return model.source_vertex[i]; });
  append_data(out, "UInt32", "layer", vertices, 1,
              [&](std::size_t i, std::size_t) { return model.layer_of(vertex(i)); });
  append_data(out, "UInt8", "kinematic", vertices, 1,
              [&](std::size_t i, std::size_t) { return model.is_kinematic(vertex(i)) ? 1 : 0; });
  append_data(out, "Float32", "alpha", vertices, 1,
              [&](std::size_t i, std::size_t) { return model.alpha[i]; });
  append_data(out, "Float32", "beta", vertices, 1, [&](std::size_t i, std::size_t) { return model.beta[i]; });
  append_data(out, "Float32", "fibre", vertices, 3,
              [&](std::size_t i, std::size_t k) { return model.fibre[3 * i + k]; });
  append_data(out, "Float64", "mass", vertices, 1, [&](std::size_t i, std::size_t) { return model.mass[i]; });
  out += "</PointData>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";
  return out;
}

void write_model_vtu(const std::filesystem::path& path, const model::Model& model) {
  base::write_whole_beside_others(std::filesystem::absolute(path), model_vtu_text(model));
}

}  // namespace fascicle::cli
