// The findings of `fascicle report` about a bake's folder, and the page that shows them.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "host/bake/manifest.h"
#include "host/cli/metrics_table.h"
#include "host/cli/rest_pictures.h"
#include "host/cli/worst_frames.h"

namespace fascicle::cli {

// A PNG file and its picture's size.
struct EncodedPicture {
  std::string png;
  unsigned width = 0, height = 0;
};

// A frame, with and without flesh from the same camera.
struct FramePictures {
  std::uint64_t frame = 0;
  double time = 0.0;  // s since frame 0
  EncodedPicture flesh;
  std::optional<EncodedPicture> skinned;  // skinning alone; without a skeleton, the rest shape
};

struct ReportWarning {
  std::string text;
  std::optional<std::uint64_t> frame;  // named by the text, if it exists
};

struct RestReport {
  ShellCounts skin, body;
  EncodedPicture before, after, cut;
  std::vector<std::pair<std::string, std::string>> layers;  // names, and their colours in `cut` as "#rrggbb"
};

struct Report {
  std::string folder;  // as given
  bake::ManifestSummary manifest;
  MetricsTable metrics;
  FrameScores scores;  // empty without metrics
  std::uint64_t frame_count = 0;
  double fps = 0.0;
  bool has_skeleton = false;
  std::vector<FramePictures> pictures;  // each frame once, ascending
  std::vector<std::uint64_t> stills, worst;
  std::vector<ReportWarning> warnings;
  std::optional<RestReport> rest;
  std::string lacks;  // what could not be shown and why; empty if nothing
};

// `manifest`: the raw manifest.json, which may contain anything.
std::string report_page(const Report& report, const nlohmann::ordered_json& manifest);

}  // namespace fascicle::cli
