// surface.abc: Alembic in Ogawa form, written from the format's layout because Debian has no library for it.
// Each object is an AbcGeom_PolyMesh_v1 /OBJECT with samples of P, N, .velocities and .selfBnds, and its uv;
// each of its materials is an AbcGeom_FaceSet_v1 below it; the archive's bounds are /.childBnds.
//
//   root       0 int32 format version, 0    1 int32 Alembic version    2 group of the top object
//              3 archive metadata    4 time samplings    5 indexed metadata
//   object     0 group of its properties, then a group for each child object, then their headers
//   compound   a group for each property, then their headers
//   array      for each sample: data (16-byte digest, values), dimensions (empty: follow from the size)
//   scalar     for each sample: data (16-byte digest, value)
// An object's .geom has .selfBnds, P, .velocities, .faceIndices, .faceCounts, N and, if the object has them,
// uv. The velocities of a frame are known one frame later.
#include <algorithm>
#include <array>
#include <limits>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "host/base/errors.h"
#include "host/base/text.h"
#include "host/base/version.h"
#include "host/formats/formats.h"
#include "host/formats/murmur3.h"
#include "host/formats/ogawa_writer.h"
#include "host/formats/surface.h"
#include "host/formats/surface_normals.h"
#include "host/formats/surface_objects.h"
#include "host/formats/surface_velocities.h"

namespace fascicle::formats {

namespace {

using Child = OgawaWriter::Child;

constexpr std::int32_t form_version = 0;
// The library version whose layout these files follow; readers refuse versions below 9999.
constexpr std::int32_t alembic_version = 10803;
constexpr std::uint64_t digest_bytes = 16;
constexpr std::uint32_t frame_sampling = 1;  // index of the time sampling; 0 is for properties without time

enum class PropertyKind : std::uint32_t { compound = 0, scalar = 1, array = 2 };
enum class Pod : std::uint32_t { uint32 = 5, int32 = 6, float32 = 10, float64 = 11 };

struct Property {
  std::string name, metadata;
  PropertyKind kind = PropertyKind::compound;
  Pod pod = Pod::float32;
  std::uint32_t extent = 1;   // values per point
  std::uint32_t samples = 0;  // as readers count them
  bool constant = false;      // a single stored sample, valid for all times
  bool one_point = false;     // every sample of an array is a single point
};

void append_sized(std::string& out, std::uint32_t value, std::uint32_t size_hint) {
  std::string bytes;
  base::append_bytes(bytes, value);
  out += bytes.substr(0, std::size_t{1} << size_hint);
}

// Metadata shared by properties and objects, referred to by index; index 0 is empty.
class MetadataTable {
 public:
  std::uint32_t number_of(const std::string& text) {
    if (text.empty()) return 0;
    for (std::uint32_t k = 0; k < texts_.size(); ++k)
      if (texts_[k] == text) return k + 1;
    texts_.push_back(text);
    return static_cast<std::uint32_t>(texts_.size());
  }
  // Each entry must be below 256 bytes; all of ours are.
  std::string packed() const {
    std::string out;
    for (const std::string& text : texts_) {
      out += static_cast<char>(text.size());
      out += text;
    }
    return out;
  }

 private:
  std::vector<std::string> texts_;
};

// Bits 0-1: kind (1 | 2: array of single points); 2-3: size of integers (1 << n bytes); 4-7: type; 8: has a
// time sampling; 9: has first and last changed sample; 10: samples have the same size; 11: constant; 12-19:
// extent; 20-27: metadata. Without bits 9 and 11, every sample differs from the previous one.
std::string packed(const Property& property, MetadataTable& table) {
  const std::uint32_t longest =
      std::max({static_cast<std::uint32_t>(property.name.size()),
                static_cast<std::uint32_t>(property.metadata.size()), property.samples});
  const std::uint32_t hint = longest < 256 ? 0 : longest < 65536 ? 1 : 2;
  std::uint32_t info =
      static_cast<std::uint32_t>(property.kind) | hint << 2 | table.number_of(property.metadata) << 20;
  const bool has_samples = property.kind != PropertyKind::compound;
  if (has_samples)
    info |= (property.one_point ? 1u : 0u) | static_cast<std::uint32_t>(property.pod) << 4 | 1u << 8 |
            1u << 10 | (property.constant ? 1u << 11 : 0u) | property.extent << 12;
  std::string out;
  base::append_bytes(out, info);
  if (has_samples) {
    append_sized(out, property.samples, hint);
    append_sized(out, frame_sampling, hint);
  }
  append_sized(out, static_cast<std::uint32_t>(property.name.size()), hint);
  return out + property.name;
}

std::string packed_object(const std::string& name, const std::string& metadata, MetadataTable& table) {
  std::string out;
  base::append_bytes(out, static_cast<std::uint32_t>(name.size()));
  out += name;
  return out + static_cast<char>(table.number_of(metadata));
}

// Samples at start, start + period, ...
std::string packed_sampling(std::uint32_t samples, double period, double start) {
  std::string out;
  base::append_bytes(out, samples);
  base::append_bytes(out, period);
  base::append_bytes(out, std::uint32_t{1});  // number of stored times
  base::append_bytes(out, start);
  return out;
}

std::string digest(std::string_view bytes) {
  std::string out;
  base::append_bytes(out, murmur3_x64_128(bytes));
  return out;
}

template <class T>
std::string_view bytes_of(std::span<const T> values) {
  return {reinterpret_cast<const char*>(values.data()), values.size_bytes()};
}
template <class T>
std::string_view bytes_of(const std::vector<T>& values) {
  return bytes_of(std::span<const T>(values));
}

constexpr const char* mesh_schema = "schema=AbcGeom_PolyMesh_v1;schemaBaseType=AbcGeom_GeomBase_v1";
constexpr const char* face_set_schema = "schema=AbcGeom_FaceSet_v1;schemaBaseType=AbcGeom_GeomBase_v1";
constexpr const char* own_bounds = ".selfBnds";
constexpr const char* child_bounds = ".childBnds";

std::vector<double> box_of(std::span<const float> points) {
  const std::array<float, 6> box = bounds(points);
  return {box.begin(), box.end()};
}

// The samples written so far for one material's triangles.
struct FaceSetSamples {
  std::string name;
  std::vector<std::uint32_t> vertices;  // the object's vertices that its triangles use, without duplicates
  std::vector<Child> faces, bounds;
  bool one_face = false;
};

struct MeshSamples {
  std::vector<Child> points, velocities, normals, bounds, indices, counts, uvs;
  bool one_triangle = false, one_vertex = false;
  std::vector<FaceSetSamples> face_sets;
};

class AbcSink final : public FrameSink {
 public:
  std::string name() const override { return "abc"; }
  model::Read needs() const override { return {.surface = true}; }
  bool resumes() const override { return false; }
  void begin(const BakeInfo& info) override;
  void write(const model::Frame& frame) override;
  // No checkpoint relies on this file: a resumed bake rewrites it.
  void sync() override {}
  void finish() override;

 private:
  // A group, and the headers of its children, which the parent stores.
  struct Written {
    Child group = OgawaWriter::empty_group;
    std::string headers;
  };
  Child sample(std::string_view bytes) { return file_->data({digest(bytes), bytes}); }
  void append_sample(std::vector<Child>& to, std::string_view bytes) {
    to.push_back(sample(bytes));
    to.push_back(OgawaWriter::empty_data);
  }
  Child group(const std::vector<Child>& children) { return file_->group(children); }
  void append_velocities(const std::vector<float>& velocities);
  Written compound(std::vector<Child> children, const std::vector<Property>& properties);
  Child object(std::vector<Child> children, const std::string& child_headers,
               const std::string& property_headers);
  Written face_set(const FaceSetSamples& set);
  Written mesh(const SurfaceObject& object, const MeshSamples& samples);
  Property frames(const char* name, const char* metadata, std::uint32_t extent, bool one_point) const;
  Property box(const char* name) const;
  Property constants(const char* name, const char* metadata, Pod pod, std::uint32_t extent,
                     bool one_point) const;

  double unit_ = 1.0, fps_ = 60.0, start_ = 0.0;
  std::uint64_t first_number_ = 0;
  std::shared_ptr<const SurfaceObjects> surface_;
  std::optional<SurfaceNormals> normals_;
  std::optional<SurfaceVelocities> velocities_;
  std::optional<OgawaWriter> file_;
  MetadataTable table_;
  std::vector<MeshSamples> meshes_;  // offsets: about 56 bytes per frame and object
  std::vector<Child> bounds_;        // of the whole surface
};

void AbcSink::begin(const BakeInfo& info) {
  const model::Model& model = *info.model;
  require_surface(model, "abc");
  if (info.frames >= std::numeric_limits<std::uint32_t>::max())
    throw base::BakeError("abc: the format counts frames in 32 bits; leave out --format abc");
  unit_ = model.unit;
  fps_ = info.fps;
  start_ = info.start;
  first_number_ = info.first_number;
  surface_ = objects_of(info);
  normals_.emplace(model, surface_->normals);
  velocities_.emplace(info.fps);
  file_.emplace(info.folder / "surface.abc");
  for (const SurfaceObject& object : surface_->objects) {
    MeshSamples& mesh = meshes_.emplace_back();
    // Alembic winds faces clockwise as seen from outside; ours are counter-clockwise.
    std::vector<std::int32_t> indices, counts(object.triangle.size() / 3, 3);
    for (std::size_t i = 0; i < object.triangle.size(); i += 3)
      for (const std::size_t k : {2u, 1u, 0u})
        indices.push_back(static_cast<std::int32_t>(object.triangle[i + k]));
    append_sample(mesh.indices, bytes_of(indices));
    append_sample(mesh.counts, bytes_of(counts));
    mesh.one_triangle = counts.size() == 1;
    mesh.one_vertex = object.vertex_count == 1;
    if (!object.uvs.empty()) append_sample(mesh.uvs, bytes_of(object.uvs));
    for (const FaceSet& set : object.face_sets) {
      FaceSetSamples& samples = mesh.face_sets.emplace_back();
      samples.name = surface_->materials[set.material].name;
      samples.one_face = set.triangles.size() == 1;
      append_sample(samples.faces, bytes_of(set.triangles));  // below 2^31, so the same bits as int32
      for (const std::uint32_t t : set.triangles)
        for (std::size_t k = 0; k < 3; ++k)
          samples.vertices.push_back(object.triangle[std::size_t{3} * t + k]);
      std::sort(samples.vertices.begin(), samples.vertices.end());
      samples.vertices.erase(std::unique(samples.vertices.begin(), samples.vertices.end()),
                             samples.vertices.end());
    }
  }
}

void AbcSink::write(const model::Frame& frame) {
  std::vector<float> points = world_positions(frame.surface, unit_, frame.origin);
  const std::vector<float> normals = normals_->of(frame.surface);
  bounds_.push_back(sample(bytes_of(box_of(points))));
  for (std::size_t k = 0; k < meshes_.size(); ++k) {
    MeshSamples& mesh = meshes_[k];
    const std::span<const float> own = values_of(surface_->objects[k], points);
    append_sample(mesh.points, bytes_of(own));
    append_sample(mesh.normals, bytes_of(values_of(surface_->objects[k], normals)));
    mesh.bounds.push_back(sample(bytes_of(box_of(own))));
    for (FaceSetSamples& set : mesh.face_sets) {
      std::vector<float> touched;
      for (const std::uint32_t v : set.vertices)
        for (std::size_t axis = 0; axis < 3; ++axis) touched.push_back(own[std::size_t{3} * v + axis]);
      set.bounds.push_back(sample(bytes_of(box_of(touched))));
    }
  }
  append_velocities(velocities_->next(std::move(points)));
}

void AbcSink::append_velocities(const std::vector<float>& velocities) {
  if (velocities.empty()) return;
  for (std::size_t k = 0; k < meshes_.size(); ++k)
    append_sample(meshes_[k].velocities, bytes_of(values_of(surface_->objects[k], velocities)));
}

AbcSink::Written AbcSink::compound(std::vector<Child> children, const std::vector<Property>& properties) {
  Written written;
  for (const Property& property : properties) written.headers += packed(property, table_);
  children.push_back(file_->data({written.headers}));
  written.group = group(children);
  return written;
}

// The two digests at the end of an object's headers cover its properties and its children; readers compare
// them to find equal objects.
Child AbcSink::object(std::vector<Child> children, const std::string& child_headers,
                      const std::string& property_headers) {
  children.push_back(file_->data({child_headers, digest(property_headers), digest(child_headers)}));
  return group(children);
}

// A property that changes from frame to frame.
Property AbcSink::frames(const char* name, const char* metadata, std::uint32_t extent, bool one_point) const {
  return {.name = name,
          .metadata = metadata,
          .kind = PropertyKind::array,
          .extent = extent,
          .samples = static_cast<std::uint32_t>(bounds_.size()),
          .constant = bounds_.size() == 1,
          .one_point = one_point};
}

Property AbcSink::box(const char* name) const {
  Property property = frames(name, "interpretation=box", 6, true);
  property.kind = PropertyKind::scalar;
  property.pod = Pod::float64;
  return property;
}

Property AbcSink::constants(const char* name, const char* metadata, Pod pod, std::uint32_t extent,
                            bool one_point) const {
  Property property = frames(name, metadata, extent, one_point);
  property.pod = pod;
  property.constant = true;
  return property;
}

// Returns the object's group and its header for the parent.
AbcSink::Written AbcSink::face_set(const FaceSetSamples& set) {
  const std::uint32_t exclusive = 1;  // no face is in two sets
  std::string value;
  base::append_bytes(value, exclusive);
  Property exclusivity = constants(".facesExclusive", "", Pod::uint32, 1, true);
  exclusivity.kind = PropertyKind::scalar;
  const Written faces =
      compound({group(set.bounds), group(set.faces), group({sample(value)})},
               {box(own_bounds), constants(".faces", "", Pod::int32, 1, set.one_face), exclusivity});
  const Written properties = compound(
      {faces.group}, {{.name = ".faceset", .metadata = face_set_schema, .kind = PropertyKind::compound}});
  return {
      object({properties.group}, "", faces.headers + properties.headers),
      packed_object(set.name, std::string(face_set_schema) + ";schemaObjTitle=AbcGeom_FaceSet_v1:.faceset",
                    table_)};
}

AbcSink::Written AbcSink::mesh(const SurfaceObject& of, const MeshSamples& samples) {
  std::vector<Child> groups{group(samples.bounds),  group(samples.points), group(samples.velocities),
                            group(samples.indices), group(samples.counts), group(samples.normals)};
  std::vector<Property> list{
      box(own_bounds),
      frames("P", "geoScope=vtx;interpretation=point", 3, samples.one_vertex),
      frames(".velocities", "interpretation=vector", 3, samples.one_vertex),
      constants(".faceIndices", "", Pod::int32, 1, of.triangle.size() == 1),
      constants(".faceCounts", "", Pod::int32, 1, samples.one_triangle),
      frames("N",
             "arrayExtent=1;geoScope=vtx;interpretation=normal;isGeomParam=true;podExtent=3;"
             "podName=float32_t",
             3, samples.one_vertex)};
  if (!samples.uvs.empty()) {
    groups.push_back(group(samples.uvs));
    list.push_back(constants("uv",
                             "arrayExtent=1;geoScope=vtx;interpretation=vector;isGeomParam=true;podExtent=2;"
                             "podName=float32_t",
                             Pod::float32, 2, samples.one_vertex));
  }
  const Written geometry = compound(groups, list);
  const Written properties = compound(
      {geometry.group}, {{.name = ".geom", .metadata = mesh_schema, .kind = PropertyKind::compound}});
  std::vector<Child> children{properties.group};
  std::string headers;
  for (const FaceSetSamples& set : samples.face_sets) {
    const Written child = face_set(set);
    children.push_back(child.group);
    headers += child.headers;
  }
  return {
      object(children, headers, geometry.headers + properties.headers),
      packed_object(of.name, std::string(mesh_schema) + ";schemaObjTitle=AbcGeom_PolyMesh_v1:.geom", table_)};
}

void AbcSink::finish() {
  append_velocities(velocities_->last());
  const auto samples = static_cast<std::uint32_t>(bounds_.size());
  const Written bounds = compound({group(bounds_)}, {box(child_bounds)});
  std::vector<Child> children{bounds.group};
  std::string headers;
  for (std::size_t k = 0; k < meshes_.size(); ++k) {
    const Written child = mesh(surface_->objects[k], meshes_[k]);
    children.push_back(child.group);
    headers += child.headers;
  }
  const Child top = object(children, headers, bounds.headers);
  const std::string archive =
      std::string("_ai_Application=fascicle ") + base::fascicle_version +
      ";_ai_DCC_FPS=" + base::number_text(fps_) + ";_ai_Description=metres, Y up, first frame " +
      base::number_text(first_number_) + ", clip time of the first frame (s): " + base::number_text(start_);
  std::string form, version;
  base::append_bytes(form, form_version);
  base::append_bytes(version, alembic_version);
  const std::array<Child, 6> root{
      file_->data({form}),
      file_->data({version}),
      top,
      file_->data({archive}),
      file_->data({packed_sampling(0, 1.0, 0.0),
                   packed_sampling(samples, 1.0 / fps_, static_cast<double>(first_number_) / fps_)}),
      file_->data({table_.packed()})};
  file_->finish(file_->group(root));
}

std::uint64_t abc_bytes(const model::Model& model, std::uint64_t frames) {
  const std::uint64_t triangles = model.surface_triangle.size() / 3;
  // Positions, velocities, normals and bounds, each with its length, digest and group entries; headers of
  // about 1 kB. Texture coordinates take 8 bytes per vertex and face sets 4 per triangle.
  const std::uint64_t frame = std::uint64_t{36} * model.surface_count() + 96 + 5 * (8 + digest_bytes) + 8 * 8;
  return 1150 + std::uint64_t{8} * model.surface_count() + 20 * triangles + frames * frame;
}

}  // namespace

Format abc_format() {
  return {.name = "abc", .file = "surface.abc", .make = make_sink<AbcSink>, .bytes = abc_bytes};
}

}  // namespace fascicle::formats
