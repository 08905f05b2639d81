// The interface between the frame loop and the formats. Each format is a sink: begin, write each frame,
// finish.
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

// How a .glb stores the motion.
struct GlbOptions {
  std::uint64_t stride = 1;           // a morph target every `stride` frames, and one at the last; at least 1
  std::optional<double> error{};      // m: replaces the stride; as few targets as keep a viewer's linear
                                      // interpolation within this distance of every baked frame
  std::optional<double> tolerance{};  // m: vertices nearer than this to plain skinning are left out of a
                                      // target; none: 1e-6 of the body's diagonal
  std::optional<double> compress{};   // m: quantise and compress, moving no vertex further; none: floats
};
// The most morph targets that a bake of `frames` frames after frame 0 can have.
inline std::uint64_t glb_target_count(std::uint64_t frames, const GlbOptions& options) {
  const std::uint64_t stride = std::max<std::uint64_t>(options.stride, 1);
  return (frames + stride - 1) / stride + 1;
}

struct SurfaceObjects;

// Messages for the user about finished files.
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
  std::uint64_t frames = 0;               // not counting frame 0, which is written too: frames + 1 in all
  std::uint64_t first = 0;                // first frame to write: 0, or where a resumed bake continues
  const model::Frame* initial = nullptr;  // frame 0 with positions, for displacements; outlives the sink
  std::filesystem::path character = {};   // character.glb; empty for bodies that are not characters
  const rig::Character* rig = nullptr;    // the scene's, if the render mesh is its skin; else null
  // The two frames before `first`, with positions and skinned positions, earlier one first; fewer near frame
  // 0.
  std::span<const model::Frame> before = {};
  GlbOptions glb = {};
  std::shared_ptr<const SurfaceObjects> objects = {};  // of the surface; none: read from `character`
  std::uint64_t first_number = 0;  // number of frame 0 in file names, time codes and times
  bool usd_skel = false;           // usda: also write plain skinning as UsdSkel
};

// Writes one format, frame by frame; no sink keeps all frames in memory. Files appear complete: they are
// written as NAME.part, then synced and renamed in finish; with one file per frame, sync renames them. Only
// the frame cache grows under its final name, in checksummed records. A resumed bake calls begin with first >
// 0: the sink drops that frame and later ones and continues; it throws BakeError if earlier frames are
// missing.
struct FrameSink {
  virtual ~FrameSink() = default;
  virtual std::string name() const = 0;
  virtual model::Read needs() const = 0;
  virtual bool resumes() const { return true; }
  virtual void begin(const BakeInfo& info) = 0;
  virtual void write(const model::Frame& frame) = 0;
  // After this, all frames written so far survive a power cut; the bake loop then writes a checkpoint that
  // relies on them.
  virtual void sync() = 0;
  virtual void finish() = 0;
  virtual SinkReport report() const { return {}; }
};

}  // namespace fascicle::formats
