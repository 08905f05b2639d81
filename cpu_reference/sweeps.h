// Several passes over the body in one ("temporal blocking"): a substep follows the one before it, and within
// each the vertices follow the regions, as closely as one-rings allow. So a part of the body that is in a
// cache is taken on by several substeps, or iterations, before its memory is left.
//
// A region's map may be made as soon as the vertices of its one-ring have been moved by the pass before, and
// a vertex may be moved as soon as the regions of its one-ring are done. One-rings are symmetric: those are
// at once all the regions that read its position, and all vertices that take a region's map are those that
// it reads. So passes work in place, and each reads what the pass before left, whatever the order.
//
// For threads the body is cut into tiles. In each, every pass does what needs nothing of other tiles: pass by
// pass less, at both ends. Then joints do what is left between them, pass by pass more (trapezoids, Frigo and
// Strumpen, "Cache oblivious stencil computations", ICS 2005).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "cpu_reference/lane_stages.h"
#include "cpu_reference/slices.h"
#include "cpu_reference/stages.h"
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

// Smaller bodies stay in a processor's caches, and gain nothing; more passes bring little (bench/README.md).
inline constexpr std::uint32_t fewest_swept_vertices = 50'000, most_swept_passes = 8;

// Sweeps for so many threads; none where the body has fewer vertices than `fewest`, or where less than half
// of the work would lie inside the tiles: then passes over the whole body do as well. The wider one-rings
// reach and the more threads there are, the fewer passes.
Sweeps make_sweeps(const model::Model& model, const Slices& slices, unsigned threads,
                   std::uint32_t fewest = fewest_swept_vertices);

// At most as many passes as the tile has parts, and not none.
void run_tile(const Parts& tile, std::span<const Pass> passes);

// Slices of regions, or of vertices, that all joints together have in a pass.
std::uint32_t slices_of_joints(const Sweeps& sweeps, std::size_t pass, Range Part::*which);
// A stage over those of them that `counted` numbers, from 0 through all joints.
void run_joints(const Sweeps& sweeps, std::size_t pass, Range Part::*which, Range counted, LaneStage stage,
                const LaneInput& in);

}  // namespace fascicle::cpu_reference
