// surface.abc: Alembic in its Ogawa form, written from the format's layout; there is no library for it in
// Debian.
//
//   root       0 int32 version of the form, 0    1 int32 version of Alembic    2 group of the top object
//              3 the archive's metadata    4 time samplings    5 indexed metadata
//   object     0 group of its properties, then a group for each child object, then their headers
//   compound   a group for each property, then their headers
//   array      for each sample: data (16-byte digest, values), dimensions (empty: follow from the size)
//   scalar     for each sample: data (16-byte digest, value)
// The object is an AbcGeom_PolyMesh_v1: .geom with .selfBnds, P, .faceIndices, .faceCounts and N.
#include <array>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "host/bake/bake.h"
#include "host/bake/formats.h"
#include "host/bake/murmur3.h"
#include "host/bake/ogawa_writer.h"
#include "host/bake/surface.h"
#include "host/bake/text.h"
#include "host/bake/version.h"

namespace fascicle::bake {

namespace {

using Child = OgawaWriter::Child;

constexpr std::int32_t form_version = 0;
// That of the library whose files these are like; readers refuse less than 9999.
constexpr std::int32_t alembic_version = 10803;
constexpr std::uint64_t digest_bytes = 16;
constexpr std::uint32_t frame_sampling = 1;  // of the time samplings; 0 is the one of what has no time

enum class PropertyKind : std::uint32_t { compound = 0, scalar = 1, array = 2 };
enum class Pod : std::uint32_t { int32 = 6, float32 = 10, float64 = 11 };

struct Property {
  std::string name, metadata;
  PropertyKind kind = PropertyKind::compound;
  Pod pod = Pod::float32;
  std::uint32_t extent = 1;   // values a point
  std::uint32_t samples = 0;  // as a reader counts them
  bool constant = false;      // one stored sample stands for all
  bool one_point = false;     // each sample of an array is a single point
};

void append_sized(std::string& out, std::uint32_t value, std::uint32_t size_hint) {
  std::string bytes;
  append_bytes(bytes, value);
  out += bytes.substr(0, std::size_t{1} << size_hint);
}

// Metadata that properties and objects share, referred to by number; 0 is none.
class MetadataTable {
 public:
  std::uint32_t number_of(const std::string& text) {
    if (text.empty()) return 0;
    for (std::uint32_t k = 0; k < texts_.size(); ++k)
      if (texts_[k] == text) return k + 1;
    texts_.push_back(text);
    return static_cast<std::uint32_t>(texts_.size());
  }
  // Each below 256 bytes, which all of ours are.
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

// bits 0-1 kind (1 | 2: array of single points), 2-3 bytes of a size (1 << n), 4-7 type, 8 has a time
// sampling, 9 has first and last changed sample, 10 samples are of one size, 11 constant, 12-19 extent, 20-27
// metadata. Without bits 9 and 11 every sample differs from the one before.
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
  append_bytes(out, info);
  if (has_samples) {
    append_sized(out, property.samples, hint);
    append_sized(out, frame_sampling, hint);
  }
  append_sized(out, static_cast<std::uint32_t>(property.name.size()), hint);
  return out + property.name;
}

std::string packed_object(const std::string& name, const std::string& metadata, MetadataTable& table) {
  std::string out;
  append_bytes(out, static_cast<std::uint32_t>(name.size()));
  out += name;
  return out + static_cast<char>(table.number_of(metadata));
}

// samples at start, start + period, ...
std::string packed_sampling(std::uint32_t samples, double period, double start) {
  std::string out;
  append_bytes(out, samples);
  append_bytes(out, period);
  append_bytes(out, std::uint32_t{1});  // stored times
  append_bytes(out, start);
  return out;
}

std::string digest(std::string_view bytes) {
  std::string out;
  append_bytes(out, murmur3_x64_128(bytes));
  return out;
}

template <class T>
std::string_view bytes_of(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

class AbcSink final : public FrameSink {
 public:
  std::string name() const override { return "abc"; }
  model::Read needs() const override { return {.surface = true}; }
  bool resumes() const override { return false; }
  void begin(const BakeInfo& info) override;
  void write(const model::Frame& frame) override;
  // Nothing counts on it: a resumed bake begins the file anew.
  void sync() override {}
  void finish() override;

 private:
  Child sample(std::string_view bytes) { return file_->data({digest(bytes), bytes}); }
  Child group(const std::vector<Child>& children) { return file_->group(children); }
  Child compound(std::vector<Child> children, const std::vector<Property>& properties, MetadataTable& table,
                 std::string& headers);
  Child object(std::vector<Child> children, const std::string& child_headers,
               const std::string& property_headers);

  double unit_ = 1.0, fps_ = 60.0, start_ = 0.0;
  std::optional<SurfaceNormals> normals_;
  std::optional<OgawaWriter> file_;
  std::vector<Child> points_samples_, normal_samples_, bounds_samples_;  // offsets: 40 bytes a frame
  std::vector<Child> index_samples_, count_samples_;
  bool one_triangle_ = false, one_corner_ = false, one_vertex_ = false;
};

void AbcSink::begin(const BakeInfo& info) {
  const model::Model& model = *info.model;
  if (model.surface_count() == 0)
    throw BakeError("abc: the scene has no surface to write; leave out --format abc");
  if (info.frames >= std::numeric_limits<std::uint32_t>::max())
    throw BakeError("abc: the format counts frames in 32 bits; leave out --format abc");
  unit_ = model.unit;
  fps_ = info.fps;
  start_ = info.start;
  normals_.emplace(model);
  file_.emplace(info.folder / "surface.abc");
  // Alembic's faces run clockwise as seen from outside; ours the other way.
  std::vector<std::int32_t> indices, counts(model.surface_triangle.size() / 3, 3);
  for (std::size_t i = 0; i < model.surface_triangle.size(); i += 3)
    for (const std::size_t k : {2u, 1u, 0u})
      indices.push_back(static_cast<std::int32_t>(model.surface_triangle[i + k]));
  index_samples_ = {sample(bytes_of(indices)), OgawaWriter::empty_data};
  count_samples_ = {sample(bytes_of(counts)), OgawaWriter::empty_data};
  one_triangle_ = counts.size() == 1;
  one_corner_ = indices.size() == 1;
  one_vertex_ = model.surface_count() == 1;
}

void AbcSink::write(const model::Frame& frame) {
  const std::vector<float> points = world_positions(frame.surface, unit_, frame.origin);
  std::vector<double> box;
  for (const float value : bounds(points)) box.push_back(double{value});
  points_samples_.push_back(sample(bytes_of(points)));
  points_samples_.push_back(OgawaWriter::empty_data);
  normal_samples_.push_back(sample(bytes_of(normals_->of(frame.surface))));
  normal_samples_.push_back(OgawaWriter::empty_data);
  bounds_samples_.push_back(sample(bytes_of(box)));
}

Child AbcSink::compound(std::vector<Child> children, const std::vector<Property>& properties,
                        MetadataTable& table, std::string& headers) {
  headers.clear();
  for (const Property& property : properties) headers += packed(property, table);
  children.push_back(file_->data({headers}));
  return group(children);
}

// The two digests at the end of an object's headers stand for its properties and its children; readers
// compare them to find equal objects.
Child AbcSink::object(std::vector<Child> children, const std::string& child_headers,
                      const std::string& property_headers) {
  children.push_back(file_->data({child_headers, digest(property_headers), digest(child_headers)}));
  return group(children);
}

void AbcSink::finish() {
  const auto samples = static_cast<std::uint32_t>(bounds_samples_.size());
  const bool still = samples == 1;
  const std::string schema = "schema=AbcGeom_PolyMesh_v1;schemaBaseType=AbcGeom_GeomBase_v1";
  MetadataTable table;
  std::string headers;
  const Child geometry =
      compound({group(bounds_samples_), group(points_samples_), group(index_samples_), group(count_samples_),
                group(normal_samples_)},
               {{.name = ".selfBnds",
                 .metadata = "interpretation=box",
                 .kind = PropertyKind::scalar,
                 .pod = Pod::float64,
                 .extent = 6,
                 .samples = samples,
                 .constant = still,
                 .one_point = true},
                {.name = "P",
                 .metadata = "geoScope=vtx;interpretation=point",
                 .kind = PropertyKind::array,
                 .extent = 3,
                 .samples = samples,
                 .constant = still,
                 .one_point = one_vertex_},
                {.name = ".faceIndices",
                 .metadata = {},
                 .kind = PropertyKind::array,
                 .pod = Pod::int32,
                 .samples = samples,
                 .constant = true,
                 .one_point = one_corner_},
                {.name = ".faceCounts",
                 .metadata = {},
                 .kind = PropertyKind::array,
                 .pod = Pod::int32,
                 .samples = samples,
                 .constant = true,
                 .one_point = one_triangle_},
                {.name = "N",
                 .metadata = "arrayExtent=1;geoScope=vtx;interpretation=normal;isGeomParam=true;podExtent=3;"
                             "podName=float32_t",
                 .kind = PropertyKind::array,
                 .extent = 3,
                 .samples = samples,
                 .constant = still,
                 .one_point = one_vertex_}},
               table, headers);
  std::string surface_headers = headers;
  const Child properties = compound(
      {geometry}, {{.name = ".geom", .metadata = schema, .kind = PropertyKind::compound}}, table, headers);
  const Child surface = object({properties}, "", surface_headers + headers);
  const Child top =
      object({OgawaWriter::empty_group, surface},
             packed_object("surface", schema + ";schemaObjTitle=AbcGeom_PolyMesh_v1:.geom", table), "");
  const std::string archive =
      std::string("_ai_Application=fascicle ") + fascicle_version + ";_ai_DCC_FPS=" + number_text(fps_) +
      ";_ai_Description=metres, Y up, first frame 0, clip time of frame 0 (s): " + number_text(start_);
  std::string form, version;
  append_bytes(form, form_version);
  append_bytes(version, alembic_version);
  const std::array<Child, 6> root{
      file_->data({form}),
      file_->data({version}),
      top,
      file_->data({archive}),
      file_->data({packed_sampling(0, 1.0, 0.0), packed_sampling(samples, 1.0 / fps_, 0.0)}),
      file_->data({table.packed()})};
  file_->finish(file_->group(root));
}

}  // namespace

std::unique_ptr<FrameSink> make_abc_sink() {
  return std::make_unique<AbcSink>();
}

std::uint64_t abc_bytes(const model::Model& model, std::uint64_t frames) {
  const std::uint64_t triangles = model.surface_triangle.size() / 3;
  // Positions, normals and bounds, each with its length, digest and places in the groups; headers about 1 kB.
  const std::uint64_t frame = std::uint64_t{24} * model.surface_count() + 48 + 3 * (8 + digest_bytes) + 5 * 8;
  return 1200 + 16 * triangles + frames * frame;
}

}  // namespace fascicle::bake
