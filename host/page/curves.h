// The columns of metrics.csv that a page plots along the timeline.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace fascicle::page {

struct Curve {
  std::string name, unit;
  std::vector<std::optional<double>> values;  // one per frame; nullopt where the file has no number
  std::optional<double> limit;                // values above it are too large
};

// The curves of a bake with `frames` frames; empty if it has no metrics. Leaves out curves that are 0
// everywhere. Throws BakeError if there are too many columns, or values in all.
std::vector<Curve> read_curves(const std::filesystem::path& folder, std::uint64_t frames);

}  // namespace fascicle::page
