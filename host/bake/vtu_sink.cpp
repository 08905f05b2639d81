// vtu/: VTK unstructured grids, one file a frame with raw appended data, and a ParaView collection with their
// times.
#include <limits>
#include <optional>

#include "host/bake/bake.h"
#include "host/bake/file.h"
#include "host/bake/formats.h"
#include "host/bake/frame_files.h"
#include "host/bake/surface.h"
#include "host/bake/text.h"

namespace fascicle::bake {

namespace {

constexpr std::uint8_t vtk_tetra = 10;

// One array of the appended data; each is preceded there by its length as a uint64.
struct ArrayField {
  const char* type;
  const char* name;
  std::uint32_t components;
  std::uint64_t bytes;  // without the length
};

class VtuSink final : public FrameSink {
 public:
  std::string name() const override { return "vtu"; }
  model::Read needs() const override { return {.positions = true, .velocities = true}; }
  void begin(const BakeInfo& info) override;
  void write(const model::Frame& frame) override;
  void sync() override { files_->sync(); }
  void finish() override;

 private:
  double time_of(std::uint64_t frame) const { return info_.start + static_cast<double>(frame) / info_.fps; }

  BakeInfo info_;
  std::optional<FrameFiles> files_;
  std::string constant_;  // the arrays that no frame changes, as they stand in the file
};

template <class T>
void append_sized(std::string& out, const std::vector<T>& values) {
  append_bytes(out, std::uint64_t{values.size() * sizeof(T)});
  append_array(out, std::span<const T>(values));
}

// The arrays of a file in their order: points, point data, cells.
std::vector<ArrayField> fields(const model::Model& model) {
  const std::uint64_t points = model.vertex_count, cells = model.tetrahedron_count();
  return {{"Float32", "position", 3, points * 12},
          {"Float32", "displacement", 3, points * 12},
          {"Float32", "velocity", 3, points * 12},
          {"UInt8", "layer", 1, points},
          {"UInt8", "kinematic", 1, points},
          {"UInt32", "source_vertex", 1, points * 4},
          {"Int32", "connectivity", 1, cells * 16},
          {"Int32", "offsets", 1, cells * 4},
          {"UInt8", "types", 1, cells}};
}

std::string constant_arrays(const model::Model& model) {
  std::vector<std::uint8_t> layer, kinematic;
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    layer.push_back(static_cast<std::uint8_t>(model.layer_of(i)));
    kinematic.push_back(model.is_kinematic(i) ? 1 : 0);
  }
  std::vector<std::int32_t> offsets;
  for (std::uint32_t t = 1; t <= model.tetrahedron_count(); ++t)
    offsets.push_back(static_cast<std::int32_t>(4 * t));
  std::string bytes;
  append_sized(bytes, layer);
  append_sized(bytes, kinematic);
  append_sized(bytes, model.source_vertex);
  append_sized(bytes, model.tetrahedron);  // below 2^31, so the same bits as Int32
  append_sized(bytes, offsets);
  append_sized(bytes, std::vector<std::uint8_t>(model.tetrahedron_count(), vtk_tetra));
  return bytes;
}

constexpr const char* text_after_arrays = "\n  </AppendedData>\n</VTKFile>\n";

// A file up to its appended data.
std::string text_before_arrays(const model::Model& model, double time) {
  const std::vector<ArrayField> arrays = fields(model);
  std::uint64_t offset = 0;
  const auto tag = [&](const ArrayField& field) {
    const std::string text = "        <DataArray type=\"" + std::string(field.type) + "\" Name=\"" +
                             field.name + "\" NumberOfComponents=\"" + number_text(field.components) +
                             "\" format=\"appended\" offset=\"" + number_text(offset) + "\"/>\n";
    offset += sizeof(std::uint64_t) + field.bytes;
    return text;
  };
  std::string text =
      "<?xml version=\"1.0\"?>\n"
      "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" "
      "header_type=\"UInt64\">\n"
      "  <UnstructuredGrid>\n"
      "    <FieldData>\n"
      "      <DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" format=\"ascii\">" +
      number_text(time) +
      "</DataArray>\n"
      "    </FieldData>\n"
      "    <Piece NumberOfPoints=\"" +
      number_text(model.vertex_count) + "\" NumberOfCells=\"" + number_text(model.tetrahedron_count()) +
      "\">\n";
  text += "      <Points>\n" + tag(arrays[0]) + "      </Points>\n      <PointData>\n";
  for (std::size_t k = 1; k < 6; ++k) text += tag(arrays[k]);
  text += "      </PointData>\n      <Cells>\n";
  for (std::size_t k = 6; k < arrays.size(); ++k) text += tag(arrays[k]);
  return text + "      </Cells>\n    </Piece>\n  </UnstructuredGrid>\n  <AppendedData encoding=\"raw\">\n_";
}

void VtuSink::begin(const BakeInfo& info) {
  info_ = info;
  const model::Model& model = *info.model;
  if (model.tetrahedron.size() > std::numeric_limits<std::int32_t>::max())
    throw BakeError("vtu: " + number_text(model.tetrahedron_count()) +
                    " tetrahedra are more than its 32-bit offsets hold; leave out --format vtu");
  constant_ = constant_arrays(model);
  files_.emplace(info.folder, vtu_extension, info.first);
}

void VtuSink::write(const model::Frame& frame) {
  const model::Model& model = *info_.model;
  const std::vector<float> points = world_positions(frame.positions, model.unit, frame.origin);
  std::vector<float> displacement(points.size()), velocity(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    // From the unrounded positions: far from the world's origin a difference of floats would lose what it
    // shows.
    const double moved = double{frame.positions[i]} - double{info_.initial->positions[i]};
    displacement[i] =
        static_cast<float>((frame.origin[i % 3] - info_.initial->origin[i % 3]) + model.unit * moved);
    velocity[i] = static_cast<float>(model.unit * double{frame.velocities[i]});
  }
  std::string bytes = text_before_arrays(model, time_of(frame.index));
  append_sized(bytes, points);
  append_sized(bytes, displacement);
  append_sized(bytes, velocity);
  bytes += constant_;
  bytes += text_after_arrays;
  files_->write(frame.index, bytes);
}

void VtuSink::finish() {
  files_->sync();
  std::string text =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">\n  "
      "<Collection>\n";
  for (std::uint64_t k = 0; k <= info_.frames; ++k)
    text += "    <DataSet timestep=\"" + number_text(time_of(k)) + "\" file=\"" +
            frame_file_name(k, vtu_extension) + "\"/>\n";
  write_whole(files_->folder() / vtu_series, text + "  </Collection>\n</VTKFile>\n");
}

}  // namespace

std::unique_ptr<FrameSink> make_vtu_sink() {
  return std::make_unique<VtuSink>();
}

std::uint64_t vtu_bytes(const model::Model& model, std::uint64_t frames) {
  std::uint64_t bytes = text_before_arrays(model, 0.125).size() + std::string(text_after_arrays).size();
  for (const ArrayField& field : fields(model)) bytes += sizeof(std::uint64_t) + field.bytes;
  return frames * (bytes + 70);  // and the frame's line in the collection
}

}  // namespace fascicle::bake
