// Bakes scenes of several characters for tests: the lead-in and some frames, on the CPU.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "host/build/build.h"
#include "host/model/solver.h"
#include "host/scene/scene.h"
#include "tests/gltf/gltf_builder.h"

namespace fascicle::tests {

extern const std::string flesh_on_bones;  // layers and substeps

// [TABLE]: an arm of some 800 vertices, with additional keys.
std::string arm(const std::string& table, const std::string& more = "");

struct Walk {
  scene::Scene scene;
  model::Model model;
  build::Report report;
  std::vector<std::vector<Eigen::Vector3d>> surface;  // m, for each frame
  model::State last;
};
// `folder` holds the files that the text names.
Walk walk(const std::string& text, std::uint64_t frames, const std::filesystem::path& folder = {});

// The mean displacement of a character's surface from that of the other walk, in the last frame, m.
Eigen::Vector3d mean_move(const Walk& walk, const Walk& without, std::size_t character);

// A corner of a box: bit a of k selects the high side along axis a.
Eigen::Vector3d corner_of(const Eigen::Vector3d& low, const Eigen::Vector3d& high, unsigned k);

// A box of 12 triangles, as an .obj.
void write_box(const std::filesystem::path& file, const Eigen::Vector3d& low, const Eigen::Vector3d& high);

// Boxes as a .glb without skin or clip. Each is a mesh on its own node, "box N", placed at the centre of the
// box.
struct Box {
  Eigen::Vector3d low, high;
};
GltfBuilder boxes(const std::vector<Box>& all);

}  // namespace fascicle::tests
