// import_blender.py: loads a bake into Blender (3.4 and later) as it should look.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace fascicle::formats {

inline constexpr const char* blender_script_name = "import_blender.py";

struct BlenderScene {
  double fps = 60.0;
  std::uint64_t frames = 0;        // after frame 0
  std::uint64_t first_number = 0;  // of frame 0
};

// `blender --python import_blender.py`, or --background --python import_blender.py -- FORMAT.
std::string blender_script(const BlenderScene& scene);

// Whether the script loads this file of a bake's folder.
bool blender_loads(const std::filesystem::path& file);

}  // namespace fascicle::formats
