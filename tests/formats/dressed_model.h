// A body of three faces with a source file that has two objects of the same name, three materials, texture
// coordinates and normals with a crease. The file has Z up.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <vector>

#include "host/formats/sink.h"
#include "host/gltf/gltf_document.h"
#include "host/model/model.h"
#include "host/model/solver.h"

namespace fascicle::tests {

// two_tetrahedra with nine render vertices at model vertices: object "Body.001" with the triangles 0 1 2
// (material "Skin") and 3 4 5 (material "Cloth/Red" with an image), and another object "Body.001" with the
// triangle 6 7 8 (a material without a name, no texture coordinates). The first two triangles meet at a right
// angle, in a crease.
model::Model dressed_model();

// Texture coordinates of the file, v down, 2 per vertex; the last object has none.
extern const std::vector<float> dressed_uvs;
// Normals of the file in the bind pose, 3 per vertex.
extern const std::vector<float> dressed_normals;

// The matching character.glb, or a changed one.
void write_dressed(const std::filesystem::path& path,
                   const std::function<void(gltf::GltfDocument&)>& change = {});

// Frame k: the body rotated by k quarter turns about z and moved along x by k^2 m. A turn takes (x, y, z) to
// (-y, x, z).
model::Frame turned(const model::Model& model, std::uint64_t k);

struct DressedOptions {
  std::uint64_t first_number = 0;
  formats::GlbOptions glb = {};
  bool usd_skel = false;
};
// Writes frames 0 to 3 at 8 fps through one sink, into FOLDER with its character.glb.
void write_dressed_frames(std::unique_ptr<formats::FrameSink> sink, const std::filesystem::path& folder,
                          const DressedOptions& options = {});
// The same with an existing character.glb of the same vertices.
void write_turned_frames(std::unique_ptr<formats::FrameSink> sink, const std::filesystem::path& folder,
                         const DressedOptions& options);

// Position of a render vertex in frame k, m.
std::array<double, 3> dressed_point(std::uint64_t k, std::size_t vertex);
// Normal of a render vertex in frame k.
std::array<double, 3> dressed_normal(std::uint64_t k, std::size_t vertex);

}  // namespace fascicle::tests
