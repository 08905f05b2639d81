// The part of a body that takes long to make: the filled surface, its skin weights and its embedding.
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

// What a body is filled from.
struct FillInput {
  const scene::Scene& scene;
  const mesh::SurfaceMesh& surface;  // its vertices' number and its triangles; where they lie, `welded` says
  const WeldedSurface& welded;       // m
  const std::vector<Bone>& bones;
  const rig::Character* character = nullptr;
};

// From options.cache, where the same input was filled before by the same programs, else made and kept there:
// the result and what goes to the report are the same, bit for bit. Throws scene::SceneError.
FilledBody fill_body(const FillInput& input, Report& report, const BuildOptions& options);

// A hash of this program, or of the shared library that this is part of, and of the mesher: what is kept was
// made by them. Nothing where one cannot be read.
std::optional<std::string> hash_of_programs(const BuildOptions& options);

// The name of the input in the cache: changes with all that changes the result, `programs` among them.
std::string fill_key(const FillInput& input, const std::string& programs);

void add_points(base::ContentHash& hash, const std::vector<Vector3d>& points);

// A filled body and what was found on the way, as bytes and back. Nothing where the bytes are not a body of
// this input that the rest of the build can rely on.
std::string filled_body_bytes(const FilledBody& body, const Report& found);
bool read_filled_body(std::string_view bytes, const FillInput& input, FilledBody& body, Report& found);

}  // namespace fascicle::build
