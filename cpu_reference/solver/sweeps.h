// Several passes over the body in one ("temporal blocking"). A pass is an explicit substep or an implicit
// iteration. Each pass follows the one before it as closely as one-rings allow, and within a pass vertices
// follow regions. So a part of the body takes several passes while it is in a cache.
//
// A region's map may be made as soon as the pass before has moved the vertices of its one-ring. A vertex may
// be moved as soon as the regions of its one-ring are done. One-rings are symmetric: these regions are all
// that read the vertex's position, and only the vertices that a region reads take its map. So passes work in
// place, and each reads what the pass before left, whatever the order.
//
// For threads the body is cut into tiles. In a tile each pass covers fewer slices than the one before, at
// both ends, so that it needs nothing of other tiles. Then joints cover the rest between tiles, each pass
// more than the one before (trapezoids: Frigo and Strumpen, "Cache oblivious stencil computations", ICS
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

// The regions' maps, then the vertices that take them: an explicit substep, or an implicit iteration.
struct Pass {
  LaneInput in;
  LaneStage skin;  // before `move`; null: none
  LaneStage region, move;
};

// Slices of regions, and of vertices, that one pass does of a tile or a joint.
struct Part {
  Range regions, vertices;
};
// One for each pass.
using Parts = std::vector<Part>;

struct Sweeps {
  std::vector<Parts> tiles;   // none reads or writes what another writes
  std::vector<Parts> joints;  // after all tiles, and all of them a pass before the next
  bool empty() const { return tiles.empty(); }
  std::uint32_t passes() const { return empty() ? 0 : static_cast<std::uint32_t>(tiles.front().size()); }
};

// Smaller bodies stay in a processor's caches and gain nothing. More passes gain little (bench/README.md).
inline constexpr std::uint32_t fewest_swept_vertices = 50'000, most_swept_passes = 8;

// Sweeps for so many threads. None where the body has fewer vertices than `fewest`, or where less than half
// of the work would lie inside the tiles: then passes over the whole body are as fast. The wider one-rings
// reach and the more threads there are, the fewer passes a sweep has.
Sweeps make_sweeps(const model::Model& model, const Slices& slices, unsigned threads,
                   std::uint32_t fewest = fewest_swept_vertices);

// `passes`: at least one, and at most as many as the tile has parts.
void run_tile(const Parts& tile, std::span<const Pass> passes);

// Slices of regions, or of vertices, that all joints together have in a pass.
std::uint32_t slices_of_joints(const Sweeps& sweeps, std::size_t pass, Range Part::*which);
// A stage over those of them that `counted` numbers, from 0 through all joints.
void run_joints(const Sweeps& sweeps, std::size_t pass, Range Part::*which, Range counted, LaneStage stage,
                const LaneInput& in);

}  // namespace fascicle::cpu_reference
