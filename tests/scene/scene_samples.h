// Scene files for the tests, and scenes as text, so that they can be compared.
#pragma once

#include <filesystem>
#include <string>

#include "host/scene/scene.h"
#include "tests/gltf/gltf_builder.h"  // TemporaryFolder

namespace fascicle::tests {

// Between them these use every key there is, one a line.
std::string bar_sample();
std::string mesh_sample();       // of a file tetrahedron.off beside it
std::string character_sample();  // of a file CesiumMan.glb beside it
std::string made_sample();       // of a file arm.paint.json beside it
std::string made_surface_sample();
std::string characters_sample();  // of both of these files
std::string implicit_sample();

// A closed surface of four triangles.
void write_tetrahedron_off(const std::filesystem::path& path);
// Of one vertex of the made arm.
void write_arm_paint(const std::filesystem::path& path);

// Every field of the scene but its text and hashes, all digits.
std::string describe(const scene::Scene& scene);

// Writes the whole file; a failure to do so fails the test.
void write_file(const std::filesystem::path& path, const std::string& text);

}  // namespace fascicle::tests
