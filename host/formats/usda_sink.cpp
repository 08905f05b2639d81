// surface.usda: USD's text format. Each object is a UsdGeomMesh /body/OBJECT with time samples of points,
// normals, velocities and extent, and the first frame as the default value; time code k is frame k. Materials
// are UsdPreviewSurfaces, bound to the mesh or to its GeomSubsets.
//
// A USD file stores all samples of an attribute together, but frames arrive one by one. Samples therefore go
// into a temporary stream, and finish() puts them in place. The velocities of a frame are known one frame
// later.
#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <utility>

#include "host/base/errors.h"
#include "host/base/part_file.h"
#include "host/base/text.h"
#include "host/base/version.h"
#include "host/formats/formats.h"
#include "host/formats/surface.h"
#include "host/formats/surface_normals.h"
#include "host/formats/surface_objects.h"
#include "host/formats/surface_velocities.h"
#include "host/formats/usd_skel.h"
#include "host/formats/usd_text.h"

namespace fascicle::formats {

namespace {

constexpr const char* usda_spool = "surface.usda.samples";

// Where an attribute's samples are in the stream.
struct SampleBytes {
  std::uint64_t offset = 0, bytes = 0;
};
using Pieces = std::vector<SampleBytes>;

// The pieces of one object.
struct MeshPieces {
  Pieces points, normals, velocities, extents;
};

class UsdaSink final : public FrameSink {
 public:
  std::string name() const override { return "usda"; }
  model::Read needs() const override { return {.surface = true}; }
  bool resumes() const override { return false; }
  void begin(const BakeInfo& info) override;
  void write(const model::Frame& frame) override;
  // No checkpoint relies on this file: a resumed bake rewrites it.
  void sync() override {}
  void finish() override;

 private:
  void add_sample(Pieces& to, std::uint64_t frame, std::span<const float> values);
  void add_velocities(std::uint64_t frame, const std::vector<float>& velocities);
  std::string header() const;
  void write_samples(int level, const std::string& attribute, const Pieces& pieces);
  void write_mesh(std::size_t k);

  BakeInfo info_;
  double unit_ = 1.0;
  std::shared_ptr<const SurfaceObjects> surface_;
  std::string materials_path_;
  std::optional<UsdSkel> skel_;
  std::optional<SurfaceNormals> normals_;
  std::optional<SurfaceVelocities> velocities_;
  std::vector<float> first_points_, first_normals_;
  std::vector<MeshPieces> meshes_;
  Pieces extents_;  // of the whole surface
  std::uint64_t frames_ = 0;
  std::optional<base::PartFile> file_;
  std::optional<base::SpoolFile> samples_;
};

void UsdaSink::begin(const BakeInfo& info) {
  const model::Model& model = *info.model;
  require_surface(model, "usda");
  info_ = info;
  unit_ = model.unit;
  surface_ = objects_of(info);
  normals_.emplace(model, surface_->normals);
  velocities_.emplace(info.fps);
  meshes_.resize(surface_->objects.size());
  const auto free_path = [&](std::string name) {
    while (std::any_of(surface_->objects.begin(), surface_->objects.end(),
                       [&](const SurfaceObject& object) { return object.identifier == name; }))
      name += '_';
    return "/body/" + name;
  };
  materials_path_ = free_path("Materials");
  if (info.usd_skel) {
    if (info.character.empty()) throw base::BakeError("--usd-skel: takes a character; leave the option out");
    skel_.emplace(info.character, *surface_, free_path("Skinning"), materials_path_);
  }
  file_.emplace(base::PartFile::start(info.folder / "surface.usda"));
  samples_.emplace(base::SpoolFile::start(info.folder / usda_spool));
  write_textures(info.folder, *surface_);
}

void UsdaSink::add_sample(Pieces& to, std::uint64_t frame, std::span<const float> values) {
  const std::uint64_t offset = samples_->size();
  samples_->write(base::number_text(info_.first_number + frame) + ": " + usd_tuples(values, 3) + ",\n");
  to.push_back({offset, samples_->size() - offset});
}

void UsdaSink::write(const model::Frame& frame) {
  std::vector<float> points = world_positions(frame.surface, unit_, frame.origin);
  const std::vector<float> normals = normals_->of(frame.surface);
  add_sample(extents_, frame.index, bounds(points));
  for (std::size_t k = 0; k < meshes_.size(); ++k) {
    const std::span<const float> own = values_of(surface_->objects[k], points);
    add_sample(meshes_[k].points, frame.index, own);
    add_sample(meshes_[k].normals, frame.index, values_of(surface_->objects[k], normals));
    add_sample(meshes_[k].extents, frame.index, bounds(own));
  }
  if (frames_ == 0) {
    first_points_ = points;
    first_normals_ = normals;
  }
  add_velocities(frame.index - 1, velocities_->next(std::move(points)));
  ++frames_;
}

void UsdaSink::add_velocities(std::uint64_t frame, const std::vector<float>& velocities) {
  if (velocities.empty()) return;
  for (std::size_t k = 0; k < meshes_.size(); ++k)
    add_sample(meshes_[k].velocities, frame, values_of(surface_->objects[k], velocities));
}

std::string UsdaSink::header() const {
  const std::string fps = base::number_text(info_.fps);
  return "#usda 1.0\n(\n" + usd_line(1, "customLayerData = {") +
         usd_line(2, std::string("string generator = \"fascicle ") + base::fascicle_version + '"') +
         usd_line(2, "double clipStartSeconds = " + base::number_text(info_.start)) + usd_line(1, "}") +
         usd_line(1, "defaultPrim = \"body\"") +
         usd_line(1, "endTimeCode = " + base::number_text(info_.first_number + info_.frames)) +
         usd_line(1, "framesPerSecond = " + fps) + usd_line(1, "metersPerUnit = 1") +
         usd_line(1, "startTimeCode = " + base::number_text(info_.first_number)) +
         usd_line(1, "timeCodesPerSecond = " + fps) + usd_line(1, "upAxis = \"Y\"") + ")\n\n" +
         "def Xform \"body\" (\n" + usd_line(1, "prepend apiSchemas = [\"GeomModelAPI\"]") +
         usd_line(1, "kind = \"component\"") + ")\n{\n";
}

void UsdaSink::write_samples(int level, const std::string& attribute, const Pieces& pieces) {
  const std::string before = usd_line(level + 1, "");
  file_->write(usd_line(level, attribute + ".timeSamples = {"));
  for (const SampleBytes& piece : pieces) {
    file_->write(std::string_view(before).substr(0, before.size() - 1));
    samples_->copy_to(*file_, piece.offset, piece.bytes);
  }
  file_->write(usd_line(level, "}"));
}

void UsdaSink::write_mesh(std::size_t k) {
  const SurfaceObject& object = surface_->objects[k];
  const MeshPieces& pieces = meshes_[k];
  const UsdMesh mesh = usd_mesh(*surface_, object, materials_path_, "", 1);
  const std::span<const float> points = values_of(object, first_points_);
  // Readers that ignore time show the first frame.
  file_->write(
      mesh.head + usd_line(2, "point3f[] points = " + usd_tuples(points, 3)) +
      usd_line(2, "normal3f[] normals = " + usd_tuples(values_of(object, first_normals_), 3) + " (") +
      usd_line(3, "interpolation = \"vertex\"") + usd_line(2, ")") +
      usd_line(2, "float3[] extent = " + usd_tuples(bounds(points), 3)));
  write_samples(2, "point3f[] points", pieces.points);
  write_samples(2, "normal3f[] normals", pieces.normals);
  write_samples(2, "vector3f[] velocities", pieces.velocities);
  write_samples(2, "float3[] extent", pieces.extents);
  file_->write(mesh.tail);
}

void UsdaSink::finish() {
  add_velocities(frames_ - 1, velocities_->last());
  file_->write(header() + usd_line(1, "float3[] extentsHint = " + usd_tuples(bounds(first_points_), 3)));
  write_samples(1, "float3[] extentsHint", extents_);
  for (std::size_t k = 0; k < meshes_.size(); ++k) write_mesh(k);
  if (skel_)
    skel_->write(*file_, {.frames = info_.frames, .first_number = info_.first_number, .fps = info_.fps}, 1);
  file_->write(usd_materials(*surface_, materials_path_, 1) + "}\n");
  file_->finish();
  samples_->remove();
}

std::uint64_t usda_bytes(const model::Model& model, std::uint64_t frames) {
  // About 36 characters per position, normal and velocity; 25 per triangle and 24 per texture coordinate.
  return 2000 + model.surface_triangle.size() / 3 * 35 + std::uint64_t{96} * model.surface_count() +
         frames * (400 + std::uint64_t{108} * model.surface_count());
}

}  // namespace

Format usda_format() {
  return {.name = "usda",
          .file = "surface.usda",
          .make = make_sink<UsdaSink>,
          .bytes = usda_bytes,
          .beside = {usda_spool}};
}

}  // namespace fascicle::formats
