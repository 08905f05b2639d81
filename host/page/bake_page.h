// Makes a self-contained HTML page of a finished bake. docs/formats.md describes its contents.
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
  std::filesystem::path bake;     // folder of the bake
  std::optional<double> error{};  // m: limit per vertex; none: a 20,000th of the body's extent
  const std::atomic<bool>* interrupted = nullptr;  // polled after each step
  // Steps: each frame is skinned, read and coded.
  std::function<void(std::uint64_t done, std::uint64_t steps)> on_step = {};
};

struct PageResult {
  std::string html;
  bool interrupted = false;                               // if so, no page was made
  std::uint64_t frames = 0, vertices = 0, triangles = 0;  // vertices: of the bake
  double error = 0.0;                                     // m: largest distance of any vertex to the bake
  std::vector<std::string> warnings;
};

// Throws BakeError as export_bake does, and if there is too much for a page; bake::ContradictingOptions if
// the error is less than its grid can achieve.
PageResult page_of_bake(const PageOptions& options);

}  // namespace fascicle::page
