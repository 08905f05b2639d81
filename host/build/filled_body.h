// The expensive part of a body: the filled surface, its skin weights and its embedding.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/base/content_hash.h"
#include "host/build/body.h"
#include "host/build/body_mesh.h"
#include "host/build/weld.h"

namespace fascicle::build {

struct FilledBody {
  mesh::TetMesh mesh;
  SkinWeights skin;  // empty without a character
  RenderMesh render;
};

// The input that a body is filled from.
struct FillInput {
  const scene::Scene& scene;
  const mesh::SurfaceMesh& surface;  // its vertex count and triangles are used; positions come from `welded`
  const WeldedSurface& welded;       // m
  const std::vector<Bone>& bones;
  const rig::Character* character = nullptr;
};

// Takes the body from options.cache if the same programs filled the same input before, else makes it and
// stores it there. The result and the report are the same, bit for bit. Throws scene::SceneError.
FilledBody fill_body(const FillInput& input, Report& report, const BuildOptions& options);

// A hash of the mesher and of this program, or the shared library that contains it: they made what is cached.
// Nothing if one of them cannot be read.
std::optional<std::string> hash_of_programs(const BuildOptions& options);

// The cache key of the input: it changes with everything that changes the result, including `programs`.
std::string fill_key(const FillInput& input, const std::string& programs);

void add_points(base::ContentHash& hash, const std::vector<Vector3d>& points);

// Converts a filled body and its findings to bytes and back. Reading returns false if the bytes are not a
// body of this input that the rest of the build can rely on.
std::string filled_body_bytes(const FilledBody& body, const Report& found);
bool read_filled_body(std::string_view bytes, const FillInput& input, FilledBody& body, Report& found);

// Whether each array has one entry per end: ends from the cache may have any lengths.
bool is_usable(const OpenEnds& ends);

}  // namespace fascicle::build
