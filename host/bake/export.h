// Writes a finished bake in further formats: sinks are fed from its frame cache and give the same bytes.
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
      {};  // where to; empty: into the bake's own, whose manifest then lists the files
  std::vector<std::string> formats;  // at least one
  formats::GlbOptions glb = {};
  std::optional<std::uint64_t> first_number = {};  // of the range's first frame; without it the bake's own
  bool usd_skel = false;                           // usda: skinning alone beside the points
  bool overwrite = false;                          // replaces files of these names
  const std::atomic<bool>* interrupted = nullptr;  // polled once a frame
  std::function<void(std::uint64_t frame, std::uint64_t frames)> on_frame = {};
};

struct ExportResult {
  std::uint64_t frames = 0;  // after frame 0
  bool interrupted = false;  // then the folder is as it was
  std::vector<std::filesystem::path> files;
  formats::SinkReport report;  // of all formats
  double seconds = 0.0;
};

// Formats that can be made from a bake's folder.
std::vector<std::string> export_format_names();

// An earlier export stays as it is until this one is whole. Throws BakeError (no bake, an unfinished one,
// files in the way), std::system_error (disk); then the folder is as it was.
ExportResult export_bake(const ExportOptions& options);

}  // namespace fascicle::bake
