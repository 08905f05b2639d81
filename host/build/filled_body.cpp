#include "host/build/filled_body.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <system_error>

#include "host/base/content_hash.h"
#include "host/base/file.h"
#include "host/build/byte_archive.h"
#include "host/build/cache.h"
#include "host/build/check_mesh.h"
#include "host/build/embedding.h"
#include "host/build/mesher.h"
#include "host/build/partings.h"
#include "host/build/report_fields.h"
#include "host/build/skin_weights.h"

namespace fascicle::build {

void add_points(base::ContentHash& hash, const std::vector<Vector3d>& points) {
  hash.add(std::uint64_t{points.size()});
  for (const Vector3d& p : points)
    for (int a = 0; a < 3; ++a) hash.add(p[a]);
}

namespace {

namespace fs = std::filesystem;

template <class T>
void add_rows(base::ContentHash& hash, const std::vector<T>& rows) {
  hash.add(std::uint64_t{rows.size()});
  for (const T& row : rows) hash.add_array(std::span(row.data(), row.size()));
}

FilledBody make_filled_body(const FillInput& input, Report& report, const BuildOptions& options) {
  const std::vector<rig::Joint> no_skeleton;
  const std::vector<rig::Joint>& skeleton =
      input.character != nullptr ? input.character->skeleton : no_skeleton;
  SkinWeights skin;
  if (input.character != nullptr)
    skin = welded_skin_weights(*input.character, input.welded.of_vertex, input.welded.surface.vertices.size(),
                               input.scene.source);
  BodyMesh mesh = make_body_mesh({input.welded, skin, skeleton, input.bones, input.character}, input.scene,
                                 report, options);
  FilledBody body;
  if (input.character != nullptr)
    body.skin = body_skin_weights(mesh, input.welded, skin, skeleton.size(), input.scene.source);
  body.render = embed_surface(input.surface, input.welded, mesh, body.skin, skin, report);
  body.mesh = std::move(mesh.mesh);
  return body;
}

// The same fields in the same order for reading and writing. The render mesh takes its triangles from the
// input.
template <class Archive, class Body>
void visit_arrays(Archive& archive, Body& body) {
  archive(body.mesh.tetrahedra);
  archive(body.skin.offset);
  archive(body.skin.joint);
  archive(body.skin.weight);
  archive(body.render.corners);
  archive(body.render.weights);
}

std::vector<std::array<double, 3>> plain(const std::vector<Vector3d>& points) {
  std::vector<std::array<double, 3>> result;
  result.reserve(points.size());
  for (const Vector3d& p : points) result.push_back({p[0], p[1], p[2]});
  return result;
}

// Converts numbers of the welded skin to numbers in the file, the first vertex at each place.
void number_by_file(const WeldedSurface& welded, CageReport& cage) {
  std::vector<std::uint32_t> first(welded.surface.vertices.size(), 0);
  for (std::uint32_t v = static_cast<std::uint32_t>(welded.of_vertex.size()); v-- > 0;)
    first[welded.of_vertex[v]] = number_in_file(welded, v);
  SurfaceFindings& found = cage.findings;
  for (std::vector<std::uint32_t>* vertices :
       {&found.parts.vertices, &found.loose_vertices.vertices, &found.flat_triangles.vertices,
        &found.open_edges.vertices, &found.non_manifold_edges.vertices, &found.non_manifold_vertices.vertices,
        &found.turned_edges.vertices, &found.inverted_parts.vertices, &found.intersections.vertices,
        &cage.ends.vertex})
    for (std::uint32_t& v : *vertices)
      if (v < first.size()) v = first[v];
}

bool is_usable_mesh(const mesh::TetMesh& mesh) {
  try {
    mesh::TetMesh oriented = mesh;
    Report turned;
    check_and_orient(oriented, "", turned);
    return turned.flipped_tetrahedra == 0;
  } catch (const scene::SceneError&) {
    return false;
  }
}

bool is_usable_skin(const SkinWeights& skin, std::size_t vertices, const rig::Character* character) {
  if (character == nullptr) return skin.offset.empty() && skin.joint.empty() && skin.weight.empty();
  if (skin.offset.size() != vertices + 1 || skin.offset.front() != 0 ||
      skin.offset.back() != skin.joint.size() || skin.joint.size() != skin.weight.size())
    return false;
  for (std::size_t i = 0; i < vertices; ++i) {
    if (skin.offset[i + 1] <= skin.offset[i] || skin.offset[i + 1] > skin.joint.size() ||
        skin.offset[i + 1] - skin.offset[i] > 8)
      return false;
    double sum = 0.0;
    for (std::uint32_t k = skin.offset[i]; k < skin.offset[i + 1]; ++k) {
      if (skin.joint[k] >= character->skeleton.size() || !(skin.weight[k] >= 0.0)) return false;
      sum += skin.weight[k];
    }
    if (sum != 1.0) return false;
  }
  return true;
}

bool is_usable_render(const RenderMesh& render, std::size_t vertices, std::size_t count) {
  if (render.corners.size() != count || render.weights.size() != count) return false;
  for (const auto& corners : render.corners)
    if (*std::max_element(corners.begin(), corners.end()) >= vertices) return false;
  for (const auto& weights : render.weights)
    for (const double w : weights)
      if (!std::isfinite(w)) return false;
  return true;
}

}  // namespace

std::optional<std::string> hash_of_programs(const BuildOptions& options) {
  try {
    base::ContentHash hash;
    for (const fs::path& path : {base::own_module(), mesher_path(options)}) {
      const base::File file(path, base::FileMode::read);
      // In pieces: a program with sanitizers has hundreds of megabytes.
      constexpr std::uint64_t piece_bytes = 1U << 20U;
      std::vector<char> piece;
      for (std::uint64_t at = 0; at < file.size(); at += piece_bytes) {
        piece.resize(static_cast<std::size_t>(std::min(piece_bytes, file.size() - at)));
        if (!file.read_at(at, piece)) return std::nullopt;
        hash.add_array(std::span<const char>(piece));
      }
    }
    return hash.text();
  } catch (const std::system_error&) {
    return std::nullopt;
  } catch (const scene::SceneError&) {
    // There is no mesher; the code that needs it reports that.
    return std::nullopt;
  }
}

std::string fill_key(const FillInput& input, const std::string& programs) {
  base::ContentHash hash;
  hash.add(programs);
  add_mesh_settings(hash, input.scene);
  add_points(hash, input.welded.surface.vertices);
  add_rows(hash, input.welded.surface.triangles);
  hash.add_array(std::span<const std::uint32_t>(input.welded.of_vertex));
  hash.add_array(std::span<const std::uint32_t>(input.welded.file_vertex));
  add_rows(hash, input.surface.triangles);
  hash.add(std::uint64_t{input.bones.size()});
  for (const Bone& bone : input.bones) {
    add_points(hash, {bone.from, bone.to});
    hash.add_array(std::span<const std::int32_t>(bone.owners));
  }
  hash.add(input.character != nullptr);
  if (input.character != nullptr) {
    hash.add(std::uint64_t{input.character->skeleton.size()});
    for (const rig::Joint& joint : input.character->skeleton)
      hash.add(static_cast<std::uint64_t>(std::int64_t{joint.parent}));
    add_rows(hash, input.character->joints);
    add_rows(hash, input.character->weights);
    // Only the part of the clips that the cut reads, so that irrelevant keys change nothing.
    for (const std::vector<Eigen::Matrix4d>& pose : poses_of_clips(*input.character, input.scene.scale))
      for (const Eigen::Matrix4d& map : pose)
        for (Eigen::Index k = 0; k < map.size(); ++k) hash.add(map.data()[k]);
  }
  return hash.text();
}

std::string filled_body_bytes(const FilledBody& body, const Report& found) {
  std::string bytes;
  ByteWriter write(bytes);
  write(plain(body.mesh.vertices));
  visit_arrays(write, body);
  write(found.fill);
  write(found.warnings);
  return bytes;
}

bool read_filled_body(std::string_view bytes, const FillInput& input, FilledBody& body, Report& found) {
  try {
    ByteReader read(bytes);
    std::vector<std::array<double, 3>> vertices;
    read(vertices);
    visit_arrays(read, body);
    read(found.fill);
    read(found.warnings);
    if (!read.at_end()) return false;
    for (const auto& p : vertices) body.mesh.vertices.push_back({p[0], p[1], p[2]});
  } catch (const ByteReader::Damaged&) {
    return false;
  }
  body.render.triangles = input.surface.triangles;
  const std::size_t count = body.mesh.vertices.size();
  return is_usable_mesh(body.mesh) && is_usable_skin(body.skin, count, input.character) &&
         is_usable_render(body.render, count, input.surface.vertices.size()) &&
         is_usable(found.fill.cage.ends);
}

bool is_usable(const OpenEnds& ends) {
  const std::size_t count = ends.vertex.size();
  return ends.edges.size() == count && ends.joint.size() == count && ends.width.size() == count &&
         ends.fate.size() == count;
}

FilledBody fill_body(const FillInput& input, Report& report, const BuildOptions& options) {
  const Cache cache(options.cache);
  const std::optional<std::string> programs =
      options.cache.empty() ? std::nullopt : hash_of_programs(options);
  const std::string key = programs ? fill_key(input, *programs) : "";
  FilledBody body;
  Report found;
  if (programs)
    if (const std::optional<std::string> bytes = cache.find(key))
      report.body_from_cache = read_filled_body(*bytes, input, body, found);
  if (!report.body_from_cache) {
    found = {};
    body = make_filled_body(input, found, options);
    if (programs) cache.put(key, filled_body_bytes(body, found));
  }
  report.fill = found.fill;
  number_by_file(input.welded, report.fill.cage);
  report.warnings.insert(report.warnings.end(), found.warnings.begin(), found.warnings.end());
  return body;
}

}  // namespace fascicle::build
