// Input of the tests of single sinks: three frames of a body that is stretched, with known closed forms.
#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <memory>
#include <string>

#include <gtest/gtest.h>

#include "host/formats/sink.h"
#include "host/model/model.h"

namespace fascicle::tests {

inline constexpr std::array<double, 3> sink_origin{12.0, -1.0, 4.0};

// Frame k of a body stretched by s = 1 + k/4 about its first vertex: x -> s x in working units, v = k x.
model::Frame stretched(const model::Model& model, std::uint64_t k);

// Writes frames 0 to 2 at 8 fps, starting at 1.5 s, through one sink.
void write_frames(std::unique_ptr<formats::FrameSink> sink, const model::Model& model,
                  const std::filesystem::path& folder);

// Two right triangles at a right angle, one with twice the area of the other, with a seam along their common
// edge: of the render vertices 0 1 2 and 3 4 5, 0 and 3 coincide, and so do 1 and 4.
model::Model folded_sheet();

template <class T>
T read_value(const std::string& bytes, std::size_t offset) {
  T value{};
  EXPECT_LE(offset + sizeof value, bytes.size());
  if (offset + sizeof value > bytes.size()) return value;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

}  // namespace fascicle::tests
