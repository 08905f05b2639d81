// surface.usda: a UsdGeomMesh in USD's text form.
//
// A file of USD holds all samples of an attribute side by side, and frames come one by one. So points go
// straight into the file, normals and extents into streams beside it, and finish() puts these behind the
// points.
#include <array>
#include <optional>

#include "host/bake/bake.h"
#include "host/bake/file.h"
#include "host/bake/formats.h"
#include "host/bake/surface.h"
#include "host/bake/text.h"
#include "host/bake/version.h"

namespace fascicle::bake {

namespace {

constexpr const char* indent = "        ";

// [(x, y, z), ...]
void append_vectors(std::string& text, std::span<const float> values) {
  text += '[';
  for (std::size_t i = 0; i < values.size(); i += 3) {
    text += i == 0 ? "(" : ", (";
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (axis > 0) text += ", ";
      text += number_text(values[i + axis]);
    }
    text += ')';
  }
  text += ']';
}

std::string sample(std::uint64_t frame, std::span<const float> values) {
  std::string text = indent;
  text += "    " + number_text(frame) + ": ";
  append_vectors(text, values);
  return text + ",\n";
}

std::string opened(const std::string& attribute) {
  return indent + attribute + ".timeSamples = {\n";
}

std::string closed() {
  return std::string(indent) + "}\n";
}

std::string header(const BakeInfo& info) {
  const model::Model& model = *info.model;
  std::string text =
      "#usda 1.0\n(\n"
      "    customLayerData = {\n"
      "        string generator = \"fascicle ";
  text += fascicle_version;
  text += "\"\n        double clipStartSeconds = " + number_text(info.start) +
          "\n    }\n"
          "    defaultPrim = \"body\"\n"
          "    endTimeCode = " +
          number_text(info.frames) + "\n    framesPerSecond = " + number_text(info.fps) +
          "\n    metersPerUnit = 1\n"
          "    startTimeCode = 0\n"
          "    timeCodesPerSecond = " +
          number_text(info.fps) +
          "\n    upAxis = \"Y\"\n)\n\n"
          "def Xform \"body\" (\n    kind = \"component\"\n)\n{\n"
          "    def Mesh \"surface\"\n    {\n";
  text += indent;
  text += "int[] faceVertexCounts = [";
  for (std::size_t i = 0; i < model.surface_triangle.size(); i += 3) text += i == 0 ? "3" : ", 3";
  text += "]\n";
  text += indent;
  text += "int[] faceVertexIndices = [";
  for (std::size_t i = 0; i < model.surface_triangle.size(); ++i)
    text += (i == 0 ? "" : ", ") + number_text(model.surface_triangle[i]);
  text += "]\n";
  for (const char* line :
       {"uniform token orientation = \"rightHanded\"", "uniform token subdivisionScheme = \"none\"",
        "normal3f[] normals (", "    interpolation = \"vertex\"", ")"}) {
    text += indent;
    text += line;
    text += '\n';
  }
  return text + opened("point3f[] points");
}

class UsdaSink final : public FrameSink {
 public:
  std::string name() const override { return "usda"; }
  model::Read needs() const override { return {.surface = true}; }
  bool resumes() const override { return false; }
  void begin(const BakeInfo& info) override {
    if (info.model->surface_count() == 0)
      throw BakeError("usda: the scene has no surface to write; leave out --format usda");
    unit_ = info.model->unit;
    normals_.emplace(*info.model);
    points_file_.emplace(PartFile::start(info.folder / "surface.usda"));
    normals_file_.emplace(SpoolFile::start(info.folder / usda_normals_spool));
    extents_file_.emplace(SpoolFile::start(info.folder / usda_extents_spool));
    points_file_->write(header(info));
  }
  void write(const model::Frame& frame) override {
    const std::vector<float> points = world_positions(frame.surface, unit_, frame.origin);
    points_file_->write(sample(frame.index, points));
    normals_file_->write(sample(frame.index, normals_->of(frame.surface)));
    extents_file_->write(sample(frame.index, bounds(points)));
  }
  // Nothing counts on it: a resumed bake begins the file anew.
  void sync() override {}
  void finish() override {
    points_file_->write(closed() + opened("normal3f[] normals"));
    normals_file_->move_to(*points_file_);
    points_file_->write(closed() + opened("float3[] extent"));
    extents_file_->move_to(*points_file_);
    points_file_->write(closed() + "    }\n}\n");
    points_file_->finish();
  }

 private:
  double unit_ = 1.0;
  std::optional<SurfaceNormals> normals_;
  std::optional<PartFile> points_file_;
  std::optional<SpoolFile> normals_file_, extents_file_;
};

}  // namespace

std::unique_ptr<FrameSink> make_usda_sink() {
  return std::make_unique<UsdaSink>();
}

std::uint64_t usda_bytes(const model::Model& model, std::uint64_t frames) {
  // About 36 characters a position and a normal, 25 a triangle.
  return 1000 + model.surface_triangle.size() / 3 * 25 +
         frames * (200 + std::uint64_t{72} * model.surface_count());
}

}  // namespace fascicle::bake
