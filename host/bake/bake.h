// The frame loop: bakes a scene with its model and a solver into a folder; can be resumed.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "host/bake/expected_look.h"
#include "host/bake/look_report.h"
#include "host/base/errors.h"
#include "host/drive/lead_in.h"
#include "host/formats/sink.h"
#include "host/model/model.h"
#include "host/model/solver.h"
#include "host/scene/scene.h"

namespace fascicle::bake {

using base::BakeError;

// The -o folder holds a bake and neither overwrite nor resume was given, or another process writes there: a
// usage error.
struct FolderInUse : BakeError {
  using BakeError::BakeError;
};
// The options contradict each other: a usage error.
struct ContradictingOptions : BakeError {
  using BakeError::BakeError;
};
// The positions are no longer finite; names the frame and the first vertex.
struct NotFinite : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// What the manifest says about where the bake ran.
struct DeviceDescription {
  std::string solver;  // "cpu" or "vulkan"
  std::string name, driver;
  std::string float_controls;
  bool exact = true;  // self-test passed
  unsigned threads = 0;
};

// An opening in a character's skin, and how its body was made there.
struct OpenEndEntry {
  std::string joint;   // the one that moves most of it; empty: none
  std::string became;  // in words
  double width = 0.0;  // m
  std::uint32_t edges = 0;
  std::uint32_t vertex = 0;  // one of its vertices, in the welded skin
};

// What to write and where, as passed from the caller to the formats.
struct BakeOutput {
  std::filesystem::path folder;
  std::vector<std::string> formats;  // of format_names(), or no_format alone (options.h)
  // Without them nothing can be exported or drawn later. A bake always has them until it is complete.
  bool keep_frames = true;
  formats::GlbOptions glb = {};
  // Number of the range's first frame in files for other programs; without it frame 0 has number 0. Our own
  // files always count from 0.
  std::optional<std::uint64_t> first_number = {};
  bool usd_skel = false;   // usda: also the motion by skinning alone
  bool overwrite = false;  // removes only files that a bake made in the folder
  bool resume = false;     // continues from the last checkpoint; starts afresh if there is none
};

struct BakeOptions : BakeOutput {
  std::optional<std::uint32_t> substeps = {};    // per frame; absent: from the scene
  std::optional<std::uint32_t> iterations = {};  // per substep; absent: from the scene, else 20
  // A checkpoint is written after this many frames (at least 1), or often enough that at most this time's
  // work is lost, whichever comes first; a frame that takes longer gets its own.
  std::uint64_t checkpoint_frames = std::numeric_limits<std::uint64_t>::max();
  double checkpoint_seconds = 0.5;
  DeviceDescription device;
  std::vector<std::string> warnings;          // from the build, for the manifest
  std::vector<OpenEndEntry> open_ends;        // in the skin, for the manifest
  std::optional<ExpectedLook> expected_look;  // for the manifest
  std::optional<TriedLook> tried_look;        // for the manifest
  const LookBody* look_body = nullptr;        // look_body_of, if the caller has it
  std::string contact_left_out = {};  // why contact.self is, if contact.unless_torn decided so; else empty
  const std::atomic<bool>* interrupted = nullptr;  // polled once a frame
  // Called when a frame has been simulated; it and the one before it may not be written yet.
  std::function<void(std::uint64_t frame, std::uint64_t frames)> on_frame;
  // Called before each frame that is simulated before frame 0.
  std::function<void()> on_lead_in;
  // A store of states at frame 0, by a key of hex digits: a scene that was baked before need not simulate the
  // lead-in again. The bits are the same. Without these functions nothing is stored.
  std::function<std::optional<std::string>(const std::string& key)> find_start;
  std::function<void(const std::string& key, std::string_view bytes)> keep_start;
};

// Regions whose stretch of equation (17) was limited to [0.25, 4]: the largest count in one frame, and that
// frame.
struct ClampedMuscles {
  std::uint64_t regions = 0, frame = 0;
};

struct BakeResult {
  std::uint64_t frames_done = 0;  // of frame_count(scene)
  bool interrupted = false;
  std::vector<std::filesystem::path> files;
  std::vector<std::string> missing_images;  // in the character; drawn as white pixels
  std::string last_position_hash;
  drive::LeadInSummary lead_in;
  std::optional<double>
      loop_jump;  // m: in a seamless loop, the largest distance between a vertex's end and its start
  ClampedMuscles clamped;
  std::optional<LookSummary> look;  // for a finished bake of a character
  formats::SinkReport report;       // of all formats
  double seconds_solver = 0.0, seconds_writing = 0.0, seconds_total = 0.0;
};

// The number of frame 0 if the range's first frame has number `first_of_range`. Throws BakeError if handles
// would get numbers below 0.
std::uint64_t first_written(std::uint64_t first_of_range, std::uint64_t handles);

// The number of frame 0. Throws BakeError as first_written does.
std::uint64_t number_of_first(const scene::Scene& scene, const BakeOutput& output);

// Per frame and per substep: from the options, else from the scene.
std::uint32_t substeps_of(const scene::Scene& scene, const BakeOptions& options);
std::uint32_t iterations_of(const scene::Scene& scene, const BakeOptions& options);

// Runs the bake. Throws BakeError, NotFinite, std::system_error (disk) and what the solver throws. If it ends
// early, the frame cache keeps every whole frame, there is a checkpoint to resume from, and the manifest says
// why the bake ended and in which frame.
BakeResult bake(const scene::Scene& scene, const model::Model& model, model::Solver& solver,
                const BakeOptions& options);

}  // namespace fascicle::bake
