// Several passes over the body in one ("temporal blocking"). A pass is an explicit substep or an implicit
// iteration. Each pass follows the previous one as closely as one-rings allow, and within a pass vertices
// follow regions. So a part of the body goes through several passes while it is in a cache.
//
// A region's map can be computed once the previous pass has moved the vertices of its one-ring. A vertex can
// be moved once the regions of its one-ring are done. One-rings are symmetric: these regions are the only
// ones that read the vertex's position, and only the vertices that a region reads use its map. So passes work
// in place, and each reads the previous pass's results, whatever the order.
//
// For threads the body is split into tiles. In a tile each pass covers fewer slices than the previous one, at
// both ends, so that it needs nothing from other tiles. Joints then cover the rest between tiles, each pass
// more than the previous one (trapezoids: Frigo and Strumpen, "Cache oblivious stencil computations", ICS
// 2005).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "cpu_reference/solver/lane_stages.h"
#include "cpu_reference/solver/slices.h"
#include "cpu_reference/solver/stages.h"
#include "host/model/model.h"

namespace fascicle::cpu_reference {

// The regions' maps, then the vertices that use them: an explicit substep, or an implicit iteration.
struct Pass {
  LaneInput in;
  LaneStage skin;  // before `move`; null: none
  LaneStage region, move;
};

// The slices of regions, and of vertices, that one pass covers in a tile or a joint.
struct Part {
  Range regions, vertices;
};
// One per pass.
using Parts = std::vector<Part>;

struct Sweeps {
  std::vector<Parts> tiles;   // none reads or writes what another writes
  std::vector<Parts> joints;  // after all tiles; each pass of all joints before the next
  bool empty() const { return tiles.empty(); }
  std::uint32_t passes() const { return empty() ? 0 : static_cast<std::uint32_t>(tiles.front().size()); }
};

// Smaller bodies fit in a processor's caches and gain nothing. More passes gain little (bench/README.md).
inline constexpr std::uint32_t fewest_swept_vertices = 50'000, most_swept_passes = 8;

// Sweeps for this number of threads. None if the body has fewer vertices than `fewest`, or if less than half
// of the work would be inside tiles: then passes over the whole body are as fast. The wider the one-rings and
// the more threads, the fewer passes a sweep has.
Sweeps make_sweeps(const model::Model& model, const Slices& slices, unsigned threads,
                   std::uint32_t fewest = fewest_swept_vertices);

// `passes`: at least one, and at most the number of the tile's parts.
void run_tile(const Parts& tile, std::span<const Pass> passes);

// The number of slices of regions, or of vertices, of all joints in a pass.
std::uint32_t slices_of_joints(const Sweeps& sweeps, std::size_t pass, Range Part::*which);
// Runs a stage over the slices in `counted`, numbered from 0 through all joints.
void run_joints(const Sweeps& sweeps, std::size_t pass, Range Part::*which, Range counted, LaneStage stage,
                const LaneInput& in);

}  // namespace fascicle::cpu_reference
