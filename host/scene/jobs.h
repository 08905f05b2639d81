// A list of bakes: what `fascicle batch` reads.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "host/scene/scene.h"

namespace fascicle::scene {

// What became of each job; it lies in `output` among the jobs' folders.
inline constexpr const char* batch_summary = "batch.json";

// One bake.
struct Job {
  std::string name;   // a file name
  std::string scene;  // a file that exists, or a built-in name
  std::string clip;   // empty: the first
  std::vector<std::string> set;
  std::vector<std::string> formats;
  bool keep_frames = true;
};

struct Jobs {
  std::filesystem::path output;  // each job's folder lies in it
  std::vector<Job> jobs;         // in the file's order, names unlike each other
};

// TOML:
//
//   output = "out/walks"             without it out/ and the file's name; relative to the current folder
//   format = ["pc2"]                 of jobs that say none, and so is
//   keep_frames = false
//   [job.fat-man]
//   scene = "fat-man.glb"            relative to the file, or a built-in name
//   clips = ["walk", "jump"]         a bake for each, "all": of all that there are; without it the first
//   set = ["solver.substeps=16"]
//   format = ["glb", "abc"]
//   [job.fat-man.vary]               a bake for each combination of values
//   "layers.fat.alpha" = [0.1, 0.3]
//
// A job's bakes are called after it, its clip and its values where it has several: fat-man-walk-0.1. Throws
// SceneError with line and key.
Jobs read_jobs(const std::filesystem::path& file);

// A clip as --clip takes it, and a file's name for it, unlike those of the others: of "Armature|walk" it is
// "walk".
struct NamedClip {
  std::string clip, file_name;
};
// These clips of a character, all of them where the list is "all". Throws SceneError for one that is not
// there or is named twice, and where there is none.
std::vector<NamedClip> named_clips(const rig::Character& character, const std::vector<std::string>& wanted);

}  // namespace fascicle::scene
