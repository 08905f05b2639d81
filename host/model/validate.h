// Validation: two solvers get the same drives; every stage of every step is compared bit by bit.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "host/model/solver.h"

namespace fascicle::model {

struct Difference {
  Where where;
  std::uint32_t item = 0;       // vertex, region or render vertex
  std::uint32_t component = 0;  // below stage_width
  float a = 0.0f, b = 0.0f;
  std::uint64_t ulp = 0;  // distance in representable floats; the maximum for NaN against a number
};

// Returns the drive of frame k, k = 1, 2, ...; its spans stay valid until the next call.
using DriveSource = std::function<Drive(std::uint64_t frame)>;

// Steps both solvers together for `frames` frames with a probe and returns the first difference of stage
// outputs or frame buffers, if any. `on_frame` is called after each frame.
std::optional<Difference> first_difference(Solver& a, Solver& b, const DriveSource& drives,
                                           std::uint64_t frames,
                                           const std::function<void(std::uint64_t)>& on_frame = {});

// XXH3-64 of the bits of a frame's positions, in model order.
std::uint64_t position_hash(const Frame& frame);

struct Distance {
  double largest = 0.0, rms = 0.0;  // metres, over all vertices and frames
  std::uint64_t frame = 0;          // where `largest` occurs
  std::uint32_t vertex = 0;
};
// Runs a float solver alongside a reference and measures the distance of positions.
Distance distance_to(const Model& model, Solver& solver, Solver& reference, const DriveSource& drives,
                     std::uint64_t frames);

std::uint64_t ulp_distance(float a, float b);

}  // namespace fascicle::model
