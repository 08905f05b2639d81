// obj/frame_NNNNNN.obj: Wavefront OBJ, one file per frame, for programs that read nothing else. Positions,
// texture coordinates, normals, and triangles with their materials; obj/surface.mtl if there are materials.
#include <memory>
#include <optional>

#include "host/base/part_file.h"
#include "host/base/text.h"
#include "host/formats/formats.h"
#include "host/formats/frame_files.h"
#include "host/formats/obj_text.h"
#include "host/formats/surface.h"
#include "host/formats/surface_normals.h"
#include "host/formats/surface_objects.h"

namespace fascicle::formats {

namespace {

constexpr const char* obj_extension = "obj";
constexpr const char* obj_materials = "surface.mtl";

void append_lines(std::string& text, const char* word, std::span<const float> values) {
  for (std::size_t i = 0; i < values.size(); i += 3) {
    text += word;
    for (std::size_t axis = 0; axis < 3; ++axis) text += ' ' + base::number_text(values[i + axis]);
    text += '\n';
  }
}

class ObjSink final : public FrameSink {
 public:
  std::string name() const override { return "obj"; }
  model::Read needs() const override { return {.surface = true}; }
  void begin(const BakeInfo& info) override {
    const model::Model& model = *info.model;
    require_surface(model, "obj");
    unit_ = model.unit;
    fps_ = info.fps;
    surface_ = objects_of(info);
    normals_.emplace(model, surface_->normals);
    files_.emplace(info.folder, obj_extension, info.first, info.first_number);
    std::uint64_t uvs = 0;
    for (const SurfaceObject& object : surface_->objects) {
      uvs_.push_back(obj_uvs(object));
      faces_.push_back(obj_faces(*surface_, object, uvs, true));
      uvs += object.uvs.size() / 2;
    }
    if (surface_->materials.empty()) return;
    write_textures(info.folder, *surface_);
    base::write_whole(files_->folder() / obj_materials, mtl_text(*surface_, "../"));
  }
  void write(const model::Frame& frame) override {
    const std::vector<float> points = world_positions(frame.surface, unit_, frame.origin);
    const std::vector<float> normals = normals_->of(frame.surface);
    std::string text = "# fascicle: frame " + base::number_text(files_->number_of(frame.index)) + ", " +
                       base::number_text(static_cast<double>(frame.index) / fps_) + " s at " +
                       base::number_text(fps_) + " frames a second, metres, Y up\n";
    if (!surface_->materials.empty()) text += std::string("mtllib ") + obj_materials + '\n';
    for (std::size_t k = 0; k < surface_->objects.size(); ++k) {
      const SurfaceObject& object = surface_->objects[k];
      text += "o " + obj_name(object.name) + '\n';
      append_lines(text, "v", values_of(object, points));
      text += uvs_[k];
      append_lines(text, "vn", values_of(object, normals));
      text += "s 1\n" + faces_[k];
    }
    files_->write(frame.index, text);
  }
  void sync() override { files_->sync(); }
  void finish() override { files_->sync(); }

 private:
  double unit_ = 1.0, fps_ = 60.0;
  std::shared_ptr<const SurfaceObjects> surface_;
  std::optional<SurfaceNormals> normals_;
  std::optional<FrameFiles> files_;
  std::vector<std::string> uvs_, faces_;  // per object
};

std::uint64_t obj_bytes(const model::Model& model, std::uint64_t frames) {
  // About 36 characters per position and per normal, 24 per texture coordinate, 40 per triangle.
  return frames * (100 + std::uint64_t{96} * model.surface_count() + model.surface_triangle.size() / 3 * 40);
}

}  // namespace

Format obj_format() {
  return {.name = "obj",
          .file = "obj/",
          .make = make_sink<ObjSink>,
          .bytes = obj_bytes,
          .beside = {std::string("obj/") + obj_materials}};
}

}  // namespace fascicle::formats
