// Sample scene files, and scenes as text for comparison.
#pragma once

#include <filesystem>
#include <string>

#include "host/scene/scene.h"
#include "tests/gltf/gltf_builder.h"  // TemporaryFolder

namespace fascicle::tests {

// Together these use every key, one per line.
std::string bar_sample();
std::string mesh_sample();       // needs tetrahedron.off in its folder
std::string character_sample();  // needs CesiumMan.glb in its folder
std::string made_sample();       // needs arm.paint.json in its folder
std::string made_surface_sample();
std::string characters_sample();  // needs both of these files
std::string implicit_sample();

// A closed surface of four triangles.
void write_tetrahedron_off(const std::filesystem::path& path);
// Paints one vertex of the generated arm.
void write_arm_paint(const std::filesystem::path& path);

// All fields of the scene except its text and hashes, with all digits.
std::string describe(const scene::Scene& scene);

// Writes the file; fails the test if that fails.
void write_file(const std::filesystem::path& path, const std::string& text);

}  // namespace fascicle::tests
