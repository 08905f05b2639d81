// What the length of a substep costs: a scene stepped with the substeps of each quality beside one with many
// more, and how far apart their skins are.
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

// One way to step the scene, and its distance from the reference over the render vertices (the body's, where
// it has no skin) and all frames.
struct SteppedSkin {
  std::string quality;  // "draft", "normal", "final", or "as stated"
  bool is_scenes = false;
  build::Steps steps;
  double rms = 0.0, largest = 0.0;  // m
  std::uint64_t frame = 0;          // of the largest
  std::uint32_t vertex = 0;
  double seconds = 0.0;  // of the solver, for the frames compared
};

// Where the error falls with the square of the substep, as BDF2's does, the reference has a third of what is
// measured of the finest quality.
struct Convergence {
  std::string device;
  std::uint64_t frames = 0;
  double extent = 0.0;  // m, the body's largest
  build::Steps reference;
  std::vector<SteppedSkin> skins;  // by the number of their substeps
};

// Steps all of them together, frame by frame, each from its own preroll and settling. Throws UsageError for
// an explicit scene, whose substeps are a part of its stiffness; bake::NotFinite.
Convergence measure_convergence(
    const scene::Scene& scene, const Built& built, const ChosenDevice& device, std::uint64_t frames,
    const std::function<void(const std::string& what, std::uint64_t frame, std::uint64_t frames)>& on_frame);

std::string json_text(const Convergence& convergence, const std::string& scene_name);
std::string table_text(const Convergence& convergence);

}  // namespace fascicle::cli
