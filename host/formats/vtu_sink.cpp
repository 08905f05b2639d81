// vtu/frame_NNNNNN.vtu: VTK unstructured grids for ParaView, one compressed file per frame; vtu/series.pvd is
// the collection with their times. Tetrahedra in metres with displacement from frame 0 (m), velocity (m/s),
// layer (an index into the field data's list `layers`), kinematic, and source_vertex, the vertex's number in
// the input's tetrahedral mesh. Files cannot share arrays: constant data is compressed once and written to
// each.
#include <limits>
#include <optional>

#include "host/base/errors.h"
#include "host/base/text.h"
#include "host/formats/formats.h"
#include "host/formats/surface.h"
#include "host/formats/vtk_xml.h"

namespace fascicle::formats {

namespace {

class VtuSink final : public FrameSink {
 public:
  std::string name() const override { return "vtu"; }
  model::Read needs() const override { return {.positions = true, .velocities = true}; }
  void begin(const BakeInfo& info) override;
  void write(const model::Frame& frame) override;
  void sync() override { frames_->sync(); }
  void finish() override { frames_->finish(); }

 private:
  BakeInfo info_;
  std::optional<VtkFrames> frames_;
  std::vector<VtkNames> names_;
  // Constant over time, compressed once.
  std::string layer_, kinematic_, source_vertex_, connectivity_, offsets_, types_;
};

void VtuSink::begin(const BakeInfo& info) {
  info_ = info;
  const model::Model& model = *info.model;
  if (model.tetrahedron.size() > std::numeric_limits<std::int32_t>::max())
    throw base::BakeError("vtu: " + base::number_text(model.tetrahedron_count()) +
                          " tetrahedra are more than its 32-bit offsets hold; leave out --format vtu");
  std::vector<std::uint8_t> layer, kinematic;
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    layer.push_back(static_cast<std::uint8_t>(model.layer_of(i)));
    kinematic.push_back(model.is_kinematic(i) ? 1 : 0);
  }
  std::vector<std::int32_t> offsets;
  for (std::uint32_t t = 1; t <= model.tetrahedron_count(); ++t)
    offsets.push_back(static_cast<std::int32_t>(4 * t));
  layer_ = vtk_compressed_values(layer);
  kinematic_ = vtk_compressed_values(kinematic);
  source_vertex_ = vtk_compressed_values(model.source_vertex);
  connectivity_ = vtk_compressed_values(model.tetrahedron);  // below 2^31, so the same bits as Int32
  offsets_ = vtk_compressed_values(offsets);
  types_ = vtk_compressed_values(std::vector<std::uint8_t>(model.tetrahedron_count(), vtk_tetra));
  VtkNames layers{.name = "layers", .values = {}};
  for (const model::Layer& each : model.layers) layers.values.push_back(each.name);
  names_ = {layers};
  frames_.emplace(info, "vtu");
}

void VtuSink::write(const model::Frame& frame) {
  const model::Model& model = *info_.model;
  const std::vector<float> points = world_positions(frame.positions, model.unit, frame.origin);
  std::vector<float> displacement(points.size()), velocity(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    // From the unrounded positions: far from the world origin, the difference of floats would lose precision.
    const double moved = double{frame.positions[i]} - double{info_.initial->positions[i]};
    displacement[i] =
        static_cast<float>((frame.origin[i % 3] - info_.initial->origin[i % 3]) + model.unit * moved);
    velocity[i] = static_cast<float>(model.unit * double{frame.velocities[i]});
  }
  VtkArrays arrays;
  const auto floats = [&](const char* name, const std::vector<float>& values) {
    return arrays.add("Float32", name, 3, std::span<const float>(values));
  };
  std::string text = vtk_field_data(frames_->time_of(frame.index), names_) + "    <Piece NumberOfPoints=\"" +
                     base::number_text(model.vertex_count) + "\" NumberOfCells=\"" +
                     base::number_text(model.tetrahedron_count()) + "\">\n";
  // One array per statement: arrays are stored in the order of the calls.
  text += "      <Points>\n";
  text += floats("position", points);
  text += "      </Points>\n      <PointData>\n";
  text += floats("displacement", displacement);
  text += floats("velocity", velocity);
  text += arrays.add("UInt8", "layer", 1, layer_);
  text += arrays.add("UInt8", "kinematic", 1, kinematic_);
  text += arrays.add("UInt32", "source_vertex", 1, source_vertex_);
  text += "      </PointData>\n      <Cells>\n";
  text += arrays.add("Int32", "connectivity", 1, connectivity_);
  text += arrays.add("Int32", "offsets", 1, offsets_);
  text += arrays.add("UInt8", "types", 1, types_);
  text += "      </Cells>\n    </Piece>\n";
  frames_->write(frame.index, arrays.file("UnstructuredGrid", text));
}

std::uint64_t vtu_bytes(const model::Model& model, std::uint64_t frames) {
  const std::uint64_t points = model.vertex_count, cells = model.tetrahedron_count();
  std::uint64_t bytes = 1700;
  for (const std::uint64_t array :
       {points * 12, points * 12, points * 12, points, points, points * 4, cells * 16, cells * 4, cells})
    bytes += vtk_compressed_bound(array);
  return frames * (bytes + 70);  // and the frame's line in the collection
}

}  // namespace

// Not available to export: the frame cache has no velocities.
Format vtu_format() {
  return {.name = "vtu",
          .file = "vtu/",
          .make = make_sink<VtuSink>,
          .bytes = vtu_bytes,
          .beside = {std::string("vtu/") + vtk_series},
          .from_cache = false};
}

}  // namespace fascicle::formats
