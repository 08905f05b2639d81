// The seam between the frame loop and the formats. Each format is a sink: begin, write each frame, finish.
#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "host/model/model.h"
#include "host/model/solver.h"
#include "host/scene/scene.h"

namespace fascicle::formats {

// How the motion goes into a .glb.
struct GlbOptions {
  std::uint64_t stride = 1;       // a morph target every so many frames, and one at the last; at least 1
  std::optional<double> error{};  // m: instead of the stride, as few targets as keep a viewer, which mixes
                                  // them linearly, this near to every baked frame
  std::optional<double> tolerance{};  // m: vertices nearer than this to plain skinning are left out of a
                                      // target; none: 1e-6 of the body's diagonal
  std::optional<double> compress{};   // m: quantised and compressed, no vertex moved further; none: floats
};
// Morph targets of a bake of `frames` frames after frame 0, at most.
inline std::uint64_t glb_target_count(std::uint64_t frames, const GlbOptions& options) {
  const std::uint64_t stride = std::max<std::uint64_t>(options.stride, 1);
  return (frames + stride - 1) / stride + 1;
}

struct SurfaceObjects;

// What the user is told about finished files.
struct SinkReport {
  std::vector<std::string> notes, warnings;
};
inline void append(SinkReport& to, const SinkReport& more) {
  to.notes.insert(to.notes.end(), more.notes.begin(), more.notes.end());
  to.warnings.insert(to.warnings.end(), more.warnings.begin(), more.warnings.end());
}

struct BakeInfo {
  const model::Model* model = nullptr;
  std::filesystem::path folder;
  std::string scene_name;
  double fps = 60.0;
  double start = 0.0;                     // s, time of frame 0
  std::uint64_t frames = 0;               // after frame 0; frame 0 is written too, so frames + 1 in all
  std::uint64_t first = 0;                // first frame to write: 0, or where a resumed bake goes on
  const model::Frame* initial = nullptr;  // frame 0 with positions, for displacements; outlives the sink
  std::filesystem::path character = {};   // character.glb; empty for bodies that are no characters
  const rig::Character* rig = nullptr;    // the scene's, where the render mesh is its skin; null elsewhere
  // The two frames before `first`, with positions and skinned, the earlier one first; fewer near frame 0.
  std::span<const model::Frame> before = {};
  GlbOptions glb = {};
  std::shared_ptr<const SurfaceObjects> objects = {};  // of the surface; none: read from `character`
  std::uint64_t first_number = 0;  // of frame 0, in names of files, time codes and times of formats
  bool usd_skel = false;           // usda: skinning alone beside the points
};

// Writes one format, frame by frame; no sink holds more than a frame. Files appear whole: written beside
// their place (NAME.part), synced and renamed in finish, or one whole file a frame, which sync names. Only
// the frame cache grows under its own name, in records that carry a checksum. A resumed bake calls begin with
// first > 0: the sink drops what it has of that frame and later ones and goes on; it throws BakeError if
// frames before are missing.
struct FrameSink {
  virtual ~FrameSink() = default;
  virtual std::string name() const = 0;
  virtual model::Read needs() const = 0;
  virtual bool resumes() const { return true; }
  virtual void begin(const BakeInfo& info) = 0;
  virtual void write(const model::Frame& frame) = 0;
  // On return all frames written so far survive a power cut; a checkpoint that counts on them follows.
  virtual void sync() = 0;
  virtual void finish() = 0;
  virtual SinkReport report() const { return {}; }
};

}  // namespace fascicle::formats
