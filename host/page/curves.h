// What of metrics.csv a page draws over the time line.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace fascicle::page {

struct Curve {
  std::string name, unit;
  std::vector<std::optional<double>> values;  // one a frame; nothing where the file has no number
  std::optional<double> limit;                // above it is too much
};

// Of a bake of so many frames; none where it has no metrics. Curves that are 0 all along are left out.
std::vector<Curve> read_curves(const std::filesystem::path& folder, std::uint64_t frames);

}  // namespace fascicle::page
