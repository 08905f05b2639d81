// Reads all of a bake's folder and checks it against its checksums and its manifest.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace fascicle::bake {

struct VerifyOptions {
  std::filesystem::path bake;
  // Reading ends after the current frame once this is true.
  const std::atomic<bool>* interrupted = nullptr;
  std::function<void(std::uint64_t frame, std::uint64_t frames)> on_frame = {};
};

struct VerifiedFile {
  std::string name;     // as in the manifest
  std::string finding;  // what was verified, or what is wrong
  bool is_good = true;
};

struct VerifyResult {
  std::string status;  // of the bake, as in its manifest
  // Whether a process of this computer is writing there. If none does, "running" was left by a bake that was
  // killed, unless it runs on another computer.
  bool in_use_here = false;
  std::vector<VerifiedFile> files;
  bool interrupted = false;

  bool is_good() const;
};

// Checks the checksum of each frame and the manifest's hash of its positions, the model against the hash in
// the frames, and the checkpoint's checksum; metrics must have a row per frame, and everything that a
// complete bake lists must exist. Files for other programs are not read, but none may be empty, folders must
// have a file per frame, point caches their length, and what an OBJ refers to must be there. An unfinished
// bake may lack files that come later. Throws BakeError if the folder holds no bake.
VerifyResult verify_bake(const VerifyOptions& options);

// Numbers as ranges in text: 3, 7 to 9. At most 12 groups, then "and more".
std::string ranges_text(const std::vector<std::uint64_t>& ascending);

}  // namespace fascicle::bake
