// One self-contained HTML page of a finished bake. docs/formats.md describes what it holds.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace fascicle::page {

struct PageOptions {
  std::filesystem::path bake;     // folder of a finished bake
  std::optional<double> error{};  // m: no vertex is moved further; none: a 20,000th of the body's extent
  const std::atomic<bool>* interrupted = nullptr;  // polled once a frame
  std::function<void(std::uint64_t frame, std::uint64_t frames)> on_frame = {};
};

struct PageResult {
  std::string html;
  bool interrupted = false;                               // then there is no page
  std::uint64_t frames = 0, vertices = 0, triangles = 0;  // vertices: as the bake has them
  double error = 0.0;                                     // m: no vertex of no frame is further from the bake
  std::vector<std::string> warnings;
};

// Throws BakeError as export_bake does, and where there is too much for a page; bake::ContradictingOptions
// where the error is less than its grid can keep to.
PageResult page_of_bake(const PageOptions& options);

}  // namespace fascicle::page
