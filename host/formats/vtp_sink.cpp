// vtp/frame_NNNNNN.vtp: the render surface for ParaView, one VTK file per frame, with normals and texture
// coordinates; vtp/series.pvd is the collection with their times. A triangle's object and material are
// indices into the field data's lists `objects` and `materials`, -1: none. Accompanies vtu if the scene has a
// surface.
#include <memory>
#include <optional>

#include "host/base/text.h"
#include "host/formats/formats.h"
#include "host/formats/surface.h"
#include "host/formats/surface_normals.h"
#include "host/formats/surface_objects.h"
#include "host/formats/vtk_xml.h"

namespace fascicle::formats {

namespace {

class VtpSink final : public FrameSink {
 public:
  std::string name() const override { return "vtp"; }
  model::Read needs() const override { return {.surface = true}; }
  void begin(const BakeInfo& info) override;
  void write(const model::Frame& frame) override;
  void sync() override { frames_->sync(); }
  void finish() override { frames_->finish(); }

 private:
  BakeInfo info_;
  std::shared_ptr<const SurfaceObjects> surface_;
  std::optional<SurfaceNormals> normals_;
  std::optional<VtkFrames> frames_;
  std::vector<VtkNames> names_;
  // Constant over time, compressed once.
  std::string uvs_, connectivity_, offsets_, objects_, materials_;
};

void VtpSink::begin(const BakeInfo& info) {
  info_ = info;
  const model::Model& model = *info.model;
  require_surface(model, "vtp");
  surface_ = objects_of(info);
  normals_.emplace(model, surface_->normals);
  frames_.emplace(info, "vtp");
  std::vector<std::int32_t> objects, materials, offsets;
  std::vector<float> uvs;
  bool has_uvs = false;
  VtkNames object_names{.name = "objects", .values = {}}, material_names{.name = "materials", .values = {}};
  for (const SurfaceMaterial& material : surface_->materials) material_names.values.push_back(material.name);
  for (const SurfaceObject& object : surface_->objects) {
    std::vector<std::int32_t> shown(object.triangle.size() / 3, -1);
    for (const FaceSet& set : object.face_sets)
      for (const std::uint32_t t : set.triangles) shown[t] = static_cast<std::int32_t>(set.material);
    materials.insert(materials.end(), shown.begin(), shown.end());
    objects.insert(objects.end(), shown.size(), static_cast<std::int32_t>(object_names.values.size()));
    object_names.values.push_back(object.name);
    has_uvs = has_uvs || !object.uvs.empty();
    uvs.insert(uvs.end(), object.uvs.begin(), object.uvs.end());
    uvs.resize(std::size_t{2} * (object.first_vertex + object.vertex_count), 0.0f);
  }
  for (std::size_t t = 1; t <= objects.size(); ++t) offsets.push_back(static_cast<std::int32_t>(3 * t));
  names_ = {object_names, material_names};
  if (has_uvs) uvs_ = vtk_compressed_values(uvs);
  connectivity_ = vtk_compressed_values(model.surface_triangle);  // below 2^31, so the same bits as Int32
  offsets_ = vtk_compressed_values(offsets);
  objects_ = vtk_compressed_values(objects);
  materials_ = vtk_compressed_values(materials);
}

void VtpSink::write(const model::Frame& frame) {
  const std::vector<float> points = world_positions(frame.surface, info_.model->unit, frame.origin);
  const std::vector<float> normals = normals_->of(frame.surface);
  VtkArrays arrays;
  // One array per statement: arrays are stored in the order of the calls.
  std::string text = vtk_field_data(frames_->time_of(frame.index), names_) + "    <Piece NumberOfPoints=\"" +
                     base::number_text(std::uint64_t{points.size() / 3}) + "\" NumberOfPolys=\"" +
                     base::number_text(std::uint64_t{info_.model->surface_triangle.size() / 3}) + "\">\n";
  text += "      <Points>\n";
  text += arrays.add("Float32", "position", 3, std::span<const float>(points));
  text += "      </Points>\n      <PointData Normals=\"normal\"";
  text += uvs_.empty() ? ">\n" : " TCoords=\"uv\">\n";
  text += arrays.add("Float32", "normal", 3, std::span<const float>(normals));
  if (!uvs_.empty()) text += arrays.add("Float32", "uv", 2, uvs_);
  text += "      </PointData>\n      <CellData>\n";
  text += arrays.add("Int32", "object", 1, objects_);
  text += arrays.add("Int32", "material", 1, materials_);
  text += "      </CellData>\n      <Polys>\n";
  text += arrays.add("Int32", "connectivity", 1, connectivity_);
  text += arrays.add("Int32", "offsets", 1, offsets_);
  text += "      </Polys>\n    </Piece>\n";
  frames_->write(frame.index, arrays.file("PolyData", text));
}

std::uint64_t vtp_bytes(const model::Model& model, std::uint64_t frames) {
  const std::uint64_t points = model.surface_count(), triangles = model.surface_triangle.size() / 3;
  std::uint64_t bytes = 1350;
  for (const std::uint64_t array :
       {points * 12, points * 12, points * 8, triangles * 4, triangles * 4, triangles * 12, triangles * 4})
    bytes += vtk_compressed_bound(array);
  return frames * (bytes + 70);  // and the frame's line in the collection
}

}  // namespace

Format vtp_format() {
  return {.name = "vtp",
          .file = "vtp/",
          .make = make_sink<VtpSink>,
          .bytes = vtp_bytes,
          .beside = {std::string("vtp/") + vtk_series}};
}

}  // namespace fascicle::formats
