// A list of bakes, as read by `fascicle batch`.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "host/scene/scene.h"

namespace fascicle::scene {

// The result of each job, written to `output` next to the jobs' folders.
inline constexpr const char* batch_summary = "batch.json";

// Whether a bake of a list, or a clip's, can have this name. Its folder in `output` is called so: it is no
// path to elsewhere, not hidden, and not that of the result.
bool is_job_name(std::string_view name);

// One bake.
struct Job {
  std::string name;   // is_job_name
  std::string scene;  // an existing file, or a built-in name
  std::string clip;   // empty: the first
  std::vector<std::string> set;
  std::vector<std::string> formats;
  bool keep_frames = true;
};

struct Jobs {
  std::filesystem::path output;  // contains each job's folder
  std::vector<Job> jobs;         // in the file's order, with unique names
};

// TOML:
//
//   output = "out/walks"             relative to the current folder; default: out/ and the file's name
//   format = ["pc2"]                 for jobs without their own format
//   keep_frames = false              for jobs without their own value
//   [job.fat-man]
//   scene = "fat-man.glb"            relative to the file, or a built-in name
//   clips = ["walk", "jump"]         a bake for each; "all": for every clip; default: the first clip
//   set = ["solver.substeps=16"]
//   format = ["glb", "abc"]
//   [job.fat-man.vary]               a bake for each combination of values
//   "layers.fat.alpha" = [0.1, 0.3]
//
// A bake is named after its job, plus its clip and its values if there are several: fat-man-walk-0.1. Throws
// SceneError with line and key.
Jobs read_jobs(const std::filesystem::path& file);

// A clip in the form --clip takes, and a unique file name for it: "Armature|walk" becomes "walk".
struct NamedClip {
  std::string clip, file_name;
};
// The named clips of a character, or all of them if the list is "all". Throws SceneError if a clip does not
// exist or is named twice, or if the character has none.
std::vector<NamedClip> named_clips(const rig::Character& character, const std::vector<std::string>& wanted);

}  // namespace fascicle::scene
