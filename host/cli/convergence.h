// The error due to the substep size: steps a scene with the substeps of each quality and with many more, and
// measures how far apart the skins are.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "host/build/steps.h"
#include "host/cli/exit_codes.h"
#include "host/pipeline/build_scene.h"
#include "host/pipeline/device_choice.h"
#include "host/scene/scene.h"

namespace fascicle::cli {

// One way to step the scene, and its distance from the reference over all frames and all render vertices, or
// the body's vertices if there is no skin.
struct SteppedSkin {
  std::string quality;  // "draft", "normal", "final", or "as stated"
  bool is_scenes = false;
  build::Steps steps;
  double rms = 0.0, largest = 0.0;  // m
  std::uint64_t frame = 0;          // with the largest distance
  std::uint32_t vertex = 0;
  double seconds = 0.0;  // in the solver, for the compared frames
};

// If the error falls with the square of the substep, as for BDF2, the reference's own error is a third of
// that measured for the finest quality.
struct Convergence {
  std::string device;
  std::uint64_t frames = 0;
  double extent = 0.0;  // m, the body's largest
  build::Steps reference;
  std::vector<SteppedSkin> skins;  // by number of substeps
};

// Steps all variants together, frame by frame, each from its own preroll and settling, and all without
// viscosity, of which short substeps allow less. Throws UsageError for an explicit scene, whose stiffness
// depends on its substeps; bake::NotFinite.
Convergence measure_convergence(
    const scene::Scene& scene, const Built& built, const ChosenDevice& device, std::uint64_t frames,
    const std::function<void(const std::string& what, std::uint64_t frame, std::uint64_t frames)>& on_frame);

std::string json_text(const Convergence& convergence, const std::string& scene_name);
std::string table_text(const Convergence& convergence);

}  // namespace fascicle::cli
