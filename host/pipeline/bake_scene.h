// A whole bake, from a scene to its files: shared by `fascicle bake` and the library's fascicle_bake_run.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/bake/bake.h"
#include "host/bake/expected_look.h"
#include "host/pipeline/build_scene.h"
#include "host/pipeline/device_choice.h"
#include "host/pipeline/messages.h"
#include "host/scene/scene.h"

namespace fascicle::pipeline {

struct BakeRequest {
  bake::BakeOutput output;
  bool writes_nothing = false;  // prepare_bake does not check the folder
  // The first device runs the bake; if it fails, the next continues from the last checkpoint. Devices use the
  // cache in build.cache; without one they cache nothing.
  std::vector<DeviceRequest> devices = {DeviceRequest{}};
  unsigned threads = 0;  // for the CPU solver; 0: one per core
  build::BuildOptions build = {};
  const std::atomic<bool>* interrupted = nullptr;  // polled once a frame
  std::function<void(std::uint64_t frame, std::uint64_t frames)> on_frame = {};
  std::function<void()> on_lead_in = {};  // before each frame simulated before frame 0
};

// What is known before the first frame.
struct PreparedBake {
  scene::Scene scene;
  Built built;
  std::optional<bake::LookBody> look_body;
  std::optional<bake::ExpectedLook> expected;
  // If the estimate comes near the limit or exceeds it; else of the last trial of contact, if there was one.
  std::optional<bake::TriedLook> tried;
  std::string contact_left_out = {};  // BakeOptions::contact_left_out
  bool is_undecided = false;          // interrupted before all was decided: run_bake does nothing
  std::vector<std::string> warnings;  // for the manifest; already shown
  Simulation simulation;
  std::size_t devices_tried = 0;  // of the request's; the simulation uses the last of them
};

// Checks early what would otherwise fail only at the end, builds, reports what to expect and chooses a
// device. Throws scene::SceneError, bake::BakeError, NoSuchDevice, DeviceFailed. Returned by pointer, because
// the solver refers to the model inside.
std::unique_ptr<PreparedBake> prepare_bake(scene::Scene given, const BakeRequest& request, const Say& say);

// Throws what bake::bake throws, and DeviceFailed if no device is left.
bake::BakeResult run_bake(PreparedBake& prepared, const BakeRequest& request, const Say& say);

// Reports what the user should know about a finished bake.
void say_result(const bake::BakeResult& result, const Say& say);

// Throws bake::BakeError if an option's output file could not be created, so that the user learns it before
// the work. An empty `file` means none was requested. `folders`: missing folders will be created.
void refuse_unwritable(const std::string& option, const std::string& file, bool folders = false);

}  // namespace fascicle::pipeline
