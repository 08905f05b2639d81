// A whole bake, from a scene to its files: what `fascicle bake` and the library's fascicle_bake_run share.
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
  bool writes_nothing = false;  // prepare_bake leaves the folder alone
  // The first takes the bake, and where it fails the next goes on from the last checkpoint. Their
  // cache is build.cache, and without one they keep nothing.
  std::vector<DeviceRequest> devices = {DeviceRequest{}};
  unsigned threads = 0;  // of the CPU solver; 0: one for each core
  build::BuildOptions build = {};
  const std::atomic<bool>* interrupted = nullptr;  // polled once a frame
  std::function<void(std::uint64_t frame, std::uint64_t frames)> on_frame = {};
  std::function<void()> on_lead_in = {};  // before each frame that is stepped before frame 0
};

// What is known before the first frame.
struct PreparedBake {
  scene::Scene scene;
  Built built;
  std::optional<bake::LookBody> look_body;
  std::optional<bake::ExpectedLook> expected;
  std::optional<bake::TriedLook> tried;  // where the estimate comes near the limit or is over it
  std::vector<std::string> warnings;     // for the manifest; they have been said
  Simulation simulation;
  std::size_t devices_tried = 0;  // of the request's; the last of them is the simulation's
};

// Refuses what would fail only at the end, builds, says what can be expected and takes a device. Throws
// scene::SceneError, bake::BakeError, NoSuchDevice, DeviceFailed. In one place, because the solver looks at
// the model.
std::unique_ptr<PreparedBake> prepare_bake(scene::Scene given, const BakeRequest& request, const Say& say);

// Throws what bake::bake throws, and DeviceFailed where no device is left.
bake::BakeResult run_bake(PreparedBake& prepared, const BakeRequest& request, const Say& say);

// What a bake found that its user should know.
void say_result(const bake::BakeResult& result, const Say& say);

// Throws bake::BakeError where the file of an option could not be made, so that it is told before the work
// and not after it. Empty: none was asked for. `folders`: those that are missing will be made.
void refuse_unwritable(const std::string& option, const std::string& file, bool folders = false);

}  // namespace fascicle::pipeline
