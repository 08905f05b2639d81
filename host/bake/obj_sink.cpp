// obj/: Wavefront OBJ, one file a frame, for whatever reads nothing else.
#include <optional>

#include "host/bake/bake.h"
#include "host/bake/formats.h"
#include "host/bake/frame_files.h"
#include "host/bake/surface.h"
#include "host/bake/text.h"

namespace fascicle::bake {

namespace {

void append_line(std::string& text, const char* word, const float* values) {
  text += word;
  for (std::size_t axis = 0; axis < 3; ++axis) text += ' ' + number_text(values[axis]);
  text += '\n';
}

class ObjSink final : public FrameSink {
 public:
  std::string name() const override { return "obj"; }
  model::Read needs() const override { return {.surface = true}; }
  void begin(const BakeInfo& info) override {
    const model::Model& model = *info.model;
    if (model.surface_count() == 0)
      throw BakeError("obj: the scene has no surface to write; leave out --format obj");
    unit_ = model.unit;
    fps_ = info.fps;
    normals_.emplace(model);
    files_.emplace(info.folder, obj_extension, info.first);
    for (std::size_t i = 0; i < model.surface_triangle.size(); i += 3) {
      faces_ += 'f';
      for (std::size_t k = 0; k < 3; ++k) {
        const std::string corner = number_text(std::uint64_t{model.surface_triangle[i + k]} + 1);
        faces_ += ' ' + corner + "//" + corner;
      }
      faces_ += '\n';
    }
  }
  void write(const model::Frame& frame) override {
    const std::vector<float> points = world_positions(frame.surface, unit_, frame.origin);
    const std::vector<float> normals = normals_->of(frame.surface);
    std::string text = "# fascicle: frame " + number_text(frame.index) + ", " +
                       number_text(static_cast<double>(frame.index) / fps_) + " s at " + number_text(fps_) +
                       " frames a second, metres, Y up\no surface\n";
    for (std::size_t i = 0; i < points.size(); i += 3) append_line(text, "v", &points[i]);
    for (std::size_t i = 0; i < normals.size(); i += 3) append_line(text, "vn", &normals[i]);
    files_->write(frame.index, text + "s 1\n" + faces_);
  }
  void sync() override { files_->sync(); }
  void finish() override { files_->sync(); }

 private:
  double unit_ = 1.0, fps_ = 60.0;
  std::optional<SurfaceNormals> normals_;
  std::optional<FrameFiles> files_;
  std::string faces_;
};

}  // namespace

std::unique_ptr<FrameSink> make_obj_sink() {
  return std::make_unique<ObjSink>();
}

std::uint64_t obj_bytes(const model::Model& model, std::uint64_t frames) {
  // About 36 characters a position and a normal, 30 a triangle.
  return frames * (100 + std::uint64_t{72} * model.surface_count() + model.surface_triangle.size() / 3 * 30);
}

}  // namespace fascicle::bake
