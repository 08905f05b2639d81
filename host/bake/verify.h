// Reads all of a bake's folder and holds it against its checksums and its manifest.
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
  // Reading ends after the frame at hand once this is true.
  const std::atomic<bool>* interrupted = nullptr;
  std::function<void(std::uint64_t frame, std::uint64_t frames)> on_frame = {};
};

struct VerifiedFile {
  std::string name;     // as the manifest has it
  std::string finding;  // what is good about it, or what is wrong
  bool is_good = true;
};

struct VerifyResult {
  std::string status;  // of the bake, as in its manifest
  std::vector<VerifiedFile> files;
  bool interrupted = false;

  bool is_good() const;
};

// Each frame has its checksum and the manifest's hash of its positions, the model has the hash that the
// frames name, the checkpoint its checksum; metrics have a row a frame, and all that a complete bake lists is
// there. What other programs read is looked for and not read. A bake that is not complete may lack what comes
// later. Throws BakeError where the folder holds no bake.
VerifyResult verify_bake(const VerifyOptions& options);

// Numbers as people write them: 3, 7 to 9. At most so many groups, then "and more".
std::string ranges_text(const std::vector<std::uint64_t>& ascending);

}  // namespace fascicle::bake
