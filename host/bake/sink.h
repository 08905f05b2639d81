// The seam between the frame loop and what is written: one sink a format.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "host/model/model.h"
#include "host/model/solver.h"

namespace fascicle::bake {

struct BakeInfo {
  const model::Model* model = nullptr;
  std::filesystem::path folder;
  std::string scene_name;
  double fps = 60.0;
  double start = 0.0;               // s, time of frame 0
  std::uint64_t frames = 0;         // after frame 0; frame 0 is written too, so frames + 1 in all
  std::uint64_t first = 0;          // first frame to write: 0, or where a resumed bake goes on
};

// Writes one format. Files appear whole (written beside their place, synced, renamed in finish) or, for the frame cache,
// frame by frame. A resumed bake calls begin with first > 0; a sink that cannot append says so by can_resume() = false and is
// then fed all frames again from the cache.
struct FrameSink {
  virtual ~FrameSink() = default;
  virtual std::string name() const = 0;
  virtual model::Read needs() const = 0;
  virtual void begin(const BakeInfo& info) = 0;
  virtual void write(const model::Frame& frame) = 0;
  virtual void finish() = 0;
};

}  // namespace fascicle::bake
