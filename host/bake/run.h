// A bake in progress: the steps of bake(), from the folder (run_begin.cpp) through the frames to the manifest
// (bake.cpp).
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/bake/bake.h"
#include "host/bake/checkpoint.h"
#include "host/bake/folder.h"
#include "host/bake/identity.h"
#include "host/bake/manifest.h"
#include "host/bake/stopwatch.h"
#include "host/drive/drive_source.h"
#include "host/formats/shaped_surface.h"
#include "host/formats/sink.h"

namespace fascicle::bake {

// What the manifest says about the loop at one frame, while the loop is already ahead of it.
struct Moment {
  ClampedMuscles clamped;
  double seconds_solver = 0.0;
};

class Run {
 public:
  Run(const scene::Scene& scene, const model::Model& model, model::Solver& solver,
      const BakeOptions& options);

  BakeResult go();
  // Writes the reason to the manifest, if it is this run's.
  void note_failure(const std::string& reason) const;

 private:
  void open_folder();
  std::optional<Checkpoint> checkpoint_to_resume();
  bool check_kept(std::uint64_t last);
  std::optional<BakeResult> done_without_frames();
  std::optional<BakeResult> done_before(const Checkpoint& last);
  void begin_other_files(const Checkpoint& from);
  BakeResult summary() const;
  model::State lead_to_start();
  // `resumed`: null if the bake starts at frame 0. False if interrupted; the folder can then be resumed as
  // before.
  bool begin_sinks(const Checkpoint* resumed);
  bool starts_anew(const formats::Format& format, const formats::FrameSink& sink) const;
  std::vector<model::Frame> frames_before(std::uint64_t first) const;
  void step_frames(std::uint64_t first);
  Moment moment() const { return {clamped_, seconds_solver_}; }
  void note_clamped(const model::Drive& drive, std::uint64_t frame);
  [[noreturn]] void refuse_not_finite(const model::Frame& frame);
  void write(const model::Frame& frame);
  void checkpoint(const model::State& state, const Moment& moment);
  bool was_stopped() const { return options_.interrupted != nullptr && options_.interrupted->load(); }
  bool manifest_due() const;
  void take_look();
  void save_manifest(Status status, const Moment& moment);
  std::filesystem::path path_of(const char* name) const { return options_.folder / name; }

  const scene::Scene& scene_;
  const model::Model& model_;
  model::Solver& solver_;
  const BakeOptions options_;
  const std::uint64_t frames_;
  const std::uint64_t model_hash_;
  const Identity identity_;
  drive::DriveSource drives_;

  std::optional<FolderLock> lock_;
  model::Frame initial_;
  std::optional<formats::ShapedSurface> shapes_;
  std::vector<std::unique_ptr<formats::FrameSink>> sinks_;
  model::Read needs_;
  std::array<std::vector<float>, 2> skinned_;  // of the last two frames written; empty if no look is measured
  Progress progress_;
  ClampedMuscles clamped_;
  Timings before_;  // of earlier runs
  double seconds_solver_ = 0.0, seconds_writing_ = 0.0;
  std::atomic<double> seconds_to_sync_ = 0.0;  // of the last checkpoint
  std::size_t frames_in_manifest_ = 0;
  bool interrupted_ = false;
  // For a resumed bake: whether its files change, and which formats are rewritten from frame 0.
  bool files_change_ = false;
  std::vector<std::string> anew_;
  bool has_begun_ = false;  // from then on the manifest in the folder is this run's
  formats::SinkReport report_;
  std::vector<std::string> missing_images_;
  const Clock::time_point start_ = Clock::now();
};

}  // namespace fascicle::bake
