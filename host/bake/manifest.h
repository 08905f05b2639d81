// manifest.json: everything about a bake that its other files do not contain.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "host/bake/bake.h"
#include "host/bake/identity.h"
#include "host/bake/look_report.h"
#include "host/model/model.h"
#include "host/scene/scene.h"

namespace fascicle::bake {

inline constexpr const char* manifest_name = "manifest.json";

enum class Status { running, interrupted, not_finite, failed, complete };
const char* name_of(Status status);

struct Timings {
  double solver = 0.0, writing = 0.0, total = 0.0;  // s, over all runs
  std::uint64_t runs = 1;                           // 1 + times resumed
};

struct Progress {
  Status status = Status::running;
  std::string message;  // for Status::not_finite and Status::failed
  bool frames_kept = true;
  std::vector<std::uint64_t> position_hashes;  // of frames 0, 1, ... written so far (model::position_hash)
  Timings timings;
  drive::LeadInSummary lead_in;
  ClampedMuscles clamped;
  std::optional<LookSummary> look;    // for a complete bake of a character
  std::optional<double> loop_jump;    // m, for a complete seamless loop
  std::vector<std::string> warnings;  // besides those of BakeOptions and the look
  std::vector<std::string> exported;  // files that `fascicle export` added to the bake's folder
};

// The files of a bake with these formats, the manifest first; a name that ends in / is a folder of frames.
std::vector<std::string> file_names(const model::Model& model, const std::vector<std::string>& formats);
// All names that any bake may write.
std::vector<std::string> all_file_names();

std::string manifest_text(const scene::Scene& scene, const model::Model& model, const BakeOptions& options,
                          std::uint64_t model_hash, const Progress& progress);

// What a later bake reads from the manifest.
struct ManifestSummary {
  std::vector<std::string> files;
  std::string status, message;
  bool frames_kept = true;  // false only for a complete bake
  std::string device;       // the solver and the device's name
  std::uint64_t frames_done = 0, frames = 0;
  std::vector<std::string> warnings;
  // As in scene::Scene: enough to read the scene again while its inputs are still in place.
  std::string scene_name, scene_source, scene_text;
  std::vector<std::pair<std::string, std::string>> input_hashes;
  std::vector<std::string> position_hashes;  // of frames 0, 1, ..., as hexadecimal digits
  std::string last_position_hash;            // empty before frame 0
  std::optional<double> fps;                 // NaN if the entry is not a number
  std::uint64_t first_number = 0;            // number of frame 0 in files for other programs
  std::uint64_t handles = 0;                 // frames before the range, and as many after it
  Timings timings;
  drive::LeadInSummary lead_in;
  ClampedMuscles clamped;
};
// The message if the frames of a bake are needed but were not kept.
std::string frames_not_kept_text(const std::filesystem::path& folder);

// Empty if the folder has no manifest, or it is not one of fascicle, or is damaged.
std::optional<ManifestSummary> read_manifest(const std::filesystem::path& folder);
// For a folder that must hold a bake. Throws BakeError if there is none.
ManifestSummary manifest_of(const std::filesystem::path& folder);
// The names under "files", which may be any. From a damaged manifest, those of our own names that can still
// be read, so that its bake can be replaced.
std::vector<std::string> files_listed(const std::filesystem::path& folder);

// Sets the bake's status in the existing manifest; everything else stays as the last checkpoint left it.
// Needs no additional space on a full disk. Throws std::system_error if even that fails.
void set_status(const std::filesystem::path& folder, Status status, const std::string& message);

// The same for a bake that resumes from this frame; no longer counts later frames, which will be written
// again.
void set_running_from(const std::filesystem::path& folder, std::uint64_t frame);

// Adds to the list of files, atomically; the rest stays as it is. Throws BakeError without a manifest.
void add_to_manifest(const std::filesystem::path& folder, const std::vector<std::string>& files);

}  // namespace fascicle::bake
