// A body of three faces that a file dresses: two objects of one name, three materials, texture coordinates
// and normals with a crease, raw with Z up.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "host/formats/sink.h"
#include "host/model/model.h"
#include "host/model/solver.h"

namespace fascicle::tests {

// two_tetrahedra with a surface of nine render vertices that lie on its own ones: object "Body.001" with the
// triangles 0 1 2 (material "Skin") and 3 4 5 (material "Cloth/Red" with an image), object "Body.001" with
// the triangle 6 7 8 (a material without a name, no texture coordinates). The first two meet at a right
// angle, in a crease.
model::Model dressed_model();

// Of the file, v down, 2 a vertex; the last object has none.
extern const std::vector<float> dressed_uvs;
// Of the file as it stands in the bind pose, 3 a vertex.
extern const std::vector<float> dressed_normals;

// The character.glb that fits it.
void write_dressed(const std::filesystem::path& path);

// Frame k: the body turned k quarters about z and moved along x by k^2 m. What stands at (x, y, z) goes to
// (-y, x, z).
model::Frame turned(const model::Model& model, std::uint64_t k);

struct DressedOptions {
  std::uint64_t first_number = 0;
  formats::GlbOptions glb = {};
  bool usd_skel = false;
};
// Frames 0 to 3 at 8 a second through one sink, in FOLDER with its character.glb.
void write_dressed_frames(std::unique_ptr<formats::FrameSink> sink, const std::filesystem::path& folder,
                          const DressedOptions& options = {});
// The same with a character.glb that is there already, of the same vertices.
void write_turned_frames(std::unique_ptr<formats::FrameSink> sink, const std::filesystem::path& folder,
                         const DressedOptions& options);

// Where a render vertex stands in frame k, m.
std::array<double, 3> dressed_point(std::uint64_t k, std::size_t vertex);
// Its normal.
std::array<double, 3> dressed_normal(std::uint64_t k, std::size_t vertex);

}  // namespace fascicle::tests
