// Exports a finished bake to further formats: sinks read its frame cache and write the same bytes as during
// the bake.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "host/formats/sink.h"

namespace fascicle::bake {

struct ExportOptions {
  std::filesystem::path bake = {};  // folder of a finished bake
  std::filesystem::path folder =
      {};  // destination; empty: the bake's folder, whose manifest then lists the files
  std::vector<std::string> formats;  // at least one
  formats::GlbOptions glb = {};
  std::optional<std::uint64_t> first_number = {};  // of the range's first frame; absent: as in the bake
  bool usd_skel = false;                           // usda: also the motion by skinning alone
  bool overwrite = false;                          // replaces files with these names
  const std::atomic<bool>* interrupted = nullptr;  // polled once a frame
  std::function<void(std::uint64_t frame, std::uint64_t frames)> on_frame = {};
};

struct ExportResult {
  std::uint64_t frames = 0;  // after frame 0
  bool interrupted = false;  // the folder is then unchanged
  std::vector<std::filesystem::path> files;
  formats::SinkReport report;  // of all formats
  double seconds = 0.0;
};

// Formats that can be made from a bake's folder.
std::vector<std::string> export_format_names();

// An earlier export stays in place until this one is complete. Throws BakeError (no bake, an unfinished one,
// files in the way), std::system_error (disk); the folder is then unchanged.
ExportResult export_bake(const ExportOptions& options);

}  // namespace fascicle::bake
